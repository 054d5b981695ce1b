"""What a worker takes of its machine, and worker processes that cannot be had."""

import socket
import sys

import pytest
from batches import QUICK, batch, written
from wording import refused, refused_command

from hfc_design.batch import worker
from hfc_design.batch.cluster import connected
from hfc_design.core.records import UserError

NO_TLS = (None, None, None)


@pytest.fixture(autouse=True)
def cluster():
    pytest.importorskip("distributed", reason="it is not installed")


def test_one_gpu_a_worker(monkeypatch):
    monkeypatch.setattr(worker, "entry_points", lambda group: ["cuda"])
    monkeypatch.delenv("JAX_PLATFORMS", raising=False)
    monkeypatch.setenv("CUDA_VISIBLE_DEVICES", "gpu-a,gpu-b")
    assert worker.gpus() == ["gpu-a", "gpu-b"]
    assert refused_command("batch", "none.toml", "--workers", 3).where == "none.toml"
    with refused() as found:
        connected(3, None, False, NO_TLS, print).__enter__()
    assert found.where == "workers=3"
    monkeypatch.setenv("JAX_PLATFORMS", "cpu")
    assert worker.gpus() == []
    with pytest.raises(UserError, match=r"workers=9999: must be at most \d+, one for each core"):
        connected(9999, None, False, NO_TLS, print).__enter__()


def test_what_cannot_be_reached(tmp_path, monkeypatch):
    path = written(tmp_path, QUICK)
    with socket.socket() as nobody:  # bound, and not listening
        nobody.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{nobody.getsockname()[1]}"
        monkeypatch.setattr("hfc_design.batch.cluster.ANSWER_WITHIN", "1s")
        found = batch(path, "--out", tmp_path / "out", "--scheduler", address)
    assert (found.exit_code, "no scheduler answers" in found.output) == (1, True)
    found = refused_command("batch", path, "--scheduler", "here:there")
    assert found.where == "--scheduler here:there"
    refused_command("batch", path, "--workers", 1, "--scheduler", "tcp://127.0.0.1:1")
    refused_command("batch", path, "--shared")
    assert "does not see this folder" in worker.run_in(tmp_path / "elsewhere", "a", print).reason


def test_keys_that_cannot_be_had(tmp_path, monkeypatch):
    """Nothing is begun without them."""
    path = written(tmp_path, QUICK)
    monkeypatch.setitem(sys.modules, "cryptography", None)
    own = ("batch", path, "--out", tmp_path / "out")
    assert refused_command(*own, "--workers", 1).count("\n") == 1
    keys = [f"--tls-{part}={path}" for part in ("ca", "cert", "key")]
    for options in (keys, [keys[0], "--scheduler", "a:1"], [*keys, "--workers", 1]):
        assert refused_command(*own, *options).startswith("hfc: --tls-ca, --tls-cert and --tls-key")
    found = batch(*own[1:], *keys, "--scheduler", "tls://127.0.0.1:1")
    assert (found.exit_code, "--tls-ca " in found.stderr) == (2, True)
    refused_command(*own, "--tls-ca", tmp_path / "none")


def test_without_the_package(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    for name in ("cluster", "worker"):
        monkeypatch.delitem(sys.modules, f"hfc_design.batch.{name}")
        monkeypatch.delattr(f"hfc_design.batch.{name}")
    own = ("batch", written(tmp_path, QUICK), "--out", tmp_path / "out")
    assert refused_command(*own, "--workers", 1).count("\n") == 1
