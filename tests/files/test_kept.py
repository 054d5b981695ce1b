"""What a design keeps on another scenario, told part by part; what is told is what happens."""

import json

import pytest
from run_folders import hfc

from hfc_design.files.design import Design, changed_design, design_json
from hfc_design.files.kept import HEAD, UNKNOWN, kept
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design

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
    head, *lines = kept(design, load_scenario(scenario, changes))
    assert head == HEAD
    return dict(line.split(maxsplit=1) for line in lines)


def test_what_is_the_same_is_kept():
    every = dict.fromkeys(("machine", "limits", "sensors", "load"), "kept")
    assert told(made_with(MADE), {"name": "here", **MADE}) == every


def test_a_machine_that_the_scenario_does_not_name_is_the_designs():
    changes = {"plant.parameters.spindle_inertia": 9.0}
    own = changed_design(load_design("pd-only"), changes, "pd-only")
    found = told(own, "c-axis-ramp")["machine"]
    assert found == "kept: spindle_inertia 9 (not 5.102)"


def test_simulate_says_it_too_beside_its_numbers(tmp_path):
    (tmp_path / "here.toml").write_text("limits.command = 50.0\nsimulation.duration_s = 0.1\n")
    done = hfc("simulate", "pd-only", "--scenario", tmp_path / "here.toml")
    assert done.exit_code == 0
    assert HEAD not in done.stdout
    assert HEAD in done.stderr
    assert "limits   the drive here has command 50 (made with none)" in done.stderr
    assert HEAD not in hfc("simulate", "pd-only", "--set", "simulation.duration_s=0.1").stderr


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
        "machine": "kept, but for spindle_inertia 3.2 (made with 5.102)",
        "limits": "kept by the controller (command 90); the drive here has command 60 (made with "
        "90), delay_samples 1 (made with 0)",
        "sensors": "this scenario's: encoder_resolution 0 (made with 1e-06)",
        "load": "this scenario's: constant 2 (made with 5), sines 1 of them (made with none)",
    }


def test_a_design_that_does_not_say_with_what_it_was_made():
    design = load_design("lin-lee-1999-table-1").model_copy(update={"provenance": {}})
    found = told(design, "c-axis-ramp-cutting")
    assert (found["sensors"], found["load"]) == (UNKNOWN, UNKNOWN)
    assert (found["machine"], found["limits"]) == ("kept", "kept")


@pytest.mark.parametrize("load", [5.0, 6.0])
def test_loads_of_several_motions(load):
    motions = [{"name": "free"}, {"name": "cut", "load": {"constant": 5.0}}]
    design = made_with({"motions": motions})
    other = [motions[0], {"name": "cut", "load": {"constant": load}}]
    found = told(design, {"name": "here", "motions": other})
    assert found["load"] == ("kept" if load == 5.0 else "this scenario's, in each motion")


def test_axes_are_told_apart():
    found = told(
        load_design("jee-koren-2004-pid"), "feed-drive-circle", {"plant.axes.x.gain": 31.0}
    )
    assert "x.gain 31 (made with 28.3)" in found["machine"]


def test_each_of_several_scenarios_is_told_with_its_scores():
    """And the order is that of the command line."""
    short = ["--set", "simulation.duration_s=0.3"]
    given = ["--scenario", "c-axis-ramp-cutting", "--scenario", "c-axis-step"]
    done = hfc("score", "pd-only", *given, *short)
    assert done.exit_code == 0, done.output
    first, second = done.stdout.split("\n\nscenario ")
    assert first.startswith("scenario c-axis-ramp-cutting\n")
    assert second.startswith("c-axis-step\n")
    for text in (first, second):
        assert text.count(HEAD) == 1
        assert text.index("max_error_rad") < text.index(HEAD)
    alone = hfc("score", "pd-only", *short)
    assert HEAD not in alone.stdout
    lines = hfc("score", "pd-only", *given, *short, "--json").stdout.splitlines()
    assert [json.loads(line)["scenario"] for line in lines] == [given[1], given[3]]
