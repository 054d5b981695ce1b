"""Two at once on one run folder: one is told who is at it, and nobody loses anything."""

import subprocess
import sys
import time

import pytest
from batches import batch, files, left_behind, written
from run_folders import hfc

from hfc_design import api
from hfc_design.batch.plan import read_batch
from hfc_design.core.lock import LOCK, exclusive
from hfc_design.core.records import RunError

SMALL = """
controller = {kind = 'pd'}
search.population = 16
search.generations = 3
simulation.duration_s = 0.1
"""
OPTIONS = [text for line in SMALL.split("\n") if line for text in ("--set", line.replace(" ", ""))]
#: The program, whose pages have no rivals: those would have to be compiled.
ALONE = """
from hfc_design.cli import main
from hfc_design.report import parts
parts.BASELINES.clear()
main()
"""
GRID = f"[set]\n{SMALL}[grid]\nrun.seed = [0, 1]\n"


def contents(folder):
    found = (file for file in folder.rglob("*") if file.is_file())
    return {str(file.relative_to(folder)): file.read_bytes() for file in found}


@pytest.mark.usefixtures("no_baselines")
def test_a_folder_in_use_is_left_alone(tmp_path):
    folder = tmp_path / "run"
    assert hfc("design", "c-axis-ramp", "--quiet", "--out", folder, *OPTIONS).exit_code == 0
    whole = contents(folder)
    assert LOCK not in whole
    assert {"config.toml", "checkpoint.npz", "history.csv", "design.json"} < set(whole)
    (folder / "design.json").unlink()
    with exclusive(folder):
        before = contents(folder)
        for command in (["--resume"], ["c-axis-ramp", *OPTIONS]):
            found = hfc("design", "--quiet", "--out", folder, *command)
            assert found.exit_code == 1
            assert f"hfc: {folder} is in use by process " in found.stderr
            assert found.stderr.count("\n") == 1
        with pytest.raises(RunError, match="is in use by process"):
            api.design(api.load_scenario(str(folder / "config.toml")), folder)
        assert contents(folder) == before
    assert hfc("design", "--quiet", "--out", folder, "--resume").exit_code == 0
    assert contents(folder) == whole
    found = hfc("design", "--quiet", "--out", tmp_path / "none", "--resume")
    assert (found.exit_code, (tmp_path / "none").exists()) == (2, False)


def test_two_designs_at_once(tmp_path):
    """On one folder the second is refused; without --out each has a folder of its own."""
    command = [sys.executable, "-c", ALONE, "design", "c-axis-ramp", "--quiet", *OPTIONS]
    for out, codes in ((["--out", "run"], [0, 1]), ([], [0, 0])):
        pipes = {"cwd": tmp_path, "stderr": subprocess.PIPE, "stdout": subprocess.DEVNULL}
        both = [subprocess.Popen([*command, *out], text=True, **pipes) for _ in range(2)]
        said = [process.communicate(timeout=120)[1] for process in both]
        if out and 2 in (found := [process.returncode for process in both]):
            assert sorted(found) == [0, 2]  # the first had ended before the second began
            assert "already has a run" in "".join(said)
            continue
        assert sorted(process.returncode for process in both) == codes, said
        if out:
            assert "hfc: run is in use by process" in "".join(said)
    runs = [tmp_path / "run", *sorted((tmp_path / "runs").iterdir())]
    assert [run.name for run in runs] == ["run", "c-axis-ramp-1", "c-axis-ramp-2"]
    first, *others = [contents(run) for run in runs]
    for found in others:
        assert {**found, "report.html": b""} == {**first, "report.html": b""}


@pytest.mark.usefixtures("no_baselines")
def test_a_cell_of_a_batch_and_its_resuming(tmp_path):
    """A cell that a batch is at cannot be resumed; the batch leaves one that is to that run."""
    whole = left_behind(tmp_path, GRID)
    path, out = written(tmp_path, GRID), tmp_path / "out"
    first, second = [cell.name for cell in read_batch(path).cells]
    for name in (first, second):
        (out / name / "design.json").unlink()
    with exclusive(out / first):
        found = hfc("design", "--quiet", "--resume", "--out", out / first)
        assert (found.exit_code, "is in use by process" in found.stderr) == (1, True)
        assert "1 running, 1 broken off" in batch("--status", out).output
        waiting = [sys.executable, "-m", "hfc_design", "batch", path, "--out", out]
        process = subprocess.Popen(waiting, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        while not (out / second / "design.json").exists():
            assert process.poll() is None
            time.sleep(0.05)
        (out / first / "design.json").write_bytes(whole[f"{first}/design.json"])
    assert "2 finished, 0 failed" in process.communicate(timeout=60)[0].decode()
    assert files(out) == whole
