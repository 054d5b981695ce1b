"""Lock of a folder of results: one process at a time writes there, and not after losing it.

A lock is a file that its holder keeps by ``flock``, which the system releases when a process ends,
for any reason. A heartbeat updates the time of the file, so that a frozen holder, or one on a lost
machine, can be overtaken: the new holder renames a lock file of its own over the old one. The file
at that place is the fence: ``check`` refuses to write for the holder of another. (Leases of the
package filelock expire likewise, but leave the fence to their callers, and recognise dead processes
by their numbers.)
"""

import fcntl
import os
import secrets
import shlex
import socket
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from pathlib import Path

from hfc_design.core.numbers import number_or_none
from hfc_design.core.records import RunError, UserError, writing

#: The lock of a run folder; its text says whose it is.
LOCK = ".in-use"
#: Begin and end of the name of a file or a folder that is being written; ``checkpoint.tidy``.
TEMPORARY = ".hfc-", ".new"
#: Environment variable: seconds of silence after which a holder may be overtaken.
GRACE = "HFC_LOCK_GRACE_S"
#: Seconds between heartbeats, and between looks of who waits.
BEAT, PATIENCE = 5.0, 0.1
#: Somebody may only have looked whether a lock is held: so often, and so much later, it is tried.
TRIES, LOOK = 3, 0.02
#: How a lock file is opened: no link is followed, no pipe waited for, no child inherits it.
READ = os.O_NOFOLLOW | os.O_CLOEXEC | os.O_NONBLOCK


class Overtaken(RunError):
    """Another process has taken the folder, because this one had been silent for too long."""


#: Locks of this process: the file, the folder that it guards, the open file.
_held: set[tuple[Path, Path, int]] = set()
_changing = threading.Lock()


@contextmanager
def try_lock(folder: Path, path: Path | None = None) -> Iterator[bool]:
    """Whether this process alone may write into ``folder``; ``path`` replaces its ``LOCK``.

    Raises:
        RunError: the lock cannot be written.
    """
    path, beat = path or folder / LOCK, min(BEAT, stale_after() / 6.0)
    place = path if folder.is_dir() else folder
    with writing(place), _changing:  # two threads would both be told that they were overtaken
        path.parent.mkdir(parents=True, exist_ok=True)
        if (descriptor := _taken(path)) is not None:
            lock = path, Path(os.path.realpath(folder)), descriptor
            _held.add(lock)
    if descriptor is None:
        yield False
        return
    _heart(beat)
    try:
        yield True
    finally:
        with _changing:
            _held.remove(lock)
            try:
                if _lies_at(path, descriptor):
                    path.unlink()
            except OSError:  # it is free all the same
                pass
            finally:
                os.close(descriptor)


@contextmanager
def exclusive(folder: Path) -> Iterator[None]:
    """Lock ``folder`` for this process, so that no other one writes there.

    A folder that was not there before, and in which nothing was written, is removed.

    Raises:
        RunError: another process has locked it, or the lock cannot be written.
    """
    new = not folder.exists()
    try:
        with try_lock(folder) as mine:
            if not mine:
                raise RunError(f"{folder} is in use by {_holder(folder / LOCK)}")
            yield
    finally:
        if new:
            with suppress(OSError):  # it holds something
                folder.rmdir()


@contextmanager
def wait_for(folder: Path, path: Path) -> Iterator[None]:
    """Wait for another lock than the folder's own; RunError: it cannot be written."""
    while True:
        with try_lock(folder, path) as mine:
            if mine:
                yield
                return
        time.sleep(PATIENCE)


def in_use(folder: Path) -> bool:
    """Whether a process uses the folder; nothing is written to find out."""
    with suppress(OSError):
        file = os.open(folder / LOCK, READ)
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return abs(time.time() - os.fstat(file).st_mtime) <= stale_after()
        finally:
            os.close(file)
    return False


def check(path: Path) -> None:
    """Refuse to write a file into a folder whose lock this process has lost.

    Raises:
        Overtaken: the lock is lost.
    """
    place = Path(os.path.realpath(path.parent) if _held else "", path.name)
    for lock, folder, descriptor in tuple(_held):
        if folder in place.parents and not _lies_at(lock, descriptor):
            raise Overtaken(
                f"{path.parent} was taken over by {_holder(lock)}, as this process was "
                f"silent for more than {stale_after():g} s; {path.name} was not written"
            )


def stale_after() -> float:
    """Seconds of silence after which a holder may be overtaken; UserError: an invalid setting."""
    given = os.environ.get(GRACE, "60")
    if 1.0 <= (seconds := number_or_none(given) or 0.0) <= 1e6:
        return seconds
    raise UserError(f"{GRACE} = {given[:40]!r}: must be a number of seconds from 1 to 1e6")


def _taken(path: Path) -> int | None:
    """The open lock file if this process has got it."""
    for _ in range(TRIES):
        with ExitStack() as closing:
            file = os.open(path, READ | os.O_RDWR | os.O_CREAT, 0o666)
            closing.callback(os.close, file)
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                time.sleep(LOOK)
                silent = abs(time.time() - os.fstat(file).st_mtime) > stale_after() / 2.0
                if silent and (new := _overtaken(path)) is not None:  # the disk's clock says so too
                    return new
            else:
                if _lies_at(path, file):  # else it was given back, or overtaken, meanwhile
                    _sign(file)
                    closing.pop_all()
                    return file
    return None


def _overtaken(path: Path) -> int | None:
    """An open lock file of our own in the place of one that has been silent for too long."""
    temporary = path.with_name(secrets.token_hex(8).join(TEMPORARY))
    new = os.open(temporary, READ | os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
    with suppress(FileNotFoundError):  # the holder has just given it back
        fcntl.flock(new, fcntl.LOCK_EX | fcntl.LOCK_NB)
        _sign(new)
        if os.fstat(new).st_mtime - path.lstat().st_mtime > stale_after():
            temporary.replace(path)
            return new
    temporary.unlink(missing_ok=True)
    os.close(new)
    return None


def _lies_at(path: Path, descriptor: int) -> bool:
    """Whether the open file is the one at the path."""
    try:
        there = os.open(path, READ)  # asks the server of a network file system, stat may not
    except FileNotFoundError:
        return False
    try:
        return os.path.samestat(os.fstat(there), os.fstat(descriptor))
    finally:
        os.close(there)


def _sign(descriptor: int) -> None:
    """Say who holds the lock."""
    name = Path(*sys.argv[:1]).name.replace("__main__.py", "hfc")
    holder = f"process {os.getpid()} on {socket.gethostname()} since {time.strftime('%F %T')}"
    os.utime(descriptor)
    with suppress(OSError):  # a full disk
        os.ftruncate(descriptor, 0)
        text = f"{holder} ({shlex.join([name, *sys.argv[1:]])[:100]})\n"
        os.pwrite(descriptor, text.encode(errors="replace"), 0)


def _holder(path: Path) -> str:
    """Holder of a lock, from its file."""
    with suppress(OSError), open(os.open(path, READ), "rb") as file:
        return file.read(200).decode(errors="replace").strip() or "another process"
    return "another process"


@cache
def _heart(seconds: float) -> None:
    """Begin to beat, once."""

    def beat() -> None:
        while True:
            time.sleep(seconds)
            with _changing:
                for *_, descriptor in _held:
                    with suppress(OSError):
                        os.utime(descriptor)

    threading.Thread(target=beat, name="locks", daemon=True).start()
