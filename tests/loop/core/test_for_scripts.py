"""Messages are written in the words of the command line; a script reads its own arguments."""

import pytest

import hfc_design.api as hfc
from hfc_design.controllers.neural.training import Lesson

RAMP = hfc.load_scenario("c-axis-ramp", {"simulation.duration_s": 0.1})


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: hfc.robustness("pd-only", RAMP, 0.2, 0), "samples=0: has to lie between 1 and"),
        (lambda: hfc.robustness("pd-only", RAMP, 2.0, 5), "spread=2.0: has to lie between 0"),
        (
            lambda: hfc.compare(["pd-only", "lin-lee-1999-table-2"], machines=0),
            "machines=0: has to",
        ),
        (lambda: hfc.load_design("pd-only", ["x"]), "changes: x: has to look like KEY=VALUE"),
        (lambda: hfc.load_scenario(RAMP, {"name.b": 5}), "changes={'name.b': 5}: name is not a"),
        (lambda: hfc.explain("jee-koren-2004-flc", "x"), "sample: 'x': has to be SIGNAL=NUMBER"),
        (lambda: hfc.picture("lin-lee-1999-table-2", "surface", "u"), "unit='u': surface of"),
        (lambda: hfc.identify("x.csv"), r"which machine is it\? say plant=, scenario= or cont"),
        (lambda: hfc.identify("x.csv", "c-axis", axis="x"), "axis='x': c-axis has only one"),
        (lambda: hfc.load_scenario({"name": "a", "plant": {"name": "b"}}), ".*hfc.register"),
    ],
)
def test_a_mistake_of_a_script_names_its_argument(call, told):
    with pytest.raises(hfc.UserError, match=f"^{told}") as refused:
        call()
    assert "--" not in str(refused.value)


TWO = ["pd-only", "lin-lee-1999-table-2"]
WHOLE, NUMBER, SHARE = (
    "has to be a whole number",
    "has to be a number",
    "has to lie between 0 and 1",
)


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: hfc.usable("pd-only", RAMP, machines=0), "machines=0: has to lie between 1 and"),
        (lambda: hfc.usable("pd-only", RAMP, machines=-3), "machines=-3: has to lie between 1"),
        (lambda: hfc.usable("pd-only", RAMP, machines="20"), f"machines='20': {WHOLE}"),
        (lambda: hfc.usable("pd-only", RAMP, spread=-1), f"spread=-1: {SHARE}"),
        (lambda: hfc.usable("pd-only", RAMP, seed=1.5), f"seed=1.5: {WHOLE}"),
        (lambda: hfc.compare(TWO, machines="20"), f"machines='20': {WHOLE}"),
        (lambda: hfc.compare(TWO, spread="a"), f"spread='a': {NUMBER}"),
        (lambda: hfc.compare(TWO, spread=float("nan")), "spread=nan: has to be a finite number"),
        (lambda: hfc.compare(TWO, seed=-1), "seed=-1: has to be 0 or more"),
        (
            lambda: hfc.compare(TWO, tolerances={"backlash": 5}),
            f"tolerances={{'backlash': 5}}: {SHARE}",
        ),
        (lambda: hfc.robustness("pd-only", RAMP, 0.2, True), f"samples=True: {WHOLE}"),
        (lambda: hfc.robustness("pd-only", RAMP, 0.2, 5, tolerances=5), "an int is no table of"),
        (lambda: hfc.batch("x.toml", workers=2.0), f"workers=2.0: {WHOLE}"),
        (lambda: hfc.pick("x", "3"), f"point='3': {WHOLE}"),
        (lambda: hfc.identify("x.csv", "c-axis", bandwidth="5"), f"bandwidth='5': {NUMBER}"),
        (
            lambda: hfc.identify("x.csv", "c-axis", bandwidth=-5.0),
            r"bandwidth=-5.0: has to be greater than 0",
        ),
        (
            lambda: hfc.identify("x.csv", "c-axis", sample_time=0),
            "sample_time=0: has to be greater",
        ),
        (lambda: hfc.identify("x.csv", "c-axis", seed=None), f"seed=None: {WHOLE}"),
        (lambda: hfc.stability(gain="x"), f"gain='x': {NUMBER}"),
        (lambda: hfc.stability(time_constant=0), "time_constant=0: has to be greater than 0"),
        (lambda: hfc.import_("x.fis", sample_time="x"), f"sample_time='x': {NUMBER}"),
        (lambda: hfc.import_("x.fis", terms=(9, 50)), "terms=50: has to lie between 2 and 11"),
        (lambda: hfc.import_("x.fis", terms=7), "an int is no pair of numbers of terms"),
        (lambda: hfc.taught("pd-only", RAMP, lesson=5), "an int is no lesson"),
        (lambda: hfc.taught("pd-only", RAMP, lesson=Lesson(passes=1.5)), f"passes=1.5: {WHOLE}"),
        (lambda: hfc.taught("pd-only", RAMP, lesson=Lesson(rate="x")), f"rate='x': {NUMBER}"),
    ],
)
def test_a_number_that_is_none_is_a_line_and_no_traceback(call, told):
    with pytest.raises(hfc.UserError) as refused:
        call()
    assert str(refused.value).startswith(told)
    assert "\n" not in str(refused.value)
