"""A folder belongs to one process; dead holders block nobody, frozen ones lose it for good."""

import os
import socket
import threading
import time

import pytest
from wording import refused

from hfc_design.core import devices, lock
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.lock import GRACE, LOCK, Overtaken, check, exclusive, in_use, try_lock
from hfc_design.core.records import RunError


def old(path, seconds):
    """Make a file look as if it had last been touched so long ago."""
    os.utime(path, (time.time() - seconds,) * 2)


def test_one_holder_and_nothing_is_left_behind(tmp_path):
    folder = tmp_path / "new" / "run"
    with exclusive(folder):
        assert in_use(folder)
        before = (folder / LOCK).stat()
        with try_lock(folder) as mine:
            assert not mine
        words = rf"{folder} is in use by process {os.getpid()} on {socket.gethostname()} since 2"
        with pytest.raises(RunError, match=words) as refusal, exclusive(folder):
            pass
        assert refusal.value.exit_code == 1
        assert (folder / LOCK).stat().st_ino == before.st_ino
        check(folder / "result")
    assert not folder.exists()
    assert not in_use(folder)
    assert not in_use(tmp_path / "none")
    check(folder / "result")


def test_of_many_who_take_a_silent_lock_one_has_it(tmp_path):
    """Whoever else believes so for a moment is refused to write."""
    for _ in range(5):
        silent = lock._taken(tmp_path / LOCK)  # held, without a heart
        old(tmp_path / LOCK, 1000)
        gate, wrote = threading.Barrier(8), []

        def take(gate=gate, wrote=wrote):
            gate.wait()
            with try_lock(tmp_path) as mine:
                gate.wait()  # all have tried
                try:
                    if mine:
                        check(tmp_path / "result")
                        wrote.append(mine)
                except Overtaken:
                    pass
                gate.wait()

        threads = [threading.Thread(target=take) for _ in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert len(wrote) == 1
        assert list(tmp_path.iterdir()) == []
        os.close(silent)


def test_what_lies_in_the_place_of_a_lock(tmp_path):
    """A link is not followed; whatever else is told in a line, or taken as a lock of nobody."""
    path, target = tmp_path / LOCK, tmp_path / "target"
    target.write_text("mine")
    path.symlink_to(target)
    with pytest.raises(RunError, match="cannot be written: "), exclusive(tmp_path):
        pass
    assert target.read_text() == "mine"
    path.unlink()
    path.mkdir()
    with pytest.raises(RunError, match="cannot be written: Is a directory"), exclusive(tmp_path):
        pass
    assert not in_use(tmp_path)
    path.rmdir()
    os.mkfifo(path)
    assert not in_use(tmp_path)
    path.unlink()
    for text in (b"", b"\xff\x00\x1b[2J" * 100, b"x" * 10**6):
        path.write_bytes(text)
        with exclusive(tmp_path):
            content = path.read_bytes()
            path.write_bytes(text)
            with pytest.raises(RunError) as refusal, exclusive(tmp_path):
                pass
            said = str(refusal.value).removeprefix(f"{tmp_path} is in use by ")
            assert len(said) <= 200
            assert said.isprintable()
        assert content.endswith(b")\n")
        assert not path.exists()
    (tmp_path / "file").write_text("")
    with (
        pytest.raises(RunError, match="file/run: cannot be written"),
        exclusive(tmp_path / "file/run"),
    ):
        pass


def test_a_lock_that_a_user_has_removed_is_lost(tmp_path, tmp_path_factory):
    other = tmp_path_factory.mktemp("other")
    with exclusive(tmp_path):
        (tmp_path / LOCK).unlink()
        with pytest.raises(Overtaken, match="another process"):
            write_whole(tmp_path / "result", b"")
        (tmp_path / "tables").mkdir()
        with pytest.raises(Overtaken):
            write_whole(tmp_path / "tables" / "one", b"")
        write_whole(other / "result", b"")
    assert not (tmp_path / "result").exists()


@pytest.mark.parametrize("value", ["", "soon", "0.5", "nan", "-1", "1e9"])
def test_a_grace_that_is_none(value, tmp_path, monkeypatch):
    monkeypatch.setenv(GRACE, value)
    with refused() as found, exclusive(tmp_path):
        pass
    assert found.where == GRACE
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("pieces", "expected"), [(5, False), (6, True)])
def test_more_than_half_of_what_may_be_mapped_is_crowded(monkeypatch, tmp_path, pieces, expected):
    (tmp_path / "maps").write_text("7f00-7f10 rw-p\n" * pieces)
    (tmp_path / "most").write_text("10\n")
    monkeypatch.setattr(devices, "MAPPED", tmp_path / "maps")
    monkeypatch.setattr(devices, "MOST_MAPPED", tmp_path / "most")
    assert devices.crowded() is expected


def test_a_system_that_counts_nothing_is_never_crowded(monkeypatch, tmp_path):
    monkeypatch.setattr(devices, "MOST_MAPPED", tmp_path / "missing")
    assert devices.crowded() is False
