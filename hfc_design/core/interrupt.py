"""Reliable Ctrl-C.

Python raises KeyboardInterrupt at any place in the program. In a callback of the garbage collector,
as JAX has them, it is only printed and then ignored, so that a long search would continue.
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
    """Print an exception that Python cannot raise, except Ctrl-C, which has been noted already."""
    if not isinstance(fault.exc_value, KeyboardInterrupt):
        sys.__unraisablehook__(fault)


def _note(number: int, frame: FrameType | None) -> None:
    _told.append(number)
    signal.default_int_handler(number, frame)
