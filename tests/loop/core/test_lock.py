"""A folder belongs to one process; dead holders block nobody, frozen ones lose it for good."""

import os
import re
import signal
import subprocess
import sys
import time

from holders import holder, last_words

from hfc_design.core.checkpoint import tidy, write_whole
from hfc_design.core.lock import GRACE, LOCK, exclusive, in_use, try_lock, wait_for


def test_a_killed_holder_blocks_nobody(tmp_path):
    with holder(tmp_path, "first") as first:
        assert in_use(tmp_path)
        with try_lock(tmp_path) as mine:
            assert not mine
        first.kill()
        first.wait()
        assert (tmp_path / LOCK).exists()
        assert not in_use(tmp_path)
        with exclusive(tmp_path):
            tidy(tmp_path)  # the kill may have come within a write
            write_whole(tmp_path / "result", b"second")
    assert [file.name for file in tmp_path.iterdir()] == ["result"]


def test_a_frozen_holder_is_overtaken_and_refused_when_it_wakes(tmp_path, monkeypatch):
    monkeypatch.setenv(GRACE, "1")
    with holder(tmp_path, "first", grace=1) as first:
        first.send_signal(signal.SIGSTOP)
        with try_lock(tmp_path) as mine:
            assert not mine  # not yet
        time.sleep(1.5)
        assert not in_use(tmp_path)
        with exclusive(tmp_path):
            write_whole(tmp_path / "result", b"second")
            first.send_signal(signal.SIGCONT)
            (said,) = last_words(first)
            taker = rf"{tmp_path} was taken over by process {os.getpid()} on \S+ since .*, "
            why = r"as this process was silent for more than 1 s; result was not written\n"
            assert re.match(taker + why, said)
            assert in_use(tmp_path)  # it has not given back what is ours
    assert (tmp_path / "result").read_bytes() == b"second"


def test_a_frozen_holder_that_wakes_after_the_taker_has_ended_is_refused(tmp_path, monkeypatch):
    monkeypatch.setenv(GRACE, "1")
    with holder(tmp_path, "first", grace=1) as first:
        first.send_signal(signal.SIGSTOP)
        time.sleep(1.5)
        with exclusive(tmp_path):
            write_whole(tmp_path / "result", b"second")
        first.send_signal(signal.SIGCONT)
        (said,) = last_words(first)
        assert "was taken over by another process" in said
    assert [file.name for file in tmp_path.iterdir()] == ["result"]
    assert (tmp_path / "result").read_bytes() == b"second"


def test_a_heart_beats_for_as_long_as_the_lock_is_held(tmp_path, monkeypatch):
    monkeypatch.setenv(GRACE, "1")
    with holder(tmp_path, "first", grace=1):
        end = time.monotonic() + 2.5
        while time.monotonic() < end:
            with try_lock(tmp_path) as mine:
                assert not mine
    assert {file.name for file in tmp_path.iterdir()} >= {LOCK, "result"}


def test_processes_that_wait_come_one_after_the_other(tmp_path):
    code = (
        "import sys; from pathlib import Path; from hfc_design.core.lock import wait_for\n"
        "folder = Path(sys.argv[1])\n"
        "for _ in range(10):\n"
        "    with wait_for(folder, folder / 'plan.lock'):\n"
        "        count = int((folder / 'count').read_text())\n"
        "        (folder / 'count').write_text(str(count + 1))\n"
    )
    (tmp_path / "count").write_text("0")
    command = [sys.executable, "-c", code, str(tmp_path)]
    processes = [subprocess.Popen(command) for _ in range(3)]
    assert [process.wait(timeout=60) for process in processes] == [0] * 3
    assert (tmp_path / "count").read_text() == "30"
    assert [file.name for file in tmp_path.iterdir()] == ["count"]
    with wait_for(tmp_path, tmp_path / "plan.lock"), exclusive(tmp_path):
        pass  # they are two
