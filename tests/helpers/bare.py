"""A computer without what Windows lacks: imported for ``HFC_BARE=1``, before the package.

The package and the experiments (``OURS``) cannot import the modules of ``MISSING``, see the names
``NOT_IN_OS``, open a file in /proc, nor rename, replace or delete a file that this process has
open. ``core.lock`` runs its code for Windows, on stand-ins for ``msvcrt`` and ``_winapi``. Other
packages see the computer as it is: on Windows they do without, too.
"""

import builtins
import fcntl
import os
import sys
from pathlib import Path
from types import FrameType, ModuleType

OURS = ("hfc_design", "plants", "experiments")
#: Where the locks of Windows are taken.
LOCK = "hfc_design.core.lock"
MISSING = {"fcntl", "grp", "pwd", "resource", "termios"}
NOT_IN_OS = {
    *("O_CLOEXEC", "O_DIRECTORY", "O_NOFOLLOW", "O_NONBLOCK", "fork", "getuid", "killpg"),
    *("mkfifo", "pread", "pwrite", "sched_getaffinity", "sched_setaffinity", "uname"),
}
#: Marks descriptors of files that may be renamed and deleted while they are open.
SHARED = os.O_NONBLOCK
#: Modules between ours and the call that opens, renames or deletes a file.
BETWEEN = ("contextlib", "pathlib", "pathlib._local", "shutil", "tempfile")


class _Os(ModuleType):
    """The module ``os`` of Windows."""

    supports_fd: set[object] = set()

    def __getattr__(self, name):
        if name in NOT_IN_OS:
            raise AttributeError(f"module 'os' has no attribute {name!r}")
        return getattr(os, name)

    @staticmethod
    def utime(path, *others, **more):
        """Set the time of a file, which must be a path."""
        os.utime(os.fspath(path), *others, **more)

    @staticmethod
    def open(path, *others, **more):
        """Open a file, but no folder."""
        if os.path.isdir(path):
            raise PermissionError(13, "Permission denied", str(path))
        return os.open(path, *others, **more)


class _Sys(ModuleType):
    platform = "win32"

    def __getattr__(self, name):
        return getattr(sys, name)


class _Msvcrt(ModuleType):
    LK_NBLCK = 2

    @staticmethod
    def locking(file, mode, count):
        """Lock the file where the byte at its position would be locked."""
        assert (mode, count) == (2, 1)
        assert os.lseek(file, 0, os.SEEK_CUR) > 1_000_000, "the text could not be read"
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise PermissionError(13, "Permission denied") from None

    @staticmethod
    def open_osfhandle(handle, flags):
        """Return the descriptor, which is the handle here."""
        return handle


class _Winapi(ModuleType):
    @staticmethod
    def CreateFile(path, access, share, security, disposition, flags, template):
        """Open a file as the package does, so that it may be renamed and deleted."""
        assert (access, share, flags) == (0xC0000000, 7, 0x200000)
        more = {1: os.O_CREAT | os.O_EXCL, 3: 0, 4: os.O_CREAT}[disposition]
        return os.open(path, os.O_RDWR | os.O_NOFOLLOW | SHARED | more, 0o666)


INSTEAD = {"os": _Os("os")}
OF_LOCK = {"sys": _Sys("sys"), "msvcrt": _Msvcrt("msvcrt"), "_winapi": _Winapi("_winapi")}
_import = builtins.__import__
_looking = False


def _imported(name, given=None, *others, **more):
    importer = (given or {}).get("__name__", "")
    if importer.split(".")[0] in OURS:
        if name in MISSING:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
        own = INSTEAD | OF_LOCK if importer == LOCK else INSTEAD
        if name in own:
            return own[name]
    return _import(name, given, *others, **more)


def _by_us(frame: FrameType | None):
    """Whether one of our modules called, directly or through those of ``BETWEEN``."""
    while frame is not None and frame.f_globals.get("__name__") in BETWEEN:
        frame = frame.f_back
    return frame is not None and frame.f_globals.get("__name__", "").split(".")[0] in OURS


def _open_here(path, but=0):
    """Descriptors of this process that have the file at ``path`` open without the flag ``but``."""
    if not os.path.isfile(path):
        return set()
    known, found = os.stat(path, follow_symlinks=False), set()
    for name in os.listdir("/proc/self/fd"):
        try:
            file = int(name)
            flags = fcntl.fcntl(file, fcntl.F_GETFL)
            if os.path.samestat(os.fstat(file), known) and not flags & but:
                found.add(file)
        except OSError:  # the folder that is being listed
            pass
    return found


def _audit(event, arguments):
    global _looking  # noqa: PLW0603
    if _looking or event not in ("open", "os.listdir", "os.rename", "os.remove"):
        return
    _looking = True
    try:
        if not _by_us(sys._getframe().f_back):  # none: the program itself is opened
            return
        path = arguments[0]
        if event in ("open", "os.listdir"):
            if isinstance(path, str | Path) and os.fspath(path).startswith("/proc/"):
                raise FileNotFoundError(2, "No such file or directory", str(path))
            return
        busy = _open_here(path, SHARED)
        if event == "os.rename":
            busy |= _open_here(arguments[1])
        if busy:
            raise PermissionError(13, "The process cannot access the file", str(path))
    finally:
        _looking = False


assert not [name for name in sys.modules if name.split(".")[0] in OURS], "imported too late"
builtins.__import__ = _imported
sys.addaudithook(_audit)
