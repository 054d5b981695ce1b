"""What a design keeps on another scenario, told part by part; what is told is what happens."""

import json

from run_folders import hfc

from hfc_design.files.design import changed_design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.transfer import HEAD, transfer_report


def told(design, scenario, changes=None):
    """Part -> what is said of it."""
    head, *lines = transfer_report(design, load_scenario(scenario, changes))
    assert head == HEAD
    return dict(line.split(maxsplit=1) for line in lines)


def test_axes_are_told_apart():
    found = told(
        changed_design(load_design("jee-koren-2004-pid"), {"plant.parameters.gain": 28.3}, "pid"),
        "feed-drive-circle",
        {"plant.axes.x.gain": 31.0},
    )
    assert "x.gain 31 (made with 28.3)" in found["machine"]


def test_each_of_several_scenarios_is_told_with_its_scores():
    """And the order is that of the command line."""
    short = ["--set", "simulation.duration_s=0.1"]
    given = ["--scenario", "c-axis-ramp-cutting", "--scenario", "c-axis-sine"]
    done = hfc("score", "pd-only", *given, *short)
    assert done.exit_code == 0, done.output
    first, second = done.stdout.split("\n\nscenario ")
    assert first.startswith("scenario c-axis-ramp-cutting\n")
    assert second.startswith("c-axis-sine\n")
    for text in (first, second):
        assert text.count(HEAD) == 1
        assert text.index("max_error_rad") < text.index(HEAD)
    alone = hfc("score", "pd-only", *short)
    assert HEAD not in alone.stdout
    lines = hfc("score", "pd-only", *given, *short, "--json").stdout.splitlines()
    assert [json.loads(line)["scenario"] for line in lines] == [given[1], given[3]]
