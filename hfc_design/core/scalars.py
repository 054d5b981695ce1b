"""The functions that control laws are written with, for one machine in scalars.

A law takes them as ``xp``: ``SCALARS`` in the runtime, ``ARRAYS`` over arrays of NumPy,
``lanes.LANES`` in the simulator. A law has no branches on values, so that the same text serves
all three. Never imports JAX.
"""

import math
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple, Protocol

import numpy as np


class Scalar(Protocol):
    """A number of one machine: a float, an array over individuals, or a value being traced."""

    def __add__(self, other: Any, /) -> Any: ...
    def __mul__(self, other: Any, /) -> Any: ...
    def __lt__(self, other: Any, /) -> Any: ...


class Xp(NamedTuple):
    """What a law needs beside arithmetic."""

    where: Callable[[Any, Any, Any], Any]
    minimum: Callable[[Any, Any], Any]
    maximum: Callable[[Any, Any], Any]
    decay: Callable[[Any], Any]  # exp(x) of an x that is not positive
    ratio: Callable[[Any, Any], Any]
    #: x; marks what many results share, for a compiler that would else compute it for each.
    once: Callable[[Any], Any]


SCALARS = Xp(
    where=lambda condition, a, b: a if condition else b,
    minimum=min,
    maximum=max,
    decay=math.exp,
    ratio=lambda a, b: a / b,
    once=lambda x: x,
)
ARRAYS = Xp(np.where, np.minimum, np.maximum, np.exp, np.divide, lambda x: x)


def clipped(xp: Xp, value: Any, low: Any, high: Any) -> Any:
    """``value`` between two bounds."""
    return xp.minimum(xp.maximum(value, low), high)


def total(values: Iterable[Any]) -> Any:
    """Sum of scalars, left to right, without starting from an integer zero."""
    first, *others = values
    for value in others:
        first = first + value
    return first
