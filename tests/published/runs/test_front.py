"""The front of a run: its file, its report, the designs of its points."""

import numpy as np
import pytest
from run_folders import hfc, table

from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.runs import run as design
from hfc_design.simulation.evaluating import evaluate

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
ASKED = "controller.ranges={k_p=[0.1,20.0],k_i=[0.0,50.0],k_d=[0.0,1.0]}"
PID = ("--pareto", "tracking,effort", "--controller", "pid", "--set", ASKED)
MANY = {"robust": {"first": 3, "machines": 3, "elite": 3, "final": 5}}
FILES = {"config.toml", "checkpoint.npz", "history.csv", "design.json", "front.csv"}


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


def test_the_folder_has_points_of_which_none_beats_another(whole):
    folder, changes, result = whole
    assert set(contents(folder)) == FILES | ({"usable.json"} if changes else set())
    rows = table(folder / "front.csv")
    assert [*rows[0]] == ["point", "tracking_rad", "effort_V", "merit", "mark", "individual"]
    costs = np.array([[float(row["tracking_rad"]), float(row["effort_V"])] for row in rows])
    assert len(costs) > 4
    assert (np.diff(costs[:, 0]) > 0.0).all()
    assert (np.diff(costs[:, 1]) < 0.0).all()
    merit = [float(row["merit"]) for row in rows]
    assert "design" in rows[int(np.argmax(merit))]["mark"]
    assert sum("knee" in row["mark"] for row in rows) == 1
    assert design.finished_run(folder)[1].front.costs.tolist() == result.front.costs.tolist()


def test_a_point_costs_what_its_design_costs_by_the_metrics(alone, tmp_path):
    """Metrics are computed from the recorded motion, costs are added up in the loop."""
    folder, _ = alone
    for k in (1, 4):
        out = tmp_path / f"{k}.json"
        done = hfc("pick", folder, "--point", k, "--out", out)
        assert done.exit_code == 0, done.output
        row = table(folder / "front.csv")[k - 1]
        found = evaluate(load_design(str(out)), load_scenario(str(folder / "config.toml")))
        effort = np.sqrt(np.mean(np.square(found.axes[0].motion.command)))
        assert found.metrics["rms_error_rad"] == pytest.approx(float(row["tracking_rad"]), rel=1e-9)
        assert effort == pytest.approx(float(row["effort_V"]), rel=1e-9)
        assert found.merit == pytest.approx(float(row["merit"]), rel=1e-9)


def test_nothing_allowed_is_the_least_broken_design_and_said(tmp_path, no_baselines):
    small = ("--population", 8, "--generations", 2, "--set", "simulation.duration_s=0.1")
    never = ("--set", "constraints={rms_command='0 V'}")
    done = hfc("design", "c-axis-ramp", *PID, *small, *never, "--out", tmp_path / "r")
    assert done.exit_code == 0, done.output
    assert "No design kept every constraint" in done.stdout
    assert table(tmp_path / "r" / "front.csv") == []
    assert "No design kept every constraint" in (tmp_path / "r" / "report.html").read_text()
    _, result = design.finished_run(tmp_path / "r")
    assert result.front.costs.shape == (0, 2)
    refused = hfc("pick", tmp_path / "r", "--knee", "--out", tmp_path / "x.json")
    assert (refused.exit_code, refused.stderr) == (
        2,
        f"hfc: {tmp_path / 'r'}: its front is empty, no design kept every constraint\n",
    )
