"""Ctrl-C that is not lost.

Python raises it wherever it happens to be. In a callback that some library has the garbage
collector call, JAX's among them, it is printed and ignored there, and a long search would go on.
"""

import signal
from types import FrameType

_told: list[int] = []


def listen() -> None:
    """Note every Ctrl-C from now on; where it is ignored, as after ``nohup``, it stays so."""
    _told.clear()
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _note)


def heard() -> None:
    """Raise KeyboardInterrupt, once, where it has been raised already since ``listen``."""
    if _told:
        _told.clear()
        raise KeyboardInterrupt


def _note(number: int, frame: FrameType | None) -> None:
    _told.append(number)
    signal.default_int_handler(number, frame)
