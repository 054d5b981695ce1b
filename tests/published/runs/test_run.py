"""Run folders: what is in them, and that no interruption changes or loses anything."""

import signal
import subprocess
import sys
import time

import pytest
from short_runs import contents, once, resumed, started

from hfc_design.simulation import compiled

#: All structures of five inputs.
WIDE = ["simulation.duration_s=0.1", "search.population=24", "search.generations=9"]
PROGRAMS = (compiled.scores_needed, compiled.jacobians, compiled.trajectories)


@pytest.fixture(scope="module")
def race(tmp_path_factory):
    """(folder of a race that nobody disturbed, its result, how many programs it compiled)."""
    for program in PROGRAMS:
        program.clear_cache()
    found = once(tmp_path_factory.mktemp("runs"), WIDE)()
    return *found, [program._cache_size() for program in PROGRAMS]


@pytest.mark.usefixtures("race")  # which compiles for it too
def test_killed_again_and_again_and_resumed_equals_uninterrupted(tmp_path):
    """SIGKILL as soon as a checkpoint has moved on, twice, then let it finish.

    Races are killed in ``attack/test_kills.py``.
    """
    changes = ["search.preset=lin-lee-1999"]
    folder, _ = once(tmp_path, WIDE)(*changes)
    part = tmp_path / "part"
    started(part, changes, WIDE)
    code = (
        "import sys, pathlib; from hfc_design.runs import run, stored\n"
        "stored.CHECKPOINT_EVERY = 0.0\n"
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
    resumed(part)
    assert contents(part) == contents(folder)  # what a kill left half written is gone


def test_a_whole_run_compiles_the_evaluator_once(race):
    """Of each program one: scores, derivatives and the float64 check of the finalists."""
    _, found, compilations = race
    assert found.search.history.structures[0] > 10
    assert compilations == [1, 1, 1]
