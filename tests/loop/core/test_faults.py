"""An unknown key in any table of every built-in scenario: a line, in plain words."""

import pytest
from mistakes import places, put
from plain_words import plain_lines
from wording import refused

import hfc_design.api as hfc
from hfc_design.controllers.neural.record import Lesson
from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import builtin_names, load_scenario
from hfc_design.files.plausibility import plausibility_warnings


def tables(value, here=()):
    """Every place of a table."""
    for place in [here, *places(value)]:
        own = value
        for key in place:
            own = own[key]
        if isinstance(own, dict):
            yield place


#: Whose keys are the user's own: names of parameters, axes, measures, states, signals.
OPEN = {"parameters", "axes", "start", "constraints", "readings", "tolerances", "ranges", "limits"}


@pytest.mark.parametrize("name", builtin_names())
def test_no_built_in_scenario_is_doubted_and_an_unknown_key_anywhere_is_told(name):
    scenario = load_scenario(name)
    assert plausibility_warnings(scenario) == []
    whole = scenario.model_dump(mode="json", exclude_none=True)
    for place in tables(whole):
        if OPEN & {*place}:
            continue
        with pytest.raises(UserError) as refused:
            load_scenario(put(whole, (*place, "nmae"), 3))
        told = plain_lines(refused.value)
        key = ".".join(map(str, (*place, "nmae")))
        (line,) = [line for line in told if key in line]
        assert f"scenario: {key} = 3: unknown key; " in line
        assert "available: " in line.partition("unknown key; ")[2]


@pytest.mark.parametrize(
    ("scenario", "change"),
    [
        ("c-axis-ramp", "velocity=1e308"),
        ("feed-drive-circle", "radius_mm=1e308"),
        ("feed-drive-circle", "feed_mm_min=5e-324"),
    ],
)
def test_motions_beyond_all_numbers(scenario, change):
    with refused() as found:
        load_scenario(scenario, [f"reference.{change}"])
    assert found.refusal.startswith(f"{scenario}: reference.kind = ")


RAMP = hfc.load_scenario("c-axis-ramp", {"simulation.duration_s": 0.1})
TWO = ["pd-only", "lin-lee-1999-table-2"]


@pytest.mark.parametrize(
    ("call", "where"),
    [
        (lambda: hfc.robustness("pd-only", RAMP, 0.2, 0), "samples=0"),
        (lambda: hfc.load_scenario(RAMP, {"name.b": 5}), "changes={'name.b'"),
        (lambda: hfc.explain("jee-koren-2004-flc", "x"), "sample: "),
        (lambda: hfc.picture("lin-lee-1999-table-2", "surface", "u"), "unit='u'"),
        (
            lambda: hfc.identify("x.csv"),
            "the machine is missing",
        ),
        (lambda: hfc.identify("x.csv", "c-axis", axis="x"), "axis='x'"),
        (lambda: hfc.usable("pd-only", RAMP, machines="20"), "machines='20'"),
        (lambda: hfc.usable("pd-only", RAMP, spread=-1), "spread=-1"),
        (lambda: hfc.compare(TWO, machines="20"), "machines='20'"),
        (lambda: hfc.compare(TWO, spread=float("nan")), "spread=nan"),
        (lambda: hfc.compare(TWO, tolerances={"backlash": 5}), "tolerances={'backlash': 5}"),
        (lambda: hfc.robustness("pd-only", RAMP, 0.2, 5, tolerances=5), ""),
        (lambda: hfc.batch("x.toml", workers=2.0), "workers=2.0"),
        (lambda: hfc.pick("x", "3"), "point='3'"),
        (lambda: hfc.identify("x.csv", "c-axis", bandwidth="5"), "bandwidth='5'"),
        (lambda: hfc.identify("x.csv", "c-axis", sample_time=0), "sample_time=0"),
        (lambda: hfc.identify("x.csv", "c-axis", seed=None), "seed=None"),
        (lambda: hfc.stability(gain="x"), "gain='x'"),
        (lambda: hfc.import_("x.fis", sample_time="x"), "sample_time='x'"),
        (lambda: hfc.import_("x.fis", terms=(9, 50)), "terms=50"),
        (lambda: hfc.import_("x.fis", terms=7), ""),
        (lambda: hfc.taught("pd-only", RAMP, lesson=5), ""),
        (lambda: hfc.taught("pd-only", RAMP, lesson=Lesson(rate="x")), "rate='x'"),
    ],
)
def test_a_mistake_of_a_script_names_its_argument(call, where):
    with refused() as found:
        call()
    assert found.refusal.startswith(where)
    assert "--" not in found.refusal
    assert "\n" not in found.refusal
