"""Ctrl-C that is not lost.

Python raises it wherever it happens to be. In a callback that some library has the garbage
collector call, JAX's among them, it is printed and ignored there, and a long search would go on.
"""

import signal
import sys
from types import FrameType

_told: list[int] = []


def listen() -> None:
    """Note every Ctrl-C from now on; where it is ignored, as after ``nohup``, it stays so."""
    _told.clear()
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _note)
        sys.unraisablehook = _ignored


def heard() -> None:
    """Raise KeyboardInterrupt, once, where it has been raised already since ``listen``."""
    if _told:
        _told.clear()
        raise KeyboardInterrupt


def _ignored(fault: "sys.UnraisableHookArgs") -> None:
    """Nothing is told of a Ctrl-C that is ignored: it is heard."""
    if not isinstance(fault.exc_value, KeyboardInterrupt):
        sys.__unraisablehook__(fault)


def _note(number: int, frame: FrameType | None) -> None:
    _told.append(number)
    signal.default_int_handler(number, frame)
