"""The functions that control laws are written with, for one machine in scalars.

A law takes them as ``xp``: ``SCALARS`` in the runtime, ``ARRAYS`` over arrays of NumPy,
``closed_loop.LANES`` in the simulator. A law has no branches on values, so that the same text
serves all three. Never imports JAX.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from functools import reduce
from operator import add, getitem, mul
from typing import Any, NamedTuple

import numpy as np

from hfc_design.core.shapes import Scalar, Truth


class Xp(NamedTuple):
    """What a law needs beside arithmetic."""

    where: Callable[[Truth, Scalar, Scalar], Scalar]
    minimum: Callable[[Scalar, Scalar], Scalar]
    maximum: Callable[[Scalar, Scalar], Scalar]
    decay: Callable[[Scalar], Scalar]  # exp(x) of an x that is not positive
    ratio: Callable[[Scalar, Scalar], Scalar]
    #: x; marks what many results share, for a compiler that would else compute it for each.
    once: Callable[[Scalar], Scalar]
    #: (values, index) -> values[index]
    pick: Callable[[Sequence[Scalar], Scalar], Scalar]


SCALARS = Xp(
    where=lambda condition, a, b: a if condition else b,
    minimum=min,
    maximum=max,
    decay=math.exp,
    ratio=lambda a, b: a / b,
    once=lambda x: x,
    pick=getitem,
)
ARRAYS = Xp(np.where, np.minimum, np.maximum, np.exp, np.divide, lambda x: x, getitem)


def clipped(xp: Xp, value: Scalar, low: Scalar, high: Scalar) -> Scalar:
    """``value`` between two bounds."""
    return xp.minimum(xp.maximum(value, low), high)


def total(values: Iterable[Scalar]) -> Scalar:
    """Sum of scalars, left to right, without starting from an integer zero."""
    return reduce(add, values)


def dot(a: Iterable[Scalar], b: Iterable[Scalar]) -> Scalar:
    """Sum of products, left to right."""
    return reduce(add, map(mul, a, b))


def each(function: Callable[..., Any], *tables: Iterable[Iterable[Any]]) -> list[list[Any]]:
    """Rows of ``function`` of what stands at the same place in tables of rows."""
    return [
        [function(*values) for values in zip(*rows, strict=True)]
        for rows in zip(*tables, strict=True)
    ]
