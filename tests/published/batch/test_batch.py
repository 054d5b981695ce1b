"""A batch: its cells, what it leaves on disk, and what happens when something goes wrong."""

import os
import signal
import subprocess
import sys
import time

import pytest
from batches import QUICK, batch, files, left_behind, written


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return written(tmp_path_factory.mktemp("batch"), QUICK)


@pytest.fixture(scope="module")
def undisturbed(path):
    """What the grid leaves behind when nothing happens."""
    return left_behind(path.parent, QUICK)


def test_a_batch_fills_run_folders_and_skips_them_later(path, undisturbed):
    out = path.parent / "out"
    assert len([name for name in undisturbed if name.endswith("design.json")]) == 4
    stamps = {name: (out / name).stat().st_mtime_ns for name in undisturbed}
    assert "4 finished, 0 failed" in batch(path, "--out", out).output
    assert stamps == {name: (out / name).stat().st_mtime_ns for name in undisturbed}
    assert "4 finished" in batch("--status", out).output


def started(path, out):
    return subprocess.Popen(
        [sys.executable, "-m", "hfc_design", "batch", path, "--out", out],
        stderr=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
    )


def test_stopped_at_any_moment_and_called_again(tmp_path, path, undisturbed):
    """As soon as there are checkpoints of so many cells; ``attack/test_kills.py`` kills it."""
    out = tmp_path / "out"
    for cells in (1, 3):
        process = started(path, out)
        while process.poll() is None and len(list(out.glob("*/checkpoint.npz"))) < cells:
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        process.wait(timeout=60)
    assert batch(path, "--out", out).exit_code == 0
    assert files(out) == undisturbed


def test_two_batches_on_one_folder_share_the_work(tmp_path, path, undisturbed):
    out = tmp_path / "out"
    both = [started(path, out) for _ in range(2)]
    assert [process.wait(timeout=120) for process in both] == [0, 0]
    assert files(out) == undisturbed


@pytest.mark.skipif(os.getuid() != 0, reason="only root can mount a small disk")
def test_a_full_disk_loses_nothing(tmp_path, path, undisturbed):
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=700k", "none", str(disk)]
    if subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("no disk can be mounted here")
    try:
        (disk / "filler").write_bytes(b"0" * 640_000)
        found = batch(path, "--out", disk / "out")
        assert found.exit_code == 1
        assert "No space left" in found.output
        (disk / "filler").unlink()
        subprocess.run(["mount", "-o", "remount,size=50M", str(disk)], check=True)
        assert batch(path, "--out", disk / "out").exit_code == 0
        assert files(disk / "out") == undisturbed
    finally:
        subprocess.run(["umount", str(disk)], check=True)
