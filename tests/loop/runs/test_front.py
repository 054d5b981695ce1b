"""The front of a run: its file, its report, the designs of its points."""

import json

import numpy as np
import pytest
from run_folders import hfc, table
from shaken import shaken

from hfc_design import api
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import RunError, UserError
from hfc_design.files.design import design_json
from hfc_design.files.named_scenario import load_scenario
from hfc_design.report.trade_off import table as shown
from hfc_design.runs import front as fronts
from hfc_design.runs import run as design

RANGES = {"k_p": [0.1, 20.0], "k_i": [0.0, 50.0], "k_d": [0.0, 1.0]}  # weak, so quick to judge
FRONT = {
    "controller": {"kind": "pid", "ranges": RANGES},
    "search": {
        "preset": "nsga-ii",
        "objectives": ["tracking", "effort"],
        "population": 24,
        "generations": 9,
    },
    "simulation.duration_s": 0.1,
}
NAMES = FRONT["search"]["objectives"]
ASKED = "controller.ranges={k_p=[0.1,20.0],k_i=[0.0,50.0],k_d=[0.0,1.0]}"
PID = ("--pareto", "tracking,effort", "--controller", "pid", "--set", ASKED)
MANY = {"robust": {"first": 3, "machines": 3, "elite": 3, "final": 5}}


def started(folder, changes=None):
    return design.new_run(load_scenario("c-axis-ramp", FRONT | (changes or {})), folder)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


@pytest.fixture(scope="module", params=[{}, MANY], ids=["one machine", "many"])
def whole(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("fronts") / "whole"
    result = design.run(started(folder, request.param), folder)
    return folder, request.param, result


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """A run on one machine as the command line makes it."""
    folder = tmp_path_factory.mktemp("fronts") / "run"
    small = ("--population", 24, "--generations", 9, "--set", "simulation.duration_s=0.1")
    done = hfc("design", "c-axis-ramp", *PID, *small, "--out", folder)
    assert done.exit_code == 0, done.output
    return folder, done.stdout


@pytest.mark.parametrize("stop", [1, 5])
def test_stopped_and_resumed_is_the_same(whole, tmp_path, stop):
    folder, changes, _ = whole

    def interrupt(search):
        if search.generation == stop:
            raise KeyboardInterrupt

    part = tmp_path / "part"
    with pytest.raises(KeyboardInterrupt):
        design.run(started(part, changes), part, interrupt)
    design.run(design.opened_run(part), part)
    assert contents(part) == contents(folder)


def test_the_marked_points_can_be_picked(alone, tmp_path):
    folder, told = alone
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
    assert "trade-off" in told
    assert "trade-off" in hfc("pick", folder).stdout
    page = (folder / "report.html").read_text()
    assert "What there was to choose from" in page


def test_a_point_is_picked_with_what_is_known_of_its_use(whole, tmp_path):
    """From Python too; the point of design.json is that design, its share of machines included."""
    folder, changes, result = whole
    best = result.front.best
    of_run = json.loads((folder / "design.json").read_text())
    assert ("usable" in of_run["score"]) == bool(changes)
    done = hfc("pick", folder, "--point", best + 1, "--out", tmp_path / "best.json")
    assert done.exit_code == 0, done.output
    assert json.loads((tmp_path / "best.json").read_text()) == of_run
    assert ("Can I use it?" in done.stdout) == bool(changes)
    assert json.loads(design_json(api.pick(folder, point=best + 1))) == of_run
    costs = map(float, result.front.costs[result.front.knee])
    knee = api.pick(folder)
    assert knee == api.pick(folder, nearest=dict(zip(NAMES, costs, strict=True)))
    with pytest.raises(UserError, match=r"there are points 1 to"):
        api.pick(folder, point=len(result.front.merit) + 1)


def test_nearest_is_in_shares_of_the_front(alone):
    folder, _ = alone
    scenario, result = design.finished_run(folder)
    front = result.front
    effort = float(front.costs[3, 1])
    assert fronts.nearest(front, {"effort": effort}, scenario) == 3
    told = {"effort": f"{effort:.12f} V", "tracking": f"{1e6 * front.costs[3, 0]:.9f} urad"}
    assert fronts.nearest(front, told, scenario) == 3
    assert fronts.nearest(front, {"tracking": -1.0}, scenario) == 0


def test_the_table_has_the_ends_and_the_marked_points(alone):
    _, result = design.finished_run(alone[0])
    head, rows = shown(result.front, 5)
    numbers = [int(row[0]) - 1 for row in rows]
    assert {0, result.front.knee, result.front.best, len(result.front.merit) - 1} <= {*numbers}
    assert head[0] == "point"
    assert head[1].startswith("tracking [")
    assert len(rows) <= 5


def refusal(*arguments):
    done = hfc(*arguments)
    assert done.exit_code == 2, done.output
    (line,) = done.stderr.splitlines()
    return line


def test_what_cannot_be_picked_is_told_in_a_line(alone, tmp_path):
    folder, _ = alone
    out = ("--out", tmp_path / "x.json")
    last = len(table(folder / "front.csv"))
    assert refusal("pick", folder, "--point", 0, *out) == (
        f"hfc: --point 0: there are points 1 to {last}"
    )
    assert "--nearest chatter: is no objective here; there is tracking, effort" in refusal(
        "pick", folder, "--nearest", "chatter=2", *out
    )
    assert "has to be a quantity in V" in refusal(
        "pick", folder, "--nearest", "effort='2 rad'", *out
    )
    assert "has to be NAME=NUMBER" in refusal("pick", folder, "--nearest", "effort", *out)
    assert "takes one of" in refusal("pick", folder, "--knee", "--point", 1, *out)
    assert "needs --out FILE" in refusal("pick", folder, "--knee")
    assert "needs --point, --nearest or --knee" in refusal("pick", folder, *out)
    assert not (tmp_path / "x.json").exists()


def test_a_run_without_a_front_has_nothing_to_pick(tmp_path, no_baselines):
    small = ("--population", 6, "--generations", 1, "--set", "simulation.duration_s=0.1")
    hfc("design", "c-axis-ramp", "--controller", "pd", *small, "--out", tmp_path / "r")
    assert refusal("pick", tmp_path / "r", "--knee", "--out", tmp_path / "x.json") == (
        f"hfc: {tmp_path / 'r'}: has no front; hfc design --pareto tracking,effort makes one"
    )


def test_a_damaged_file_is_told(alone, tmp_path):
    folder, _ = alone
    kept = (folder / "front.csv").read_bytes()
    other = kept.replace(b"tracking", b"speed")
    for wrong in (
        b"",
        other,
        kept + b"9,nan,1,1,,0\n",
        kept[:-1] + b"99\n",
    ):
        write_whole(folder / "front.csv", wrong)
        with pytest.raises(RunError, match=r"front.csv: is gone or damaged"):
            design.finished_run(folder)
    write_whole(folder / "front.csv", kept)
    design.finished_run(folder)


def test_of_two_points_that_are_as_near_the_first_is_taken():
    """1.5 mrad is halfway between 1 and 2, but for its last bits."""
    scenario = load_scenario("c-axis-ramp", FRONT)
    for costs in shaken(1e-3, 2e-3, 3e-3, 1.5e-3):
        points = np.column_stack([costs[:3], [3.0, 2.0, 1.0]])
        front = fronts.Front(scenario.traded, points, np.ones(3), np.arange(3))
        assert fronts.nearest(front, {"tracking": costs[3]}, scenario) == 0
