"""Run folders: what is in them, and that no interruption changes or loses anything."""

import os
import resource
import signal

import numpy as np
import pytest

from hfc_design.core import checkpoint
from hfc_design.core.records import RunError, UserError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import run as design
from hfc_design.runs import stored

#: As short as the batches of other tests, so that all have the same compiled programs.
SMALL = ["simulation.duration_s=0.1", "search.population=24", "search.generations=9"]
SEARCHES = [[], ["search.preset=lin-lee-1999"]]


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
