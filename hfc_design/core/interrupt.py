"""Reliable Ctrl-C.

Python raises it at any place in the program. In a callback that a library such as JAX has the
garbage collector call, it is printed and ignored, and a long search would continue.
"""

import signal
import sys
from types import FrameType

_told: list[int] = []


def listen() -> None:
    """Note every Ctrl-C from now on; if it is ignored, as after ``nohup``, it stays ignored."""
    _told.clear()
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _note)
        sys.unraisablehook = _ignored


def heard() -> None:
    """Raise KeyboardInterrupt, once, if there was a Ctrl-C since ``listen``."""
    if _told:
        _told.clear()
        raise KeyboardInterrupt


def _ignored(fault: "sys.UnraisableHookArgs") -> None:
    """Print what Python cannot raise, except a Ctrl-C: it has been noted already."""
    if not isinstance(fault.exc_value, KeyboardInterrupt):
        sys.__unraisablehook__(fault)


def _note(number: int, frame: FrameType | None) -> None:
    _told.append(number)
    signal.default_int_handler(number, frame)
