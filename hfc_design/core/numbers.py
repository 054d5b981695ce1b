"""Types of numbers, tables and arrays, and the functions that laws are written with.

A law takes the functions as ``xp``: ``SCALARS`` in the runtime, ``ARRAYS`` over arrays of NumPy,
``core.lanes`` in the simulator, ``codegen.trace`` for code in other languages. A law has no
branches on values, so that the same text serves all four. Never imports JAX.
"""

import math
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial, reduce
from operator import add, getitem, mul
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

#: A number of one machine: a float in the runtime, an array over individuals with NumPy, a value
#: being traced in the simulator. No Python type expresses what they have in common.
Scalar: TypeAlias = Any
#: A truth value computed from ``Scalar``s, of the same three kinds.
Truth: TypeAlias = Any
#: (..., steps) numbers, one for each control sample: an array of NumPy or JAX, or being traced.
Series: TypeAlias = Any
#: Objects that only a kind of controller can read: its record, its numbers, its memory.
Own: TypeAlias = Any
Gains: TypeAlias = Any
Memory: TypeAlias = Any
#: Objects that only a drive can read: its parameters (or values made of them), its state.
Parameters: TypeAlias = Any
State: TypeAlias = Any
#: A value of TOML or JSON, and a table of such values; only their reader knows the right types.
Plain: TypeAlias = Any
Json: TypeAlias = dict[str, Plain]

Degrees: TypeAlias = Sequence[Scalar]  # (7,) to which a value belongs to the terms of an input
Triangles: TypeAlias = Sequence[Sequence[Scalar]]  # (7, 3) left, centre, right
RuleTable: TypeAlias = Sequence[Sequence[Scalar]]  # (7, 7) singletons [row][column]

Floats: TypeAlias = NDArray[np.float64]
Integers: TypeAlias = NDArray[np.int64]
Mask: TypeAlias = NDArray[np.bool_]
Indices: TypeAlias = NDArray[np.intp]  # of elements, counted from 0

#: Numbers with a smaller relative difference count as equal, so that rounding decides nothing.
#: ``SAME_SINGLE`` is for numbers that have been in float32.
SAME, SAME_SINGLE = 1e-9, 1e-6
#: The largest number that is read from a text; its square and cube still do not overflow.
LARGEST_NUMBER = 1e100
#: A number as all languages write it; int() and float() also take 1_0, nan, inf and other digits.
NUMBER = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")

#: JAX always gets at least so many devices, whatever JAX_NUM_CPU_DEVICES says. A program for one
#: device skips the partitioner, is fused in other pieces than a program for several, and rounds
#: differently: a search on one core would then not give the same bits as on several.
FEWEST_DEVICES = 2


def cores() -> int:
    """Return the number of processor cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Constant(float):
    """A number of a controller that is part of its code: each value has its own compiled program.

    Any other float of a loop is an input of its compiled program. Use a constant where it saves
    time in a hot loop, or where Python needs the value, for a branch or ``math``.
    """


def total(values: Iterable[Scalar]) -> Scalar:
    """Return the sum of scalars, left to right, without starting from an integer zero."""
    return reduce(add, values)


def along(function: Callable[..., Any], *rows: Iterable[Any]) -> list[Any]:
    """Return ``function`` of the values at the same place in ``rows``, for each place."""
    return [function(*values) for values in zip(*rows, strict=True)]


def each(function: Callable[..., Any], *tables: Iterable[Iterable[Any]]) -> list[list[Any]]:
    """Return ``function`` of the values at the same place in ``tables``, as a table."""
    return along(partial(along, function), *tables)


def put(rows: Sequence[Any], changes: Iterable[tuple[Any, ...]]) -> list[Any]:
    """Return rows of numbers, or of rows, with the changes ``(index, ..., new value)``."""
    updated = [list(row) if isinstance(row, Sequence) else row for row in rows]
    for *places, last, value in changes:
        reduce(getitem, places, updated)[last] = value
    return updated


def between(
    tables: Sequence[Any],
    low: int,
    high: int,
    function: Callable[..., Sequence[Any]],
    but: int | None = None,
) -> list[list[Any]]:
    """Return tables with rows ``low`` <= k < ``high`` replaced by ``function(k, row, ...)``.

    The function gets row k of each table, and returns the new rows. Rows that do not exist and the
    row ``but`` are skipped. If a table is a single row, its rows are numbers.
    """
    updated = [list(table) for table in tables]
    for k in range(max(low, 0), min(high, len(updated[0]))):
        if k != but:
            after = function(k, *(table[k] for table in tables))
            for table, row in zip(updated, after, strict=True):
                table[k] = row
    return updated


class Xp(NamedTuple):
    """Functions that a law needs beside arithmetic.

    Most functions with a default are for laws with large tables. Such laws go through their rows
    with ``along`` and ``total``, which become loops in generated code. If ``sparse`` is true, they
    compute only the terms that are not 0.
    """

    where: Callable[[Truth, Scalar, Scalar], Scalar]
    minimum: Callable[[Scalar, Scalar], Scalar]
    maximum: Callable[[Scalar, Scalar], Scalar]
    #: (rate, distance) -> exp(-rate distance^2)
    bell: Callable[[float, Scalar], Scalar]
    tanh: Callable[[Scalar], Scalar]
    ratio: Callable[[Scalar, Scalar], Scalar]
    #: x -> x; marks a number that many results use, so that a compiler computes it only once.
    once: Callable[[Scalar], Scalar]
    #: (values by index, index) -> the value at that index
    pick: Callable[[Mapping[int, Scalar], Scalar], Scalar]
    sqrt: Callable[[Scalar], Scalar] = math.sqrt
    floor: Callable[[Scalar], Scalar] = lambda x: float(math.floor(x))
    #: (function, arguments) -> function(*arguments), of a function that may be written for JAX
    foreign: Callable[..., Any] = lambda function, *arguments: function(*arguments)
    sparse: bool = False  # whether computed values may be indices and choose what is computed
    along: Callable[..., Sequence[Any]] = along
    each: Callable[..., Sequence[Any]] = each
    total: Callable[[Iterable[Scalar]], Scalar] = total
    #: rows -> the same rows, which a computed value can index
    table: Callable[[Any], Any] = lambda rows: rows
    whole: Callable[[Scalar], Scalar] = lambda x: int(x) if x > 0.0 else 0  # part of x > 0, else 0
    stored: Callable[[Any], Any] = lambda rows: rows  # the same, computed once before they are read
    between: Callable[..., Any] = between
    put: Callable[[Any, Sequence[tuple[Any, ...]]], Any] = put
    #: (condition, function, value) -> function() where the condition is true, else the value
    when: Callable[[Truth, Callable[[], Any], Any], Any] = lambda condition, function, otherwise: (
        function() if condition else otherwise
    )
    sure: Callable[[Scalar], Scalar] = lambda x: x  # marks a number that is finite for all signals
    #: (function, arguments) -> function(*arguments), with xp first; a function in generated code
    call: Callable[..., Any] = lambda function, *arguments: function(*arguments)


SCALARS = Xp(
    where=lambda condition, a, b: a if condition else b,
    minimum=min,
    maximum=max,
    bell=lambda rate, distance: math.exp((-rate * distance) * distance),
    tanh=math.tanh,
    ratio=lambda a, b: a / b,
    once=lambda x: x,
    pick=getitem,
    sparse=True,
)
ARRAYS = Xp(
    where=np.where,
    minimum=np.minimum,
    maximum=np.maximum,
    bell=lambda rate, distance: np.exp((-rate * distance) * distance),
    tanh=np.tanh,
    ratio=np.divide,
    once=lambda x: x,
    pick=getitem,
    sqrt=np.sqrt,
    floor=np.floor,
)


def number_or_none(text: str) -> float | None:
    """Return the number in a text; None: it is not a number, or too large for a float."""
    return float(text) if NUMBER.fullmatch(text.strip()) and math.isfinite(float(text)) else None


def number_of(text: str) -> float:
    """Return the number in a user's text; ValueError: it is none, or beyond ``LARGEST_NUMBER``."""
    if not NUMBER.fullmatch(text.strip()):
        raise ValueError(f"{text[:40]!r} must be a finite number")
    if abs(value := float(text)) > LARGEST_NUMBER:
        raise ValueError(f"{text[:40]!r} must be at most {LARGEST_NUMBER:g} in magnitude")
    return value


def finite(value: Plain) -> bool:
    """Return whether all numbers in ``value`` are finite, also in tables, rows and arrays."""
    if isinstance(value, float):
        return math.isfinite(value)
    if isinstance(value, Mapping):
        return all(map(finite, value.values()))
    array = getattr(value, "dtype", None) is not None  # of NumPy or of JAX
    if isinstance(value, Iterable) and not (array or isinstance(value, str)):
        return all(map(finite, value))
    try:
        return bool(np.isfinite(value).all())
    except TypeError:
        return True


def storable(value: Any) -> Any:
    """Return ``value`` with None for numbers that are not finite, also in tables and lists."""
    if isinstance(value, Mapping):
        return {key: storable(one) for key, one in value.items()}
    if isinstance(value, tuple | list):
        return [storable(one) for one in value]
    if not isinstance(value, float):
        return value
    return float(value) if math.isfinite(value) else None


def passed(moments: Floats, now: Floats) -> Indices:
    """Return the count of rising ``moments`` (n,) reached at each time ``now``, within rounding."""
    return np.searchsorted(moments, now + SAME * np.abs(now), side="right")


def first_at(time: Floats, moment: float) -> int:
    """Return the index of the first of rising times (n,) at or after a moment, but for rounding."""
    return int(np.searchsorted(time, moment - SAME * abs(moment)))


def within(low: float, value: float, high: float) -> bool:
    """Return whether ``low <= value <= high``, all >= 0, but for single-precision rounding."""
    return low * (1.0 - SAME_SINGLE) <= value <= high * (1.0 + SAME_SINGLE)


def floored(value: float) -> int:
    """Return the whole part of a number >= 0, corrected for rounding: 29 of 0.29 * 100."""
    return int(value * (1.0 + SAME))


def digits(values: Iterable[float]) -> Floats:
    """Return values with nine digits, so that values that differ only by rounding are equal."""
    return np.array([float(f"{value:.9g}") for value in values])


def rms(values: Floats) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def clipped(xp: Xp, value: Scalar, low: Scalar, high: Scalar) -> Scalar:
    """``value`` between two bounds."""
    return xp.minimum(xp.maximum(value, low), high)


def dot(a: Iterable[Scalar], b: Iterable[Scalar]) -> Scalar:
    """Return the sum of the products, left to right."""
    return reduce(add, map(mul, a, b))
