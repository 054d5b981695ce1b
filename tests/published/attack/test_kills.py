"""Processes killed or frozen at random moments, until each run is done: every file as undisturbed.

Without ``HFC_ATTACK=full`` it is a PD controller that is designed, which compiles fast.
What two processes at once are told: ``tests/published/runs/test_in_use.py``.
"""

import os
import random
import signal
import subprocess
import sys
import time
from contextlib import suppress
from functools import partial

import pytest
from attack import FULL, SEED, Attack, rounds
from batches import batch, files, left_behind, written
from dask_cluster import Cluster, ended, killed, psutil, until

from hfc_design.batch.plan import read_batch
from hfc_design.core.lock import GRACE, LOCK

#: Says when it has imported everything; saves every generation. Its pages have no rivals.
DRIVER = """
import sys
import hfc_design.batch.session, hfc_design.report.page
from hfc_design.cli import main
from hfc_design.report import parts
from hfc_design.runs import stored
parts.BASELINES.clear()
stored.CHECKPOINT_EVERY = 0.0
print("begun", flush=True)
main(sys.argv[1:])
"""
PD = "controller = {kind = 'pd'}"
SMALL = ["search.population=16", f"search.generations={150 if FULL else 40}"]
SMALL += ["simulation.duration_s=0.1"]
CELLS = f"""
[set]
{"" if FULL else PD}
search.population = 16
search.generations = 100
simulation.duration_s = 0.1
[grid]
scenario = ["c-axis-ramp", "c-axis-ramp-cutting"]
run.seed = [0, 1]
"""
#: Long enough that something happens to a cell while it runs.
LONG = CELLS.replace("100", "300")


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The files of the long batch when nothing happens to it."""
    return left_behind(tmp_path_factory.mktemp("undisturbed"), LONG)


def begun(*arguments):
    """A process of our program, as soon as it has imported everything, in a group of its own."""
    command = [sys.executable, "-c", DRIVER, *map(str, arguments)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL, "text": True}
    process = subprocess.Popen(command, start_new_session=True, **pipes)
    assert process.stdout.readline() == "begun\n"
    return process


def ended_well(process):
    process.communicate(timeout=300)
    return process.returncode == 0


def timed(*arguments):
    """Seconds that it takes undisturbed."""
    process, start = begun(*arguments), time.monotonic()
    assert ended_well(process)
    return time.monotonic() - start


def killed_by_chance(attack, chance, process, seconds):
    """Whether a process was killed within that time, and did not end before."""
    with process:
        try:
            process.wait(timeout=seconds if seconds > 1e6 else chance.uniform(0.0, seconds))
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
        outcome = "killed" if process.wait() == -signal.SIGKILL else "done"
        assert process.returncode in (0, -signal.SIGKILL)
    attack.outcomes[outcome] += 1
    return outcome == "killed"


def contents(folder):
    found = (file for file in folder.rglob("*") if file.is_file())
    return {str(file.relative_to(folder)): file.read_bytes() for file in found}


@pytest.mark.parametrize("preset", ["race", "lin-lee-1999"] if FULL else ["race"])
def test_designs_that_are_killed(preset, tmp_path):
    settings = [*SMALL, f"search.preset={preset}"] + [PD] * (not FULL)
    options = [text for setting in settings for text in ("--set", setting)]
    fresh = ["design", "c-axis-ramp", "--quiet", *options, "--out"]
    seconds = timed(*fresh, tmp_path / "whole")
    whole = contents(tmp_path / "whole")
    attack, chance = Attack(f"kills of design, {preset}"), random.Random(SEED)
    runs, wanted = 0, rounds(1, 50)
    while attack.outcomes["killed"] < wanted:
        folder = tmp_path / "run" / "whole"  # the page has the name of the folder
        going = True
        while going:
            last = attack.outcomes["killed"] >= wanted
            again = (folder / "config.toml").exists()
            command = ["design", "--quiet", "--resume", "--out"] if again else fresh
            process = begun(*command, folder)
            going = killed_by_chance(attack, chance, process, 1e9 if last else seconds)
        assert contents(folder) == whole
        runs += 1
        folder.parent.rename(tmp_path / f"done {runs}")
    attack.end(runs=runs)


def test_batches_that_are_killed(tmp_path):
    path = written(tmp_path, CELLS)
    seconds = timed("batch", path, "--out", tmp_path / "whole")
    whole = files(tmp_path / "whole")
    attack, chance = Attack("kills of batch"), random.Random(SEED)
    runs, wanted = 0, rounds(1, 100)
    while attack.outcomes["killed"] < wanted:
        out = tmp_path / f"run {runs}"
        going = True
        while going:
            last = attack.outcomes["killed"] >= wanted
            process = begun("batch", path, "--out", out)
            going = killed_by_chance(attack, chance, process, 1e9 if last else seconds)
        assert files(out) == whole
        runs += 1
    attack.end(runs=runs)


def workers_of(process):
    """Processes that run cells, once they have begun to."""
    try:
        children = psutil.Process(process.pid).children()
        return [child for child in children if "spawn_main" in " ".join(child.cmdline())]
    except psutil.Error:
        return []


@pytest.mark.skipif(not FULL, reason="batch/test_cluster.py kills one")
def test_workers_that_are_killed(undisturbed, tmp_path):
    """One of them, or now and then the batch itself with all."""
    path = written(tmp_path, LONG)
    attack, chance = Attack("kills of workers"), random.Random(SEED)
    runs, wanted = 0, 100
    while attack.outcomes.total() - attack.outcomes["done"] < wanted:
        out, code = tmp_path / f"run {runs}", None
        while code != 0:
            process = begun("batch", path, "--out", out, "--workers", 2)
            while process.poll() is None:
                enough = attack.outcomes.total() - attack.outcomes["done"] >= wanted
                try:
                    process.wait(timeout=300 if enough else chance.uniform(1.0, 8.0))
                except subprocess.TimeoutExpired:
                    assert not enough
                    found = workers_of(process)
                    if found and chance.random() < 0.85:
                        chance.choice(found).kill()
                        attack.outcomes["worker killed"] += 1
                    elif found:
                        os.killpg(process.pid, signal.SIGKILL)
                        attack.outcomes["all killed"] += 1
            with process:
                code = process.wait()
            # 1: a cell had taken four workers with it, or all had gone
            assert code in (0, 1, -signal.SIGKILL)
        assert files(out) == undisturbed
        attack.outcomes["done"] += 1
        runs += 1
    attack.end(runs=runs)


def held_by(locks, pids):
    """Which of the processes holds one of the locks; None: none."""
    for lock in locks:
        with suppress(FileNotFoundError, IndexError):
            if (pid := int(lock.read_text().split()[1])) in pids:
                return pid
    return None


def test_a_frozen_worker_whose_cell_another_takes(undisturbed, tmp_path, monkeypatch):
    """When it wakes, what it writes is refused, whenever it was frozen."""
    monkeypatch.setenv(GRACE, "2")
    path = written(tmp_path, LONG)
    names = [cell.name for cell in read_batch(path).cells]
    attack, chance = Attack("frozen workers"), random.Random(SEED)
    with Cluster(tmp_path, count=1) as cluster:
        for round_ in range(rounds(1, 10)):
            out = tmp_path / f"run {round_}"
            command = [sys.executable, "-m", "hfc_design", "batch", path, "--out", out]
            command += ["--scheduler", cluster.up(), "--shared"]
            pipes = {"stderr": subprocess.PIPE, "text": True}
            process = subprocess.Popen(command, stdout=subprocess.DEVNULL, **pipes)
            locks = [out / name / LOCK for name in names]
            pids = {worker.pid for worker in cluster.workers}
            frozen = until(partial(held_by, locks, pids), what="a cell that a worker is at")
            time.sleep(chance.uniform(0.0, 1.0))
            os.kill(frozen, signal.SIGSTOP)
            try:
                taker = batch(path, "--out", out)
                assert taker.exit_code == 0, taker.output
                assert files(out) == undisturbed
                before = {file: file.stat().st_mtime_ns for file in out.glob("*/*")}
            finally:
                os.kill(frozen, signal.SIGCONT)
            assert ended(process) == (0, [])
            assert files(out) == undisturbed
            cells = {file: file.stat().st_mtime_ns for file in before}
            assert cells == before  # nothing was written again
            attack.outcomes["refused"] += 1
            killed(process)
    attack.end()
