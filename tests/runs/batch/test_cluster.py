"""Batches on worker processes: real schedulers and workers on this machine, killed at will."""

import os
import re
import signal
import socket
import subprocess
import sys
import time
import uuid
from pathlib import Path

import pytest
from batches import batch, files, left_behind, written
from sledge import MODULE, SCENARIO, package

import hfc_design
from hfc_design.core.records import UserError
from hfc_design.runs.batch.plan import read_batch

pytest.importorskip("distributed", reason="batches on a cluster need the package distributed")
psutil = pytest.importorskip("psutil", reason="comes with the package distributed")

from hfc_design.runs.batch import worker  # noqa: E402
from hfc_design.runs.batch.cluster import connected  # noqa: E402

#: Long enough that something can happen to a cell; the last one only scores a design.
GRID = """
[set]
search.population = 16
search.generations = 60
simulation.duration_s = 0.1
[grid]
scenario = ["c-axis-ramp", "c-axis-ramp-cutting"]
run.seed = [0, 1]
[[cells]]
[[cells]]
scenario = "c-axis-ramp"
design = "pd-only"
change.controller.pd.kp = 700.0
"""
PATIENCE = 120.0
#: A plant, a fitness and a law of the user's own, by their names only.
SLEDGE = f"""{SCENARIO}
[fitness]
kind = "last-error"
[controller]
kind = "only-p"
"""
SLEDGES = """
[set]
search.population = 4
search.generations = 1
[grid]
scenario = ["sledge.toml"]
run.seed = [0, 1]
"""
#: The package that is tested, also for processes in other folders.
ROOT = str(Path(hfc_design.__file__).parents[1])
PATHS = [ROOT, *filter(None, [os.environ.get("PYTHONPATH")])]
ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join(PATHS)}


def until(true, *, what):
    """Wait for something that has to happen."""
    end = time.monotonic() + PATIENCE
    while not (found := true()):
        assert time.monotonic() < end, f"waited in vain for {what}"
        time.sleep(0.02)
    return found


def killed(process):
    if process.poll() is None:
        process.kill()
    process.wait(timeout=PATIENCE)


def alive(process):
    try:
        return process.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


class Cluster:
    """A scheduler and two workers, which are put back when they have gone.

    ``path`` is the current folder of all three.
    """

    def __init__(self, path):
        self.path = path
        self._scheduler = None
        self.workers = []

    def __enter__(self):
        return self

    def __exit__(self, *error):
        for process in (*self.workers, self._scheduler):
            killed(process)

    def up(self):
        """Address of the scheduler, once everything runs."""
        if self._scheduler is None or self._scheduler.poll() is not None:
            for worker in self.workers:
                killed(worker)  # of a scheduler that is gone
            self._scheduler = self._begun("scheduler", "--port=0", "--host=127.0.0.1")
        address = until(lambda: self._said("scheduler", r"Scheduler at:\s*(tcp://\S+)"), what="it")
        self.workers = [worker for worker in self.workers if worker.poll() is None]
        while len(self.workers) < 2:
            self.workers.append(self._begun("worker", address, "--nthreads=1", "--no-nanny"))
        return address

    def lose_scheduler(self):
        killed(self._scheduler)

    def _begun(self, what, *arguments):
        command = [sys.executable, "-m", f"distributed.cli.dask_{what}", *arguments]
        folder = ["--local-directory", str(self.path)] if what == "worker" else []
        place = {"cwd": self.path, "env": ENVIRONMENT}
        with (self.path / f"{what}.log").open("wb" if what == "scheduler" else "ab") as log:
            return subprocess.Popen(
                [*command, *folder, "--dashboard-address=:0"], stdout=log, stderr=log, **place
            )

    def _said(self, what, pattern):
        found = re.search(pattern, (self.path / f"{what}.log").read_text())
        return found and found[1]


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with Cluster(tmp_path_factory.mktemp("dask")) as found:
        yield found


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """What the grid leaves behind without any workers."""
    return left_behind(tmp_path_factory.mktemp("batch"), GRID)


@pytest.fixture
def started(tmp_path):
    """Start ``hfc batch`` on the grid, beside it, in a process group of its own."""
    path, processes = written(tmp_path, GRID), []

    def start(*arguments):
        command = [sys.executable, "-m", "hfc_design", "batch", path, "--out", tmp_path / "out"]
        processes.append(
            subprocess.Popen(
                [*command, *arguments],
                stderr=subprocess.PIPE,
                text=True,
                start_new_session=True,
                cwd=tmp_path,
                env=ENVIRONMENT,
            )
        )
        return processes[-1]

    yield start
    for process in processes:
        killed(process)
        process.stderr.close()


def ended(process):
    """(exit code, what it said that is not a line of progress)."""
    said = process.communicate(timeout=PATIENCE)[1]
    return process.returncode, [
        line for line in said.splitlines() if line.split()[0] not in ("cell", "waiting")
    ]


def first_finished(out):
    """Wait for a finished cell: from then on the workers are in the middle of others."""
    until(lambda: list(out.glob("*/design.json")), what="a finished cell")


def test_a_worker_of_our_own_is_killed(tmp_path, undisturbed, started):
    process = started("--workers", "2")
    first_finished(tmp_path / "out")
    children = psutil.Process(process.pid).children()
    workers = [child for child in children if "spawn_main" in " ".join(child.cmdline())]
    assert len(workers) == 2
    workers[0].kill()
    assert ended(process) == (0, [])
    assert files(tmp_path / "out") == undisturbed


def test_a_worker_elsewhere_is_killed(tmp_path, undisturbed, started, cluster):
    process = started("--scheduler", cluster.up())
    first_finished(tmp_path / "out")
    killed(cluster.workers[0])
    assert ended(process) == (0, [])
    assert files(tmp_path / "out") == undisturbed


def test_two_batches_share_the_work(tmp_path, undisturbed, started, cluster):
    both = [started("--scheduler", cluster.up(), *shared) for shared in ([], ["--shared"])]
    assert [ended(process) for process in both] == [(0, []), (0, [])]
    assert files(tmp_path / "out") == undisturbed


@pytest.mark.parametrize("shared", [(), ("--shared",)])
def test_ctrl_c_and_called_again(tmp_path, undisturbed, started, cluster, shared):
    address = cluster.up()
    process = started("--scheduler", address, *shared)
    first_finished(tmp_path / "out")
    process.send_signal(signal.SIGINT)
    code, said = ended(process)
    assert (code, len(said), "interrupted" in said[0]) == (1, 1, True), said
    if shared:  # who goes on does not matter
        assert batch(tmp_path / "mine.toml", "--out", tmp_path / "out").exit_code == 0
    else:
        assert ended(started("--scheduler", address)) == (0, [])
    assert files(tmp_path / "out") == undisturbed


def test_ctrl_c_ends_our_own_workers(tmp_path, undisturbed, started):
    process = started("--workers", "2")
    first_finished(tmp_path / "out")
    children = psutil.Process(process.pid).children()
    os.killpg(process.pid, signal.SIGINT)  # a terminal tells the whole group
    code, said = ended(process)
    assert (code, len(said), "interrupted" in said[0]) == (1, 1, True), said
    until(lambda: not any(map(alive, children)), what="the end of the workers")
    assert batch(tmp_path / "mine.toml", "--out", tmp_path / "out").exit_code == 0
    assert files(tmp_path / "out") == undisturbed


def test_failing_cells_stop_nothing(tmp_path, undisturbed, started, cluster):
    """One that cannot be begun, and one whose checkpoint is damaged."""
    out = tmp_path / "out"
    first, second, *others = [cell.name for cell in read_batch(written(tmp_path, GRID)).cells]
    (out / first / "config.toml").mkdir(parents=True)
    (out / second).mkdir()
    config = undisturbed[f"{second}/config.toml"]
    (out / second / "config.toml").write_bytes(config)
    (out / second / "checkpoint.npz").write_bytes(b"nonsense")
    code, said = ended(started("--scheduler", cluster.up()))
    assert (code, len(said)) == (1, 3), said
    assert first in said[0]
    assert second in said[1]
    assert "checkpoint" in said[1]
    assert "2 of 5 cells failed" in said[2]
    assert "2 failed, 3 finished" in batch("--status", out).output
    (out / first / "config.toml").rmdir()
    (out / second / "checkpoint.npz").unlink()
    done = {name: content for name, content in files(out).items() if name[:16] in others}
    assert done == {name: old for name, old in undisturbed.items() if name[:16] in others}
    assert ended(started("--scheduler", cluster.up())) == (0, [])
    assert files(out) == undisturbed


def test_the_scheduler_is_lost(tmp_path, undisturbed, started, cluster):
    process = started("--scheduler", cluster.up())
    first_finished(tmp_path / "out")
    cluster.lose_scheduler()
    code, said = ended(process)
    assert (code, len(said), "scheduler is lost" in said[0]) == (1, 1, True), said
    assert ended(started("--scheduler", cluster.up())) == (0, [])
    assert files(tmp_path / "out") == undisturbed


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """What the grid of plug-ins leaves behind without workers.

    A process of its own makes it: this one must not know the plug-ins.
    """
    path = tmp_path_factory.mktemp("plain")
    command = [sys.executable, "-m", "hfc_design", "batch", "mine.toml", *sledges(path, "mine")]
    subprocess.run(command, check=True, cwd=path, env=ENVIRONMENT)
    return files(path / "runs" / "mine")


def sledges(path, module):
    """Make the grid in ``path`` one of plug-ins of a module there; returns the options for it."""
    (path / f"{module}.py").write_text(MODULE)
    written(path, SLEDGE, "sledge.toml")
    written(path, SLEDGES)
    objects = {"plant": "SLEDGE", "fitness": "LAST", "controller": "P"}
    return [text for key, name in objects.items() for text in (f"--{key}", f"{module}:{name}")]


def test_workers_of_our_own_know_a_module_of_the_current_folder(tmp_path, plain, started):
    assert len([name for name in plain if name.endswith("design.json")]) == 2
    assert ended(started("--workers", "2", *sledges(tmp_path, "here"))) == (0, [])
    assert files(tmp_path / "out") == plain


def test_workers_elsewhere_need_the_module(tmp_path, plain, started, cluster):
    """Only its name is sent to them."""
    options, address = sledges(tmp_path, "there"), cluster.up()
    code, said = ended(started("--scheduler", address, *options))
    assert (code, len(said)) == (1, 3), said
    for line in said[:2]:
        assert re.search(r"the worker tcp://127\.0\.0\.1:\d+ on \S", line)
        for part in ("--plant there:SLEDGE", "No module named 'there'", "install the module"):
            assert part in line
    (cluster.path / "there.py").write_text(MODULE)
    assert ended(started("--scheduler", address, *options, "--shared")) == (0, [])
    assert files(tmp_path / "out") == plain


def test_workers_elsewhere_need_the_package(tmp_path, plain, started, cluster):
    """Without its entry points they import no module, even if it is there."""
    sledges(tmp_path, "packaged")
    (cluster.path / "packaged.py").write_text(MODULE)
    points = (
        "[hfc_design.plants]",
        "sledge = packaged:SLEDGE",
        "[hfc_design.fitness]",
        "last-error = packaged:LAST",
        "[hfc_design.controllers]",
        "only-p = packaged:P",
    )
    package(tmp_path, *points)
    address = cluster.up()
    code, said = ended(started("--scheduler", address))
    assert (code, len(said)) == (1, 3), said
    for part in ("the worker tcp://", "plant.name = 'sledge'", "is no plant known here"):
        assert part in said[0]
    package(cluster.path, *points)
    assert ended(started("--scheduler", address)) == (0, [])
    assert files(tmp_path / "out") == plain


SHARE = """
import os, sys, threading
from hfc_design.runs.batch import worker
worker.CLAIM = sys.argv[1]
worker.gpus = lambda: ["7"]
threading.Thread(target=threading.Event().wait, daemon=True).start()
worker.take_share(1)
places = {tuple(os.sched_getaffinity(int(task))) for task in os.listdir("/proc/self/task")}
names = "CUDA_VISIBLE_DEVICES", "JAX_PLATFORMS", "JAX_NUM_CPU_DEVICES"
print(places, *map(os.environ.get, names), "jax" in sys.modules, flush=True)
sys.stdin.read()
"""


def test_workers_share_the_cores_of_a_machine():
    """Each has a core of its own, in all its threads, before JAX counts them; one has the GPU."""
    cores = sorted(os.sched_getaffinity(0))
    names = "CUDA_VISIBLE_DEVICES", "JAX_PLATFORMS", "JAX_NUM_CPU_DEVICES"
    plain = {name: value for name, value in os.environ.items() if name not in names}
    command = [sys.executable, "-c", SHARE, uuid.uuid4().hex]  # beside what really runs here
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "env": plain}
    processes, said = [], []
    try:
        for _ in range(len(cores) + 1):  # one more than there are cores
            processes.append(subprocess.Popen(command, **pipes))
            said.append(processes[-1].stdout.readline().strip())
    finally:
        for process in processes:
            process.communicate(timeout=PATIENCE)
    first, *others = [f"{{({core},)}}" for core in cores]
    assert said == [
        f"{first} 7 None None False",
        *(f"{core} None cpu None False" for core in others),
        f"{{{tuple(cores)}}} None cpu 1 False",
    ]


def test_one_gpu_a_worker(monkeypatch):
    monkeypatch.setattr(worker, "entry_points", lambda group: ["cuda"])
    monkeypatch.delenv("JAX_PLATFORMS", raising=False)
    monkeypatch.setenv("CUDA_VISIBLE_DEVICES", "gpu-a,gpu-b")
    assert worker.gpus() == ["gpu-a", "gpu-b"]
    found = batch("none.toml", "--workers", 3)
    assert (found.exit_code, "none.toml" in found.output) == (2, True)
    with pytest.raises(UserError, match="--workers 3: there are 2 GPUs"), connected(3, None):
        pass
    monkeypatch.setenv("JAX_PLATFORMS", "cpu")
    assert worker.gpus() == []
    with pytest.raises(UserError, match=r"--workers 9999: there are \d+ cores"):
        connected(9999, None).__enter__()


def test_what_cannot_be_reached(tmp_path, monkeypatch):
    path = written(tmp_path, GRID)
    with socket.socket() as nobody:  # bound, and not listening
        nobody.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{nobody.getsockname()[1]}"
        monkeypatch.setattr("hfc_design.runs.batch.cluster.ANSWER_WITHIN", "1s")
        found = batch(path, "--out", tmp_path / "out", "--scheduler", address)
    assert (found.exit_code, "no scheduler answers" in found.output) == (1, True)
    found = batch(path, "--out", tmp_path / "out", "--scheduler", "here:there")
    assert (found.exit_code, "--scheduler here:there" in found.output) == (2, True)
    assert batch(path, "--workers", 1, "--scheduler", address).exit_code == 2
    assert batch(path, "--shared").exit_code == 2
    assert "has no such folder" in worker._run_in(tmp_path / "elsewhere", "a", print)[1]


def test_without_the_package(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    for name in ("cluster", "worker"):
        monkeypatch.delitem(sys.modules, f"hfc_design.runs.batch.{name}")
        monkeypatch.delattr(f"hfc_design.runs.batch.{name}")
    found = batch(written(tmp_path, GRID), "--out", tmp_path / "out", "--workers", 1)
    assert found.exit_code == 2
    assert "pip install 'hfc-design[cluster]'" in found.output
    assert found.output.count("\n") == 1
