"""Lock of a folder of results: only the process that holds the lock writes into the folder.

The holder keeps a lock file open and locked; the system unlocks it when the process ends, for
whatever reason. A heartbeat updates the time of the lock file. If it stops, because the process
is frozen or its computer is lost, another process may overtake: it renames a lock file of its own
over the old one. ``check`` refuses to write if the process's lock file is no longer in its place.
(Locks of the package filelock expire too, but leave this check to their callers, and recognise dead
processes by their process numbers.)

Windows locks bytes instead of files. An open file can be renamed there if all who opened it allow
that, but not replaced; if it is deleted, nobody can use its name until it is closed (Microsoft
Learn: LockFile, CreateFileW, DeleteFileW).
"""

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

if sys.platform == "win32":
    import _winapi
    import msvcrt
else:
    import fcntl

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
            with suppress(OSError), open(descriptor, "rb"):  # which closes the file in any case
                if _lies_at(path, descriptor):
                    _remove(path)


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
    with suppress(OSError), open(_opened(folder / LOCK), "rb") as file:
        try:
            _lock(file.fileno(), shared=True)
        except BlockingIOError:
            return abs(time.time() - os.fstat(file.fileno()).st_mtime) <= stale_after()
    return False


def check(path: Path) -> None:
    """Check that the lock of the folder of ``path`` is not lost; Overtaken: it is."""
    place = Path(os.path.realpath(path.parent) if _held else "", path.name)
    for lock, folder, descriptor in tuple(_held):
        if folder in place.parents and not _lies_at(lock, descriptor):
            silent = f"as this process was silent for more than {stale_after():g} s"
            taken = f"{path.parent} was taken over by {_holder(lock)}, {silent}"
            raise Overtaken(f"{taken}; {path.name} was not written")


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
            file = _opened(path, "a")
            closing.callback(os.close, file)
            try:
                _lock(file)
            except BlockingIOError:
                time.sleep(LOOK)
                silent = abs(time.time() - os.fstat(file).st_mtime) > stale_after() / 2.0
                if silent and (new := _overtaken(path)) is not None:  # by the disk's clock too
                    return new
            else:
                if _lies_at(path, file):  # else the file was deleted or replaced meanwhile
                    _sign(path, file)
                    closing.pop_all()
                    return file
    return None


def _overtaken(path: Path) -> int | None:
    """Replace a lock file without recent heartbeats by our own; return its descriptor, or None."""
    temporary = new_name(path)
    new = _opened(temporary, "x")
    with suppress(FileNotFoundError, PermissionError):  # another process was quicker
        _lock(new)
        _sign(temporary, new)
        if os.fstat(new).st_mtime - path.lstat().st_mtime > stale_after():
            if sys.platform == "win32":
                _remove(path)
            temporary.replace(path)
            return new
    temporary.unlink(missing_ok=True)
    os.close(new)
    return None


def _lies_at(path: Path, descriptor: int) -> bool:
    """Return whether the open file ``descriptor`` is the file that now lies at ``path``."""
    # This asks the server of a network file system; stat may not.
    with suppress(FileNotFoundError), open(_opened(path), "rb") as there:
        return os.path.samestat(os.fstat(there.fileno()), os.fstat(descriptor))
    return False


def new_name(path: Path) -> Path:
    """Return a new name in the folder of ``path``, for a file that is being written or removed."""
    return path.with_name(secrets.token_hex(8).join(TEMPORARY))


def _opened(path: Path, mode: str = "r") -> int:
    """Return the descriptor of a file; "a" creates it if it is missing, "x" refuses an old one.

    No link is followed, no pipe is waited for, and no child process inherits the file.
    """
    if sys.platform == "win32":
        when = {"r": 3, "a": 4, "x": 1}[mode]  # OPEN_EXISTING, OPEN_ALWAYS, CREATE_NEW
        # For reading and writing; others may read, write and rename it; a link itself is opened.
        handle = _winapi.CreateFile(str(path), 0xC0000000, 7, 0, when, 0x200000, 0)
        file = msvcrt.open_osfhandle(handle, 0)
    else:
        how = {"r": 0, "a": os.O_RDWR | os.O_CREAT, "x": os.O_RDWR | os.O_CREAT | os.O_EXCL}[mode]
        file = os.open(path, how | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666)
    return file


def _lock(file: int, shared: bool = False) -> None:
    """Lock an open file until it is closed; BlockingIOError: another process has locked it."""
    if sys.platform == "win32":
        os.lseek(file, 2**30, os.SEEK_SET)  # beyond the text: nobody else can read what is locked
        try:
            msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        except OSError as error:
            raise BlockingIOError(*error.args) from None
    else:
        fcntl.flock(file, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)


def _remove(path: Path) -> None:
    """Remove a file that is open, so that its name is free at once."""
    if sys.platform == "win32":
        path = path.rename(new_name(path))
    path.unlink()


def _sign(path: Path, descriptor: int) -> None:
    """Write into the open lock file which process holds it, and update the time of the file."""
    name = Path(*sys.argv[:1]).name.replace("__main__.py", "hfc")
    holder = f"process {os.getpid()} on {socket.gethostname()} since {time.strftime('%F %T')}"
    os.utime(path if sys.platform == "win32" else descriptor)
    with suppress(OSError):  # a full disk
        os.ftruncate(descriptor, 0)
        os.lseek(descriptor, 0, os.SEEK_SET)
        text = f"{holder} ({shlex.join([name, *sys.argv[1:]])[:100]})\n"
        os.write(descriptor, text.encode(errors="replace"))


def _holder(path: Path) -> str:
    """Return the text of a lock file on its holder, or "another process" if there is none."""
    with suppress(OSError), open(_opened(path), "rb") as file:
        return file.read(200).decode(errors="replace").strip() or "another process"
    return "another process"


@cache
def _heart(seconds: float) -> None:
    """Start the thread of the heartbeat, every ``seconds``; further calls do nothing."""

    def beat() -> None:
        while True:
            time.sleep(seconds)
            with _changing:
                for path, _, descriptor in _held:
                    with suppress(OSError):
                        os.utime(path if sys.platform == "win32" else descriptor)

    threading.Thread(target=beat, name="locks", daemon=True).start()
