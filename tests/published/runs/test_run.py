"""Run folders: what is in them, and that no interruption changes or loses anything."""

import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import run as design
from hfc_design.simulation import compiled

#: As short as the batches of other tests, so that all have the same compiled programs.
SMALL = ["simulation.duration_s=0.1", "search.population=24", "search.generations=9"]
SEARCHES = [[], ["search.preset=lin-lee-1999"]]
FILES = {"config.toml", "checkpoint.npz", "history.csv", "design.json"}


def started(folder, changes=()):
    return design.new_run(load_scenario("c-axis-ramp", [*SMALL, *changes]), folder)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


@pytest.fixture(scope="module", params=SEARCHES, ids=["race", "lin-lee"])
def whole(request, tmp_path_factory):
    """An uninterrupted run: its folder and what was changed in its scenario."""
    folder = tmp_path_factory.mktemp("runs") / "whole"
    design.run(started(folder, request.param), folder)
    return folder, request.param


def test_folder_holds_what_it_should(whole):
    folder, _ = whole
    assert set(contents(folder)) == FILES
    rows = np.genfromtxt(folder / "history.csv", delimiter=",", names=True)
    assert rows["generation"].tolist() == list(range(9))
    assert (np.diff(rows["best"]) >= 0).all()


@pytest.mark.parametrize(
    "whole",
    [
        pytest.param(SEARCHES[0], id="race"),
        pytest.param(SEARCHES[1], id="lin-lee"),
    ],
    indirect=True,
)
def test_killed_again_and_again_and_resumed_equals_uninterrupted(whole, tmp_path):
    """SIGKILL as soon as a checkpoint has moved on, twice, then let it finish."""
    folder, changes = whole
    part = tmp_path / "part"
    started(part, changes)
    code = (
        "import sys, pathlib; from hfc_design.runs import run; run.CHECKPOINT_EVERY = 0.0\n"
        "folder = pathlib.Path(sys.argv[1]); run.run(run.opened_run(folder), folder)"
    )
    for kills in range(2):
        before = (part / "checkpoint.npz").stat().st_mtime_ns if kills else None
        process = subprocess.Popen([sys.executable, "-c", code, str(part)])
        while process.poll() is None:
            path = part / "checkpoint.npz"
            if path.exists() and path.stat().st_mtime_ns != before:
                process.send_signal(signal.SIGKILL)
                break
            time.sleep(0.001)
        assert process.wait() in (-signal.SIGKILL, 0)  # 0: it was quicker
    design.run(design.opened_run(part), part)
    assert contents(part) == contents(folder)  # what a kill left half written is gone


def test_a_whole_run_compiles_the_evaluator_once(tmp_path):
    """Of each program one: scores, derivatives and the float64 check of the finalists."""
    programs = (compiled.scores_needed, compiled.jacobians, compiled.trajectories)
    for program in programs:
        program.clear_cache()
    found = design.run(started(tmp_path / "run"), tmp_path / "run")
    assert found.search.history.structures[0] > 10
    assert [program._cache_size() for program in programs] == [1, 1, 1]
