"""Run folders: what is in them, and that no interruption changes or loses anything."""

import os
import resource
import signal
import subprocess
import sys
import time

import jax
import numpy as np
import pytest
import tomli_w

from hfc_design.core import checkpoint
from hfc_design.core.records import RunError, UserError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design, own_scenario
from hfc_design.runs import run as design
from hfc_design.runs import stored
from hfc_design.simulation import compiled
from hfc_design.simulation.evaluating import evaluate

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


def test_design_scores_what_it_says_on_the_scenario_it_carries(whole):
    folder, _ = whole
    found = load_design(str(folder))
    scenario = own_scenario(found, str(folder))
    assert scenario == design.opened_run(folder)
    assert evaluate(found, scenario).fitness == found.score["fitness"]


def test_config_alone_runs_the_same_again(whole, tmp_path):
    folder, _ = whole
    scenario = load_scenario(str(folder / "config.toml"))
    design.run(design.new_run(scenario, tmp_path / "again"), tmp_path / "again")
    assert contents(tmp_path / "again") == contents(folder)


@pytest.mark.parametrize("stop", [1, 4, 9])
def test_interrupted_and_resumed_equals_uninterrupted(whole, tmp_path, stop):
    folder, changes = whole
    part = tmp_path / "part"
    scenario = started(part, changes)

    def interrupt(search):
        if search.generation == stop:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        design.run(scenario, part, interrupt)
    assert not (part / "design.json").exists()
    design.run(design.opened_run(part), part)
    assert contents(part) == contents(folder)


@pytest.mark.parametrize(
    "whole",
    [
        pytest.param(SEARCHES[0], id="race"),
        pytest.param(SEARCHES[1], id="lin-lee", marks=pytest.mark.slow),
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


def test_damaged_checkpoints_are_refused_and_left_alone(whole, tmp_path):
    folder, _ = whole
    part = tmp_path / "part"
    part.mkdir()
    (part / "config.toml").write_bytes((folder / "config.toml").read_bytes())
    good = (folder / "checkpoint.npz").read_bytes()
    middle = len(good) // 2
    flipped = good[:middle] + bytes([good[middle] ^ 0xFF]) + good[middle + 1 :]
    for bad in (good[:middle], good[:-1], flipped, b"", b"not a checkpoint", good[4:]):
        (part / "checkpoint.npz").write_bytes(bad)
        with pytest.raises(RunError, match=r"checkpoint\.npz: is damaged"):
            design.run(design.opened_run(part), part)
        assert (part / "checkpoint.npz").read_bytes() == bad


def test_checkpoint_of_another_run_is_refused(whole, tmp_path):
    folder, changes = whole
    part = tmp_path / "part"
    scenario = started(part, [*changes, "run.seed=5"])
    foreign = (folder / "checkpoint.npz").read_bytes()
    (part / "checkpoint.npz").write_bytes(foreign)
    with pytest.raises(RunError, match=r"another config\.toml"):
        design.run(scenario, part)
    assert (part / "checkpoint.npz").read_bytes() == foreign


def test_pickled_arrays_are_refused(whole, tmp_path):
    folder, _ = whole
    with np.load(folder / "checkpoint.npz") as arrays:
        data = dict(arrays)
    data["generation"] = np.array([{"a": 1}], dtype=object)
    np.savez(tmp_path / "bad.npz", **data)
    with pytest.raises(RunError, match="is damaged"):
        stored.load(tmp_path / "bad.npz", design.opened_run(folder), {})


def test_folder_that_holds_a_run_is_refused(whole):
    folder, changes = whole
    before = contents(folder)
    with pytest.raises(UserError, match="already holds a run"):
        started(folder, changes)
    assert contents(folder) == before


def test_folder_without_a_run_cannot_be_resumed(tmp_path):
    with pytest.raises(UserError, match="holds no run to resume"):
        design.opened_run(tmp_path)


def test_full_disk_loses_nothing(tmp_path):
    """A limit on the size of files stands for the full disk: the same OSError, really raised."""
    path = tmp_path / "file"
    checkpoint.write_whole(path, b"old" * 100)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
    try:
        with pytest.raises(RunError, match=r"file: cannot be written: File too large"):
            checkpoint.write_whole(path, b"new" * 1000)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, handler)
    assert path.read_bytes() == b"old" * 100


def test_disk_that_fills_during_a_run_leaves_a_resumable_run(whole, tmp_path, monkeypatch):
    folder, changes = whole
    part = tmp_path / "part"
    scenario = started(part, changes)
    monkeypatch.setattr(design, "CHECKPOINT_EVERY", 0.0)
    real, calls = os.fsync, []

    def full_after_a_while(descriptor):
        calls.append(descriptor)
        if len(calls) > 6:
            raise OSError(28, "No space left on device")
        real(descriptor)

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full_after_a_while)
        with pytest.raises(RunError, match="No space left on device"):
            design.run(scenario, part)
    design.run(design.opened_run(part), part)
    assert contents(part) == contents(folder)


def test_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RunError, match="cannot be written: Not a directory"):
        started(tmp_path / "file" / "run")


def test_csv_tables_travel_with_the_run(tmp_path):
    (tmp_path / "way.csv").write_text("time_s,reference_rad\n0,0\n0.05,0.001\n0.1,0.0015\n")
    (tmp_path / "cut.csv").write_text("time_s,load_Nm\n0,0\n0.05,1\n")
    (tmp_path / "mine.toml").write_text(
        'reference = {kind = "csv", file = "way.csv"}\nload = {file = "cut.csv"}\n'
    )
    folder = tmp_path / "run"
    scenario = load_scenario(str(tmp_path / "mine.toml"), SMALL)
    result = design.run(design.new_run(scenario, folder), folder)
    (tmp_path / "way.csv").unlink()
    (tmp_path / "cut.csv").unlink()
    moved = tmp_path / "moved"
    folder.rename(moved)
    found = load_design(str(moved))
    again = evaluate(found, own_scenario(found, str(moved)))
    assert again.fitness == result.evaluation.fitness
    assert again.axes[0].reference[50] == pytest.approx(0.001)
    assert again.axes[0].load[25] == pytest.approx(0.5)


def test_tables_of_motions_and_of_axes_travel_too(tmp_path):
    tables = {"slow": 0.002, "fast": 0.01, "x": 50.0, "y": 20.0, "cut": 1.0}
    for name, end in tables.items():
        (tmp_path / f"{name}.csv").write_text(f"0,0\n0.1,{end}\n")
    several = {
        "motions": [
            {"name": "slow", "reference": {"kind": "csv", "file": "slow.csv"}},
            {"name": "fast", "load": {"file": "cut.csv"}},
        ],
        "reference": {"kind": "csv", "file": "fast.csv"},
    }
    axes = {axis: {"kind": "csv", "file": f"{axis}.csv"} for axis in "xy"}
    each = {
        "plant": {"name": "feed-drive", "axes": {"x": {}, "y": {}}},
        "reference": {"kind": "per-axis", "axes": axes},
        "load": {"axes": {"y": {"file": "cut.csv"}}},
        "simulation": {"sample_time_s": 0.01},
        "controller": {"kind": "pid"},
    }
    kept = {}
    for name, own in {"several": several, "each": each}.items():
        path = tmp_path / f"{name}.toml"
        path.write_text(tomli_w.dumps(own))
        scenario = load_scenario(str(path), ["simulation.duration_s=0.1"])
        kept[name] = [alone.samples().axes for alone in scenario.each_motion()]
        design.new_run(scenario, tmp_path / name)
    for name in tables:
        (tmp_path / f"{name}.csv").unlink()
    for name, before in kept.items():
        folder = (tmp_path / name).rename(tmp_path / f"{name}-moved")
        again = [alone.samples().axes for alone in design.opened_run(folder).each_motion()]
        jax.tree.map(np.testing.assert_array_equal, again, before)
    assert len(list(tmp_path.rglob("*.csv"))) == 6


@pytest.mark.slow
def test_a_whole_run_compiles_the_evaluator_once(tmp_path):
    """Of each program one: scores, derivatives and the float64 check of the finalists."""
    programs = (compiled.scores_needed, compiled.jacobians, compiled.trajectories)
    for program in programs:
        program.clear_cache()
    found = design.run(started(tmp_path / "run"), tmp_path / "run")
    assert found.search.history.structures[0] > 10
    assert [program._cache_size() for program in programs] == [1, 1, 1]
