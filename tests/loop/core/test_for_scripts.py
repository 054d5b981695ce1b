"""Messages are written in the words of the command line; a script reads its own arguments."""

import pytest
from wording import refused

import hfc_design.api as hfc
from hfc_design.controllers.neural.record import Lesson

RAMP = hfc.load_scenario("c-axis-ramp", {"simulation.duration_s": 0.1})
TWO = ["pd-only", "lin-lee-1999-table-2"]


@pytest.mark.parametrize(
    ("call", "where"),
    [
        (lambda: hfc.robustness("pd-only", RAMP, 0.2, 0), "samples=0"),
        (lambda: hfc.robustness("pd-only", RAMP, 2.0, 5), "spread=2.0"),
        (lambda: hfc.compare(["pd-only", "lin-lee-1999-table-2"], machines=0), "machines=0"),
        (lambda: hfc.load_design("pd-only", ["x"]), "changes: x"),
        (lambda: hfc.load_scenario(RAMP, {"name.b": 5}), "changes={'name.b'"),
        (lambda: hfc.explain("jee-koren-2004-flc", "x"), "sample: "),
        (lambda: hfc.picture("lin-lee-1999-table-2", "surface", "u"), "unit='u'"),
        (
            lambda: hfc.identify("x.csv"),
            "the machine is missing; give plant=, scenario= or",
        ),
        (lambda: hfc.identify("x.csv", "c-axis", axis="x"), "axis='x'"),
        (lambda: hfc.load_scenario({"name": "a", "plant": {"name": "b"}}), ""),
        (lambda: hfc.usable("pd-only", RAMP, machines=0), "machines=0"),
        (lambda: hfc.usable("pd-only", RAMP, machines=-3), "machines=-3"),
        (lambda: hfc.usable("pd-only", RAMP, machines="20"), "machines='20'"),
        (lambda: hfc.usable("pd-only", RAMP, spread=-1), "spread=-1"),
        (lambda: hfc.usable("pd-only", RAMP, seed=1.5), "seed=1.5"),
        (lambda: hfc.compare(TWO, machines="20"), "machines='20'"),
        (lambda: hfc.compare(TWO, spread="a"), "spread='a'"),
        (lambda: hfc.compare(TWO, spread=float("nan")), "spread=nan"),
        (lambda: hfc.compare(TWO, seed=-1), "seed=-1"),
        (lambda: hfc.compare(TWO, tolerances={"backlash": 5}), "tolerances={'backlash': 5}"),
        (lambda: hfc.robustness("pd-only", RAMP, 0.2, True), "samples=True"),
        (lambda: hfc.robustness("pd-only", RAMP, 0.2, 5, tolerances=5), ""),
        (lambda: hfc.batch("x.toml", workers=2.0), "workers=2.0"),
        (lambda: hfc.pick("x", "3"), "point='3'"),
        (lambda: hfc.identify("x.csv", "c-axis", bandwidth="5"), "bandwidth='5'"),
        (lambda: hfc.identify("x.csv", "c-axis", bandwidth=-5.0), "bandwidth=-5.0"),
        (lambda: hfc.identify("x.csv", "c-axis", sample_time=0), "sample_time=0"),
        (lambda: hfc.identify("x.csv", "c-axis", seed=None), "seed=None"),
        (lambda: hfc.stability(gain="x"), "gain='x'"),
        (lambda: hfc.stability(time_constant=0), "time_constant=0"),
        (lambda: hfc.import_("x.fis", sample_time="x"), "sample_time='x'"),
        (lambda: hfc.import_("x.fis", terms=(9, 50)), "terms=50"),
        (lambda: hfc.import_("x.fis", terms=7), ""),
        (lambda: hfc.taught("pd-only", RAMP, lesson=5), ""),
        (lambda: hfc.taught("pd-only", RAMP, lesson=Lesson(passes=1.5)), "passes=1.5"),
        (lambda: hfc.taught("pd-only", RAMP, lesson=Lesson(rate="x")), "rate='x'"),
    ],
)
def test_a_mistake_of_a_script_names_its_argument(call, where):
    with refused() as found:
        call()
    assert found.refusal.startswith(where)
    assert "--" not in found.refusal
    assert "\n" not in found.refusal
