"""What a design keeps on another scenario, told part by part; what is told is what happens."""

import json

import pytest

from hfc_design.files.design import Design, changed_design, design_json
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.transfer import HEAD, UNKNOWN, transfer_report

MADE = {
    "sensors": {"encoder_resolution": 1e-6},
    "limits": {"command": 90.0, "resolution": 0.05},
    "load": {"constant": 5.0},
}


def made_with(scenario, like="pd-only"):
    """A built-in design that was made with a scenario."""
    data = json.loads(design_json(load_design(like)))
    limits = scenario.get("limits", {})
    return Design.model_validate(
        data | {"limits": limits, "provenance": {"scenario": {"name": "made", **scenario}}}
    )


def told(design, scenario, changes=None):
    """Part -> what is said of it."""
    head, *lines = transfer_report(design, load_scenario(scenario, changes))
    assert head == HEAD
    return dict(line.split(maxsplit=1) for line in lines)


def test_a_machine_that_the_scenario_does_not_name_is_the_designs():
    changes = {"plant.parameters.spindle_inertia": 9.0}
    own = changed_design(load_design("pd-only"), changes, "pd-only")
    found = told(own, "c-axis-ramp")["machine"]
    assert found == "kept: spindle_inertia 9 (not 5.102)"


def test_every_part_says_what_is_here_and_what_was():
    found = told(
        made_with(MADE),
        "c-axis-ramp",
        {
            "plant.parameters.spindle_inertia": 3.2,
            "limits.command": 60.0,
            "limits.delay_samples": 1,
            "load.constant": 2.0,
            "load.sines": [{"amplitude": 1.0, "frequency_rad_s": 2.0}],
        },
    )
    assert found == {
        "machine": "kept, except spindle_inertia 3.2 (made with 5.102)",
        "limits": "applied by the controller (command 90); the drive here has command 60 (made "
        "with 90), delay_samples 1 (made with 0)",
        "sensors": "this scenario's: encoder_resolution 0 (made with 1e-06)",
        "load": "this scenario's: constant 2 (made with 5), sines 1 of them (made with none)",
    }


def test_a_design_that_does_not_say_with_what_it_was_made():
    design = load_design("lin-lee-1999-table-1").model_copy(update={"provenance": {}})
    found = told(design, "c-axis-ramp-cutting")
    assert (found["sensors"], found["load"]) == (UNKNOWN, UNKNOWN)
    assert (found["machine"], found["limits"]) == ("kept", "kept")
    # A printed controller, of no machine in particular: nothing here is another than it was.
    assert told(load_design("jee-koren-2004-flc"), "feed-drive-circle")["machine"] == UNKNOWN


@pytest.mark.parametrize("load", [5.0, 6.0])
def test_loads_of_several_motions(load):
    motions = [{"name": "free"}, {"name": "cut", "load": {"constant": 5.0}}]
    design = made_with({"motions": motions})
    other = [motions[0], {"name": "cut", "load": {"constant": load}}]
    found = told(design, {"name": "here", "motions": other})
    assert found["load"] == ("kept" if load == 5.0 else "this scenario's, in each motion")
