"""What a worker takes of its machine, and worker processes that cannot be had."""

import socket
import sys

import pytest
from batches import batch, written
from dask_cluster import GRID

from hfc_design.batch import worker
from hfc_design.batch.cluster import connected
from hfc_design.core.records import UserError

NO_TLS = (None, None, None)


def test_one_gpu_a_worker(monkeypatch):
    monkeypatch.setattr(worker, "entry_points", lambda group: ["cuda"])
    monkeypatch.delenv("JAX_PLATFORMS", raising=False)
    monkeypatch.setenv("CUDA_VISIBLE_DEVICES", "gpu-a,gpu-b")
    assert worker.gpus() == ["gpu-a", "gpu-b"]
    found = batch("none.toml", "--workers", 3)
    assert (found.exit_code, "none.toml" in found.output) == (2, True)
    with (
        pytest.raises(UserError, match="workers=3: there are 2 GPUs"),
        connected(3, None, False, NO_TLS, print),
    ):
        pass
    monkeypatch.setenv("JAX_PLATFORMS", "cpu")
    assert worker.gpus() == []
    with pytest.raises(UserError, match=r"workers=9999: there are \d+ cores"):
        connected(9999, None, False, NO_TLS, print).__enter__()


def test_what_cannot_be_reached(tmp_path, monkeypatch):
    path = written(tmp_path, GRID)
    with socket.socket() as nobody:  # bound, and not listening
        nobody.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{nobody.getsockname()[1]}"
        monkeypatch.setattr("hfc_design.batch.cluster.ANSWER_WITHIN", "1s")
        found = batch(path, "--out", tmp_path / "out", "--scheduler", address)
    assert (found.exit_code, "no scheduler answers" in found.output) == (1, True)
    found = batch(path, "--out", tmp_path / "out", "--scheduler", "here:there")
    assert (found.exit_code, "--scheduler here:there" in found.output) == (2, True)
    assert batch(path, "--workers", 1, "--scheduler", address).exit_code == 2
    assert batch(path, "--shared").exit_code == 2
    assert "has no such folder" in worker._run_in(tmp_path / "elsewhere", "a", print).reason


def test_keys_that_cannot_be_had(tmp_path, monkeypatch):
    """Nothing is begun without them."""
    path = written(tmp_path, GRID)
    monkeypatch.setitem(sys.modules, "cryptography", None)
    found = batch(path, "--out", tmp_path / "out", "--workers", 1)
    assert (found.exit_code, found.stderr.count("\n")) == (2, 1)
    assert "--workers needs the package cryptography: pip install" in found.stderr
    keys = [f"--tls-{part}={path}" for part in ("ca", "cert", "key")]
    for options in (keys, [keys[0], "--scheduler", "a:1"], [*keys, "--workers", 1]):
        found = batch(path, "--out", tmp_path / "out", *options)
        assert found.exit_code == 2
        assert "--tls-ca, --tls-cert and --tls-key belong together" in found.stderr
    found = batch(path, "--out", tmp_path / "out", *keys, "--scheduler", "tls://127.0.0.1:1")
    assert (found.exit_code, "--tls-ca " in found.stderr) == (2, True)
    found = batch(path, "--tls-ca", tmp_path / "none")
    assert (found.exit_code, "does not exist" in found.stderr) == (2, True)


def test_without_the_package(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    for name in ("cluster", "worker"):
        monkeypatch.delitem(sys.modules, f"hfc_design.batch.{name}")
        monkeypatch.delattr(f"hfc_design.batch.{name}")
    found = batch(written(tmp_path, GRID), "--out", tmp_path / "out", "--workers", 1)
    assert found.exit_code == 2
    assert "pip install 'hfc-design[cluster]'" in found.output
    assert found.output.count("\n") == 1
