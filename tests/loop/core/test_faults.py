"""An unknown key in any table of every built-in scenario: a line, in plain words."""

import pytest
from mistakes import places, put
from plain_words import plain_lines
from wording import refused

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
        ("c-axis-ramp", "velocity=-1e308"),
        ("feed-drive-circle", "radius_mm=1e308"),
        ("feed-drive-circle", "cycles=1e308"),
        ("feed-drive-circle", "feed_mm_min=5e-324"),
    ],
)
def test_motions_beyond_all_numbers(scenario, change):
    with refused() as found:
        load_scenario(scenario, [f"reference.{change}"])
    assert found.refusal.startswith(f"{scenario}: reference.kind = ")
