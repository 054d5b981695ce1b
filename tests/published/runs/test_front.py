"""The front of a run: its file, its report, the designs of its points."""

import json

import numpy as np
import pytest
from run_folders import hfc, table
from short_runs import contents, once, resumed, started, stopping

from hfc_design import api
from hfc_design.files.design import design_json
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import run as design
from hfc_design.simulation.evaluating import evaluate

RANGES = "{k_p=[0.1,20.0],k_i=[0.0,50.0],k_d=[0.0,1.0]}"  # weak, so quick to judge
FRONT = [
    f"controller={{kind='pid',ranges={RANGES}}}",
    *("search.preset=nsga-ii", "search.objectives=['tracking','effort']"),
    *("search.population=24", "search.generations=9", "simulation.duration_s=0.1"),
]
ASKED = ("--controller", "pid", "--set", f"controller.ranges={RANGES}")
PID = ("--pareto", "tracking,effort", *ASKED)
MANY = ("robust={first=3,machines=3,elite=3,final=5}",)
FILES = {"config.toml", "checkpoint.npz", "history.csv", "design.json", "front.csv", "usable.json"}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A front on many machines; ``alone`` is one on a single machine."""
    return once(tmp_path_factory.mktemp("fronts"), FRONT)(*MANY)


@pytest.fixture
def alone(tmp_path, no_baselines):
    """A run on one machine as the command line makes it."""
    folder = tmp_path / "run"
    small = ("--population", 24, "--generations", 9, "--set", "simulation.duration_s=0.1")
    done = hfc("design", "c-axis-ramp", *PID, *small, "--out", folder)
    assert done.exit_code == 0, done.output
    return folder, done.stdout


def test_the_folder_has_points_of_which_none_beats_another(whole):
    folder, result = whole
    assert set(contents(folder)) == FILES
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


def test_stopped_and_resumed_is_the_same(whole, tmp_path):
    part = tmp_path / "part"
    stopping(started(part, MANY, FRONT), part, 5)
    resumed(part)
    assert contents(part) == contents(whole[0])


def test_a_point_is_picked_with_what_is_known_of_its_use(whole, tmp_path):
    """From Python too; the point of design.json is that design, its share of machines included."""
    folder, result = whole
    best = result.front.best
    of_run = json.loads((folder / "design.json").read_text())
    assert "usable" in of_run["score"]
    done = hfc("pick", folder, "--point", best + 1, "--out", tmp_path / "best.json")
    assert done.exit_code == 0, done.output
    assert json.loads((tmp_path / "best.json").read_text()) == of_run
    assert "Can I use it?" in done.stdout
    assert json.loads(design_json(api.pick(folder, point=best + 1))) == of_run
    costs = map(float, result.front.costs[result.front.knee])
    knee = api.pick(folder)
    assert knee == api.pick(folder, nearest=dict(zip(("tracking", "effort"), costs, strict=True)))
    with pytest.raises(api.UserError, match=r"must be 1 to"):
        api.pick(folder, point=len(result.front.merit) + 1)


def test_a_point_costs_what_its_design_costs_by_the_metrics(alone, tmp_path):
    """Metrics are computed from the recorded motion, costs are added up in the loop."""
    folder, told = alone
    assert "trade-off" in told
    assert "trade-off" in hfc("pick", folder).stdout
    assert "Pareto front" in (folder / "report.html").read_text()
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


def test_nothing_allowed_is_the_least_broken_design_and_said(tmp_path, no_baselines, known_use):
    small = ("--population", 8, "--generations", 2, "--set", "simulation.duration_s=0.1")
    never = ("--set", "constraints={rms_command='0 V'}")
    done = hfc("design", "c-axis-ramp", *PID, *small, *never, "--out", tmp_path / "r")
    assert done.exit_code == 0, done.output
    assert "no design tried meets every constraint" in done.stdout
    assert table(tmp_path / "r" / "front.csv") == []
    assert "No design meets every constraint" in (tmp_path / "r" / "report.html").read_text()
    _, result = design.finished_run(tmp_path / "r")
    assert result.front.costs.shape == (0, 2)
    found = hfc("pick", tmp_path / "r", "--knee", "--out", tmp_path / "x.json")
    assert (found.exit_code, "its front is empty" in found.stderr) == (2, True)
