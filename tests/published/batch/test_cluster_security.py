"""Who may send cells to workers, and what may come back from them."""

import json
import re
import shutil
import subprocess

import pytest
from batches import batch, files, left_behind, written
from dask_cluster import SCORED, Cluster
from places import ROOT

from hfc_design.batch.cluster import connected

DOCS = ROOT / "docs" / "cluster.md"
#: What each ``dask`` process is told, and ``hfc batch``.
DASK_TLS = ["--tls-ca-file=cert.pem", "--tls-cert=cert.pem", "--tls-key=key.pem"]
TLS = ["--tls-ca=cert.pem", "--tls-cert=cert.pem", "--tls-key=key.pem"]


@pytest.mark.skipif(not shutil.which("openssl"), reason="makes the certificates")
@pytest.mark.filterwarnings("ignore")  # of connections that are refused
def test_a_scheduler_with_certificates(tmp_path, tmp_path_factory, monkeypatch):
    """Made as the page on clusters says."""
    (command,) = re.findall(r"^openssl req .*$", DOCS.read_text(), re.MULTILINE)
    other, alone = tmp_path_factory.mktemp("other"), tmp_path_factory.mktemp("alone")
    for place in (tmp_path, other):
        subprocess.run(command, shell=True, check=True, cwd=place, capture_output=True)
    monkeypatch.chdir(tmp_path)
    asked = (written(tmp_path, SCORED), "--out", tmp_path / "out", "--scheduler")
    with Cluster(tmp_path, *DASK_TLS, count=1) as cluster:
        address = cluster.up()
        assert address.startswith("tls://")
        bare = address.removeprefix("tls://")
        foreign = [option.replace("=", f"={other}/") for option in TLS]
        half = [TLS[0], *foreign[1:]]
        for options, code, words in (
            ([address], 2, f"--scheduler {address}: needs --tls-ca, --tls-cert, --tls-key"),
            ([bare], 1, f"--scheduler {bare}: no scheduler answers at this address"),
            (
                [address, *foreign],
                1,
                "no scheduler that knows these certificates answers at this address",
            ),
            (
                [address, *half],
                1,
                "no scheduler that knows these certificates answers at this address",
            ),
            ([f"tcp://{bare}", *TLS], 2, "must be tls://HOST:PORT with --tls-ca"),
            (["here:there", *TLS], 2, "must be an address"),
            ([address, TLS[0], TLS[1], foreign[2]], 2, "KEY_VALUES_MISMATCH"),
        ):
            with monkeypatch.context() as patch:
                patch.setattr("hfc_design.batch.cluster.ANSWER_WITHIN", "2s")
                found = batch(*asked, *options)
            assert (found.exit_code, found.stderr.count("\n")) == (code, 1), found.output
            assert words in found.stderr
        assert batch(*asked, bare, *TLS).exit_code == 0
        assert files(tmp_path / "out") == left_behind(alone, SCORED)


EVIL = "type('Evil', (), {'__reduce__': lambda self: (__import__('os').mkdir, (%r,))})()"
FINE = {"state": "finished", "reason": "", "seconds": 1.0, "files": {"design.json": b"x" * 10**7}}


@pytest.fixture(scope="module")
def place():
    with connected(1, None, False, (None, None, None), lambda count: None) as found:
        yield found


def outcome(place, text):
    """What the batch makes of what a worker evaluates and sends."""
    task = place._client.submit(eval, text, pure=False)
    found = []
    while not found:
        found = list(place.done([task]))
    return found[0][1]


def test_results_are_not_unpickled(tmp_path, place):
    evil = EVIL % str(tmp_path / "evil")
    for text in (
        evil,
        f"[{evil}]",
        f"{{'state': {evil}}}",
        f"{FINE | {'files': 0}!r} | {{1: {evil}}}",
    ):
        found = outcome(place, text)
        assert (found.state, found.reason[:11]) == ("failed", "on a worker")
    assert list(tmp_path.iterdir()) == []
    others = ("usable.json", "front.csv", "polish.npz", "checkpoint-2.npz", "history.csv")
    for sent in (FINE["files"], dict.fromkeys(others, b"x")):
        fine = FINE | {"files": sent}
        assert outcome(place, repr(fine)).model_dump() == fine


@pytest.mark.parametrize(
    "change",
    [
        {"state": "done"},
        {"state": None},
        {"reason": "x" * 3000},
        {"reason": 3},
        {"seconds": -1.0},
        {"seconds": "nan"},
        {"files": {"../evil": b""}},
        {"files": {"/tmp/evil": b""}},
        {"files": {"config.toml": b""}},
        {"files": {"design.json\n": b""}},
        {"files": {"x/design.json": b""}},
        {"files": {".in-use": b""}},
        {"files": {"design.json": 3}},
        {"files": [b""]},
        {"more": 1},
        5,
        None,
        [FINE],
        {},
    ],
    ids=lambda change: json.dumps(change, default=repr)[:30],
)
def test_results_that_are_none(change, place):
    sent = FINE | change if change and isinstance(change, dict) else change
    found = outcome(place, repr(sent))
    assert (found.state, found.files) == ("failed", {})
    assert found.reason.startswith("on a worker: UserError: what it sent: ")
    assert len(found.reason) < 300
