"""What a page of a run is told beside its runs."""

from report_pages import USED, told

from hfc_design.files.named_scenario import load_scenario
from hfc_design.report.parts import baselines, pass_conditions, usable_numbers


def test_the_loop_of_one_machine_is_a_rival_on_that_machine_only():
    stage = {"name": "x", "plant": {"name": "positioning-stage"}}
    stage |= {"reference": {"kind": "step", "height": 0.01}, "controller": {"kind": "pid"}}
    assert [*baselines(load_scenario(stage))] == ["emps-cascade"]
    assert not baselines(load_scenario(stage, {"plant.parameters.mass": 40.0}))
    other = load_scenario("c-axis-ramp", {"plant.parameters.stiffness": 150.0})
    assert len(baselines(other)) == 3


def test_an_error_in_metres_has_a_unit_that_needs_no_power_of_ten():
    """Of a feed drive; one unit for all motions, the chatter stays in V."""
    units = USED["units"] | {"settled_rms_error": "m"}
    motions = {name: told(1.0, {}, scale) for name, scale in (("one", 1.0), ("two", 2.0))}
    found = usable_numbers(USED | {"units": units, "motions": motions})
    assert found["heads"][2:4] == ["settled rms error [µm]", "chatter [V]"]
    assert found["rows"][0][2] == "3.57 / 3570"
    assert found["rows"][1][2] == "7.14 / 7140"


def test_it_says_what_everything_is():
    units = {"late_error": "2 mrad", "stick_slip": 0.0}
    asked = load_scenario("c-axis-ramp", {f"constraints.{key}": x for key, x in units.items()})
    assert pass_conditions(asked) == (
        "the loop is stable, and has at most late_error of 0.002 [rad], stick_slip of 0 [1]"
    )
    assert "sets no limits" in pass_conditions(load_scenario("feed-drive-circle"))
