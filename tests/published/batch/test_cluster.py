"""Batches on worker processes: real schedulers and workers on this machine, killed at will."""

import os
import signal
import subprocess

import pytest
from batches import batch, files, left_behind, written
from dask_cluster import GRID, alive, ended, first_finished, killed, psutil, until
from distributed import Client
from distributed.security import Security

from hfc_design.batch.plan import read_batch


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """What the grid leaves behind without any workers."""
    return left_behind(tmp_path_factory.mktemp("batch"), GRID)


def pid():
    return os.getpid()


def heard(address, **options):
    """Whether somebody there does what a stranger asks for."""
    try:
        with Client(address, timeout="1s", **options) as client:
            return bool(client.run(pid) or client.run_on_scheduler(pid))
    except Exception:  # of many kinds
        return False


def page(port):
    """What a browser of another user is shown."""
    command = ["curl", "-s", "-m", "1", "-o", os.devnull, "-w", "%{http_code}"]
    return subprocess.run(
        [*command, f"http://127.0.0.1:{port}/json/counts.json"], capture_output=True, check=False
    ).stdout.decode()


@pytest.mark.filterwarnings("ignore")  # of connections that are refused
def test_a_worker_of_our_own_is_killed_and_none_hears_anybody_else(tmp_path, undisturbed, started):
    process = started("--workers", "2")
    first_finished(tmp_path / "out")
    own = psutil.Process(process.pid)
    workers = [child for child in own.children() if "spawn_main" in " ".join(child.cmdline())]
    assert len(workers) == 2
    workers[0].kill()
    process.send_signal(signal.SIGSTOP)  # time stands still for the batch, its worker goes on
    ports = {
        connection.laddr.port
        for found in (own, workers[1])
        for connection in found.net_connections()
        if connection.status == psutil.CONN_LISTEN
    }
    process.send_signal(signal.SIGCONT)
    assert len(ports) >= 4  # scheduler, two nannies, worker
    for port in ports:
        assert not heard(f"tcp://127.0.0.1:{port}")
        assert not heard(f"tls://127.0.0.1:{port}", security=Security.temporary())
        assert page(port) in ("000", "404")
    assert ended(process) == (0, [])
    assert files(tmp_path / "out") == undisturbed


def test_a_worker_elsewhere_is_killed(tmp_path, undisturbed, started, cluster):
    process = started("--scheduler", cluster.up())
    first_finished(tmp_path / "out")
    killed(cluster.workers[0])
    assert ended(process) == (0, [])
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
    assert batch(tmp_path / "mine.toml", "--out", out).exit_code == 0
    assert files(out) == undisturbed


def test_the_scheduler_is_lost(tmp_path, undisturbed, started, cluster):
    process = started("--scheduler", cluster.up())
    first_finished(tmp_path / "out")
    cluster.lose_scheduler()
    code, said = ended(process)
    assert (code, len(said), "the scheduler; run the same command" in said[0]) == (1, 1, True), said
    assert batch(tmp_path / "mine.toml", "--out", tmp_path / "out").exit_code == 0
    assert files(tmp_path / "out") == undisturbed


def test_two_batches_share_the_work(tmp_path, undisturbed, started, cluster):
    both = [started("--scheduler", cluster.up(), *shared) for shared in ([], ["--shared"])]
    assert [ended(process) for process in both] == [(0, []), (0, [])]
    assert files(tmp_path / "out") == undisturbed


def test_ctrl_c_ends_our_own_workers(tmp_path, undisturbed, started):
    process = started("--workers", "1")
    first_finished(tmp_path / "out")
    children = psutil.Process(process.pid).children()
    os.killpg(process.pid, signal.SIGINT)  # a terminal tells the whole group
    code, said = ended(process)
    assert (code, len(said), "interrupted" in said[0]) == (1, 1, True), said
    until(lambda: not any(map(alive, children)), what="the end of the workers")
    assert batch(tmp_path / "mine.toml", "--out", tmp_path / "out").exit_code == 0
    assert files(tmp_path / "out") == undisturbed
