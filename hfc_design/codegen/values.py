"""Properties of a law's values: numbers, arrays, tuples and lists of them."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from hfc_design.codegen.nodes import (
    REAL,
    TRUTH,
    TRUTHS,
    WHOLE,
    Array,
    Lazy,
    Node,
    Storage,
    Stored,
    flat,
    kind_of,
    refusal,
)


def type_of(op: str, args: Sequence[Any]) -> str:
    """Return the type of an operation's result."""
    if op in TRUTHS:
        return TRUTH
    if op == "whole":
        return WHOLE
    kinds = {kind_of(x) for x in (args[1:] if op == "?" else args)}
    if op in ("+", "-", "*", "neg", "abs", "min", "max", "?") and REAL not in kinds:
        return TRUTH if op == "?" and kinds == {TRUTH} else WHOLE
    return REAL


def cost(x: Any) -> int:
    """Return the number of operations in an expression, without those of named numbers."""
    if not isinstance(x, Node) or x.op in ("read", "variable", "called") or not x.args:
        return 1
    return 1 + sum(map(cost, x.args))


def mapped(function: Callable[..., Any], tree: Any, *others: Any) -> Any:
    """Apply ``function`` to the leaves of tuples and lists, index by index across several trees."""
    if not isinstance(tree, tuple | list):
        return function(tree, *others)
    parts = [mapped(function, *each) for each in zip(tree, *others, strict=True)]
    return type(tree)(*parts) if hasattr(tree, "_fields") else type(tree)(parts)


def row_of(values: Any, k: Any) -> Any:
    """Return row ``k``; for a lazy array, what its function returns."""
    return values.function(k) if isinstance(values, Lazy) else values[k]


def shape_of(rows: Any) -> tuple[int, ...]:
    """Return the dimensions of rows; () for a number."""
    if isinstance(rows, Array):
        return rows.shape
    return (len(rows), *shape_of(rows[0])) if isinstance(rows, list | tuple | np.ndarray) else ()


def numbers_in(rows: Any) -> Iterator[Any]:
    """Yield all numbers of rows, row after row."""
    if isinstance(rows, list | tuple | np.ndarray | Array):
        for row in rows:
            yield from numbers_in(row)
    else:
        yield rows


def given_of(args: tuple[Any, ...]) -> Iterator[Any]:
    """Yield the arguments that are passed at run time."""
    for x in args:
        if isinstance(x, Array | Node):
            yield x
        elif several(x):
            yield from given_of(x)


def several(x: Any) -> bool:
    """True if an argument is a plain tuple that contains arrays or nodes."""
    return type(x) is tuple and any(isinstance(one, Array | Node) for one in x)


def form_of(x: Any) -> Any:
    """Return what a recorded function depends on: shape of an array, type of a node, or value."""
    if isinstance(x, Array):
        return x.shape
    if isinstance(x, Node):
        return x.type
    return tuple(map(form_of, x)) if several(x) else x


def begin_of(array: Array) -> tuple[Storage, Any]:
    """Return the memory of an array, and the index at which the array begins in it."""
    if isinstance(array, Stored):
        return array.storage, 0
    places: tuple[Any, ...] = ()
    whole: Any = array
    while not isinstance(whole, Stored):
        if not hasattr(whole, "whole"):
            raise refusal("passes an array that is not in memory")
        places, whole = (whole.place, *places), whole.whole
    rest = (0,) * (len(whole.shape) - len(places))
    return whole.storage, flat((*places, *rest), whole.shape)
