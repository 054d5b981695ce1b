"""A batch: its cells, what it leaves on disk, and what happens when something goes wrong."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from batches import batch, files, left_behind, written

from hfc_design.batch import folder
from hfc_design.batch.plan import read_batch
from hfc_design.batch.work import Place, run_cells
from hfc_design.core.records import UserError

TINY = """
[set]
search.population = 16
search.generations = 3
simulation.duration_s = 0.1
"""
GRID = f"""{TINY}
[grid]
scenario = ["c-axis-ramp", "c-axis-ramp-cutting"]
run.seed = [0, 1]
"""


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """What the grid leaves behind when nothing happens."""
    return left_behind(tmp_path_factory.mktemp("batch"), GRID)


def test_cells_are_the_grid_and_the_list(tmp_path):
    text = f"{GRID}[[cells]]\nplant.parameters.spindle_inertia = 6.5\n[[cells]]\nrun.seed = 9\n"
    cells = read_batch(written(tmp_path, text)).cells
    # 2 scenarios x 2 seeds with the inertia; the second cell's own seed wins, so 2 of 4 are one
    assert len(cells) == 4 + 2
    assert len({cell.name for cell in cells}) == 6
    assert {cell.scenario.run.seed for cell in cells} == {0, 1, 9}
    assert cells[0].scenario.plant.parameters == {"spindle_inertia": 6.5}
    assert all(cell.scenario.search.population == 16 for cell in cells)


def test_the_name_is_that_of_the_whole_configuration(tmp_path):
    """Also of what stands in the files that it names, and not of where they lie."""

    def names(where, angle):
        (tmp_path / where).mkdir(exist_ok=True)
        (tmp_path / where / "r.csv").write_text(f"t,a\n0,0\n1,{angle}\n")
        scenario = '[reference]\nkind = "csv"\nfile = "r.csv"\n'
        written(tmp_path / where, scenario, "own.toml")
        text = f'{TINY}\n[grid]\nscenario = ["own.toml"]\n'
        return [cell.name for cell in read_batch(written(tmp_path / where, text)).cells]

    assert names("a", 0.01) == names("b", 0.01)
    assert names("a", 0.01) != names("a", 0.02)


def test_a_batch_fills_run_folders_and_skips_them_later(tmp_path, undisturbed):
    path, out = written(tmp_path, GRID), tmp_path / "out"
    assert "4 finished, 0 failed" in batch(path, "--out", out).output
    assert files(out) == undisturbed
    stamps = {name: (out / name).stat().st_mtime_ns for name in undisturbed}
    assert batch(path, "--out", out).exit_code == 0
    assert stamps == {name: (out / name).stat().st_mtime_ns for name in undisturbed}
    assert "4 finished" in batch("--status", out).output


def test_dry_run_touches_nothing(tmp_path):
    found = batch(written(tmp_path, GRID), "--out", tmp_path / "out", "--dry-run")
    assert found.exit_code == 0
    assert "c-axis-ramp-cutting" in found.output
    assert "to go" in found.output
    assert not (tmp_path / "out").exists()


def test_a_failing_cell_stops_nothing_and_is_tried_again(tmp_path, undisturbed):
    path, out = written(tmp_path, GRID), tmp_path / "out"
    victim = read_batch(path).cells[1].name
    (out / victim).mkdir(parents=True)
    (out / victim / "config.toml").mkdir()  # nobody can write that file
    found = batch(path, "--out", out)
    assert found.exit_code == 1
    assert "1 of 4 cells failed" in found.output
    assert victim in found.output
    status = batch("--status", out).output
    assert "3 finished, 1 failed" in status or "1 failed, 3 finished" in status
    (out / victim / "config.toml").rmdir()
    assert batch(path, "--out", out).exit_code == 0
    assert files(out) == undisturbed


def started(path, out):
    return subprocess.Popen(
        [sys.executable, "-m", "hfc_design", "batch", path, "--out", out],
        stderr=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("blow", "moments"),
    [
        (signal.SIGKILL, [2]),
        pytest.param(signal.SIGINT, [1, 2, 3], marks=pytest.mark.slow),
    ],
)
def test_stopped_at_any_moment_and_called_again(tmp_path, undisturbed, blow, moments):
    """As soon as there are checkpoints of so many cells."""
    path, out = written(tmp_path, GRID), tmp_path / "out"
    for cells in moments:
        process = started(path, out)
        while process.poll() is None and len(list(out.glob("*/checkpoint.npz"))) < cells:
            time.sleep(0.01)
        process.send_signal(blow)
        process.wait(timeout=60)
    assert batch(path, "--out", out).exit_code == 0
    assert files(out) == undisturbed


@pytest.mark.slow
def test_two_batches_on_one_folder_share_the_work(tmp_path, undisturbed):
    path, out = written(tmp_path, GRID), tmp_path / "out"
    both = [started(path, out) for _ in range(2)]
    assert [process.wait(timeout=120) for process in both] == [0, 0]
    assert files(out) == undisturbed


def test_what_another_process_is_at_is_left_to_it(tmp_path, undisturbed):
    path, out = written(tmp_path, GRID), tmp_path / "out"
    plan = read_batch(path)
    cells = plan.cells
    folder.note_plan(out, plan)
    seen = []

    def outcome(cell, found):
        seen.append(cell.name)
        if len(seen) == 3:  # the other three are done: now the claim is given back
            claim.__exit__(None, None, None)

    claim = folder.claimed(out, cells[0].name)
    assert claim.__enter__()
    assert "1 running, 3 waiting" in batch("--status", out).output
    run_cells(out, cells, Place(), outcome)
    assert seen == [cell.name for cell in (*cells[1:], cells[0])]
    assert files(out) == undisturbed


@pytest.mark.skipif(os.getuid() != 0, reason="only root can mount a small disk")
def test_a_full_disk_loses_nothing(tmp_path, undisturbed):
    path, disk = written(tmp_path, GRID), tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=700k", "none", str(disk)]
    if subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("no disk can be mounted here")
    try:
        (disk / "filler").write_bytes(b"0" * 400_000)
        found = batch(path, "--out", disk / "out")
        assert found.exit_code == 1
        assert "No space left" in found.output
        (disk / "filler").unlink()
        subprocess.run(["mount", "-o", "remount,size=50M", str(disk)], check=True)
        assert batch(path, "--out", disk / "out").exit_code == 0
        assert files(disk / "out") == undisturbed
    finally:
        subprocess.run(["umount", str(disk)], check=True)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[grid]\nrun.seed = 3\n", ["grid.run.seed = 3", "list"]),
        ("[grid]\nrun.seed = []\n", ["grid.run.seed = []", "list"]),
        ("[grid]\nrun.seed = [-1]\n", ["run.seed = -1", "cell with"]),
        ('[grid]\nscenario = ["nobody"]\n', ["nobody", "no such scenario"]),
        ("[gird]\n", ["gird", "no such key"]),
        ("grid = 3\n", ["grid = 3"]),
        ("[grid\n", ["not valid TOML"]),
        ("[grid]\nsearch.speed = [1]\n", ["search.speed", "no such key"]),
        (
            f"[grid]\nrun.seed = {list(range(400))}\nsearch.generations = {list(range(1, 400))}\n",
            ["159600 cells", "100000"],
        ),
    ],
)
def test_batch_files_that_cannot_be_run(text, words, tmp_path):
    path = written(tmp_path, text)
    with pytest.raises(UserError) as refusal:
        read_batch(path)
    for word in ["mine.toml", *words]:
        assert word in str(refusal.value)
    assert batch(path).exit_code == 2


def test_a_folder_without_a_batch(tmp_path):
    found = batch("--status", tmp_path)
    assert (found.exit_code, "holds no batch" in found.output) == (2, True)
    assert batch(Path("a.toml"), "--status", tmp_path).exit_code == 2
    assert batch().exit_code == 2


def test_brackets_are_no_markup(tmp_path):
    """Of units, in labels and in reasons."""
    text = f"{TINY}[[cells]]\nlabel = 'peak [rad/s] of [/b]'\n"
    path, out = written(tmp_path, text), tmp_path / "out"
    assert "label=peak [rad/s] of [/b]" in batch(path, "--out", out, "--dry-run").output
    (cell,) = read_batch(path).cells
    folder.note_plan(out, read_batch(path))
    folder.note(out, cell.name, "failed", "no [/such] thing")
    said = batch("--status", out)
    assert said.exit_code == 0
    assert "no [/such] thing" in said.output


def test_a_plan_tells_cells_of_one_label_apart(tmp_path):
    text = f"{GRID}[[cells]]\nlabel = 'a'\n[[cells]]\nlabel = 'b'\nscenario = 'c-axis-sine'\n"
    lines = batch(written(tmp_path, text), "--out", tmp_path / "out", "--dry-run").output
    assert "label=b, run.seed=1" in lines
    assert "label=a, scenario=c-axis-ramp-cutting, run.seed=0" in " ".join(lines.split())


@pytest.mark.parametrize("text", ["", "name = 'a'\n", "cells = []\n[set]\n"])
def test_a_batch_of_nothing_is_refused(text, tmp_path):
    found = batch(written(tmp_path, text))
    assert found.exit_code == 2
    assert "asks for nothing; it needs [set], [grid] or [[cells]]" in found.stderr


def test_cells_keep_the_names_that_an_earlier_version_gave_them(tmp_path):
    """Those of the searches that begin with searched laws, and of feed drives with L-SHADE."""
    scenarios = {
        "c-axis-ramp-cutting": "7846d048b6c6a910",
        "feed-drive-circle": "ce5b833d80ac395b",
        "feed-drive-hierarchy": "1fadf82b6370f365",
    }
    file = tmp_path / "batch.toml"
    file.write_text(f'name = "kept"\n[grid]\nscenario = {list(scenarios)}\n')
    assert [cell.name for cell in read_batch(file).cells] == list(scenarios.values())
