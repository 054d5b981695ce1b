"""Lock of a folder of results: only the process that holds the lock writes into the folder.

The holder keeps a lock file open under ``flock``, which the system releases when the process ends,
for whatever reason. A heartbeat updates the time of the lock file. If it stops, because the process
is frozen or its computer is lost, another process may overtake: it renames a lock file of its own
over the old one. ``check`` refuses to write if the process's lock file is no longer in its place.
(Locks of the package filelock expire too, but leave this check to their callers, and recognise dead
processes by their process numbers.)
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

#: Name of the lock file of a run folder; its text names the process that holds the lock.
LOCK = ".in-use"
#: Begin and end of the name of a file or folder being written; ``checkpoint.tidy`` deletes such.
TEMPORARY = ".hfc-", ".new"
#: Environment variable: seconds without a heartbeat after which another process may overtake.
GRACE = "HFC_LOCK_GRACE_S"
#: Seconds between two heartbeats, and between two attempts of a process that waits for a lock.
BEAT, PATIENCE = 5.0, 0.1
#: Number of attempts to take a lock, and seconds between them: ``in_use`` holds it for a moment.
TRIES, LOOK = 3, 0.02
#: Flags for opening a lock file: follow no link, wait for no pipe, let no child process inherit it.
READ = os.O_NOFOLLOW | os.O_CLOEXEC | os.O_NONBLOCK


class Overtaken(RunError):
    """Error: another process took over the lock, as this one sent no heartbeat for too long."""


#: Locks of this process: path of the lock file, folder that it guards, descriptor of the open file.
_held: set[tuple[Path, Path, int]] = set()
_changing = threading.Lock()


@contextmanager
def try_lock(folder: Path, path: Path | None = None) -> Iterator[bool]:
    """Try to lock ``folder``, and yield whether it worked; ``path`` replaces its file ``LOCK``.

    Raises:
        RunError: the lock cannot be written.
    """
    path, beat = path or folder / LOCK, min(BEAT, stale_after() / 6.0)
    place = path if folder.is_dir() else folder
    with writing(place), _changing:  # else two threads might overtake each other
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
            except OSError:  # closing the file releases the lock all the same
                pass
            finally:
                os.close(descriptor)


@contextmanager
def exclusive(folder: Path) -> Iterator[None]:
    """Lock ``folder`` for this process, so that no other process writes into it.

    If the folder did not exist before, and nothing was written into it, it is removed at the end.

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
            with suppress(OSError):  # the folder is not empty
                folder.rmdir()


@contextmanager
def wait_for(folder: Path, path: Path) -> Iterator[None]:
    """Wait until the lock file ``path`` can lock ``folder``; RunError: it cannot be written."""
    while True:
        with try_lock(folder, path) as mine:
            if mine:
                yield
                return
        time.sleep(PATIENCE)


def in_use(folder: Path) -> bool:
    """Return whether a process with a recent heartbeat holds the lock; this writes nothing."""
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
    """Return the seconds without a heartbeat until overtaking; UserError: ``GRACE`` is invalid."""
    given = os.environ.get(GRACE, "60")
    if 1.0 <= (seconds := number_or_none(given) or 0.0) <= 1e6:
        return seconds
    raise UserError(f"{GRACE} = {given[:40]!r}: must be a number of seconds from 1 to 1e6")


def _taken(path: Path) -> int | None:
    """Return the descriptor of the lock file if this process gets the lock, else None."""
    for _ in range(TRIES):
        with ExitStack() as closing:
            file = os.open(path, READ | os.O_RDWR | os.O_CREAT, 0o666)
            closing.callback(os.close, file)
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                time.sleep(LOOK)
                silent = abs(time.time() - os.fstat(file).st_mtime) > stale_after() / 2.0
                if silent and (new := _overtaken(path)) is not None:  # by the disk's clock too
                    return new
            else:
                if _lies_at(path, file):  # else the file was deleted or replaced meanwhile
                    _sign(file)
                    closing.pop_all()
                    return file
    return None


def _overtaken(path: Path) -> int | None:
    """Replace a lock file without recent heartbeats by our own; return its descriptor, or None."""
    temporary = path.with_name(secrets.token_hex(8).join(TEMPORARY))
    new = os.open(temporary, READ | os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
    with suppress(FileNotFoundError):  # the holder has just deleted the old file
        fcntl.flock(new, fcntl.LOCK_EX | fcntl.LOCK_NB)
        _sign(new)
        if os.fstat(new).st_mtime - path.lstat().st_mtime > stale_after():
            temporary.replace(path)
            return new
    temporary.unlink(missing_ok=True)
    os.close(new)
    return None


def _lies_at(path: Path, descriptor: int) -> bool:
    """Return whether the open file ``descriptor`` is the file that now lies at ``path``."""
    try:
        there = os.open(path, READ)  # asks the server of a network file system; stat may not
    except FileNotFoundError:
        return False
    try:
        return os.path.samestat(os.fstat(there), os.fstat(descriptor))
    finally:
        os.close(there)


def _sign(descriptor: int) -> None:
    """Write into the open lock file which process holds it, and update the time of the file."""
    name = Path(*sys.argv[:1]).name.replace("__main__.py", "hfc")
    holder = f"process {os.getpid()} on {socket.gethostname()} since {time.strftime('%F %T')}"
    os.utime(descriptor)
    with suppress(OSError):  # a full disk
        os.ftruncate(descriptor, 0)
        text = f"{holder} ({shlex.join([name, *sys.argv[1:]])[:100]})\n"
        os.pwrite(descriptor, text.encode(errors="replace"), 0)


def _holder(path: Path) -> str:
    """Return the text of a lock file on its holder, or "another process" if there is none."""
    with suppress(OSError), open(os.open(path, READ), "rb") as file:
        return file.read(200).decode(errors="replace").strip() or "another process"
    return "another process"


@cache
def _heart(seconds: float) -> None:
    """Start the thread of the heartbeat, every ``seconds``; further calls do nothing."""

    def beat() -> None:
        while True:
            time.sleep(seconds)
            with _changing:
                for *_, descriptor in _held:
                    with suppress(OSError):
                        os.utime(descriptor)

    threading.Thread(target=beat, name="locks", daemon=True).start()
