"""The front of a run: its file, the designs of its points."""

import json

import numpy as np
import pytest
from run_folders import hfc, table
from shaken import shaken
from short_runs import SEARCHES, once
from wording import refused_command

from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import RunError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.report.trade_off import table as shown
from hfc_design.runs import front as fronts
from hfc_design.runs import run as design


@pytest.fixture(scope="module")
def wholes(tmp_path_factory):
    return once(tmp_path_factory.mktemp("fronts"))


@pytest.fixture
def folder(wholes):
    return wholes(*SEARCHES["nsga-ii"])[0]


def test_the_marked_points_can_be_picked(folder, tmp_path):
    rows = table(folder / "front.csv")
    best = next(k for k, row in enumerate(rows, 1) if "design" in row["mark"])
    hfc("pick", folder, "--point", best, "--out", tmp_path / "best.json")
    own, design_of_run = (
        json.loads(path.read_text()) for path in (tmp_path / "best.json", folder / "design.json")
    )
    assert own == design_of_run
    hfc("pick", folder, "--knee", "--out", tmp_path / "knee.json")
    knee = next(k for k, row in enumerate(rows, 1) if "knee" in row["mark"])
    hfc("pick", folder, "--point", knee, "--out", tmp_path / "same.json")
    assert (tmp_path / "knee.json").read_bytes() == (tmp_path / "same.json").read_bytes()


def test_nearest_is_in_shares_of_the_front(folder):
    scenario, result = design.finished_run(folder)
    front = result.front
    effort = float(front.costs[3, 1])
    assert fronts.nearest(front, {"effort": effort}, scenario) == 3
    told = {"effort": f"{effort:.12f} V", "tracking": f"{1e6 * front.costs[3, 0]:.9f} urad"}
    assert fronts.nearest(front, told, scenario) == 3
    assert fronts.nearest(front, {"tracking": -1.0}, scenario) == 0


def test_the_table_has_the_ends_and_the_marked_points(folder):
    _, result = design.finished_run(folder)
    head, rows = shown(result.front, 5)
    numbers = [int(row[0]) - 1 for row in rows]
    assert {0, result.front.knee, result.front.best, len(result.front.merit) - 1} <= {*numbers}
    assert head[0] == "point"
    assert head[1].startswith("tracking [")
    assert len(rows) <= 5


@pytest.mark.parametrize(
    "options",
    [
        ["--nearest", "chatter=2"],
        ["--nearest", "effort='2 rad'"],
        ["--nearest", "effort"],
        ["--knee", "--point", 1],
        [],
    ],
)
def test_what_cannot_be_picked_is_told_in_a_line(options, folder, tmp_path):
    refused_command("pick", folder, *options, "--out", tmp_path / "x.json")
    assert not (tmp_path / "x.json").exists()


def test_a_pick_needs_a_file_and_a_front(folder, wholes, tmp_path):
    refused_command("pick", folder, "--knee")
    last = len(table(folder / "front.csv"))
    done = hfc("pick", folder, "--point", 0, "--out", tmp_path / "x.json")
    assert (done.exit_code, done.stderr) == (2, f"hfc: --point 0: must be 1 to {last}\n")
    other, _ = wholes()
    found = refused_command("pick", other, "--knee", "--out", tmp_path / "x.json")
    assert found.where == str(other)


def test_a_damaged_file_is_told(folder):
    kept = (folder / "front.csv").read_bytes()
    other = kept.replace(b"tracking", b"speed")
    for wrong in (
        b"",
        other,
        kept + b"9,nan,1,1,,0\n",
        kept[:-1] + b"99\n",
    ):
        write_whole(folder / "front.csv", wrong)
        with pytest.raises(RunError, match=r"front.csv: is missing or damaged"):
            design.finished_run(folder)
    write_whole(folder / "front.csv", kept)
    design.finished_run(folder)


def test_of_two_points_that_are_as_near_the_first_is_taken():
    """1.5 mrad is halfway between 1 and 2, but for its last bits."""
    scenario = load_scenario("c-axis-ramp", SEARCHES["nsga-ii"])
    for costs in shaken(1e-3, 2e-3, 3e-3, 1.5e-3):
        points = np.column_stack([costs[:3], [3.0, 2.0, 1.0]])
        front = fronts.Front(scenario.traded, points, np.ones(3), np.arange(3))
        assert fronts.nearest(front, {"tracking": costs[3]}, scenario) == 0
