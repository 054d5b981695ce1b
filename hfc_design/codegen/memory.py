"""Memory of a law: its numbers by name, at the start of a sample, after a sample, and in files."""

from collections.abc import Callable, Iterator, Mapping
from math import prod
from typing import Any, NamedTuple

import numpy as np

from hfc_design.codegen.nodes import Array, Each, Lazy, Node, Put, Storage, Stored
from hfc_design.codegen.trace import Trace
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Memory

#: Name of a memory that is a single number or a single array.
ALL = "memory"


class Field(NamedTuple):
    """Part of a controller's memory under one name."""

    name: str
    shape: tuple[int, ...]  # () for a single number
    start: list[float]  # values before the first sample, row after row
    holds: Node | Storage  # its place in the recording

    @property
    def size(self) -> int:
        """Number of values."""
        return len(self.start)


class Axes(dict[str, Any]):
    """Memories of the axes of a machine by name; they replace a tuple in the axes' order."""


def by_axis(memory: Memory, axes: tuple[str, ...]) -> Memory:
    """Return a memory in which each tuple of one element per axis becomes ``Axes``."""
    if hasattr(memory, "_fields"):
        return type(memory)(*(by_axis(one, axes) for one in memory))
    if isinstance(memory, tuple) and len(memory) == len(axes) and not numeric(memory):
        return Axes(zip(axes, memory, strict=True))
    return memory


def like(before: Memory, after: Memory) -> Memory:
    """Return the memory ``after``, with ``Axes`` instead of tuples where ``before`` has them."""
    if isinstance(before, Axes):
        pairs = zip(before.items(), after, strict=True)
        return Axes({key: like(one, its) for (key, one), its in pairs})
    if not hasattr(before, "_fields"):
        return after
    return type(after)(*map(like, before, after))


def in_order(memory: Memory) -> Memory:
    """Return a memory in which tuples replace ``Axes`` again, as the controller reads it."""
    if hasattr(memory, "_fields"):
        return type(memory)(*map(in_order, memory))
    return tuple(memory.values()) if isinstance(memory, Axes) else memory


def parts(memory: Memory, name: str) -> dict[str, Memory] | None:
    """Return the parts of a memory by their names in code; None for one number or array."""
    if hasattr(memory, "_fields"):
        memory = memory._asdict()
    if not isinstance(memory, Mapping):
        return None
    head = f"{name}_" if name else ""
    return {head + identifier(key): one for key, one in memory.items()}


def mapped(
    function: Callable[..., Memory], memory: Memory, *others: Memory, name: str = ""
) -> Memory:
    """Return a memory of the results of ``function(name, part, same part of the others, ...)``.

    Records and mappings are divided into parts where all memories have them.
    """
    inside = [parts(one, name) for one in (memory, *others)]
    known = [one for one in inside if one is not None]
    if len(known) < len(inside):
        return function(name or ALL, memory, *others)
    each = zip(known[0], *(one.values() for one in known), strict=True)
    values = (mapped(function, *parts, name=key) for key, *parts in each)
    if hasattr(memory, "_fields"):
        return type(memory)(*values)
    return type(memory)(zip(memory, values, strict=True))


def things(memory: Memory, *others: Memory) -> list[tuple[Any, ...]]:
    """Return (name, part, same part of the others, ...) for each part of a memory."""
    listed: list[tuple[Any, ...]] = []
    mapped(lambda *one: listed.append(one), memory, *others)
    return listed


def numeric(rows: Any) -> bool:
    """True for a number, and for rows of equal lengths that contain only numbers."""
    if not isinstance(rows, list | tuple) or hasattr(rows, "_fields"):
        return isinstance(rows, float | int) and not isinstance(rows, bool)
    lengths = {len(row) if isinstance(row, list | tuple) else -1 for row in rows}
    return len(lengths) == 1 and all(map(numeric, rows))


def numbers_of(memory: Memory) -> dict[str, list[float]]:
    """Return the numbers of a memory by their names in code, row after row."""
    each = things(memory)
    return {name: np.ravel(x).tolist() for name, x in each if numeric(x) and np.size(x)}


def filled(memory: Memory, numbers: dict[str, list[float]]) -> Memory:
    """Return a memory with its numbers replaced by those with the same names in code."""

    def new(name: str, x: Any) -> Memory:
        return np.reshape(numbers[name], np.shape(x)).tolist() if name in numbers else x

    return mapped(new, memory)


def remembered(trace: Trace, memory: Memory, fields: list[Field], fixed: set[str]) -> Memory:
    """Return a memory of the code's state, listed in ``fields``; ``fixed`` names stay numbers."""

    def stored(name: str, x: Any) -> Memory:
        if isinstance(x, list | tuple) and x and numeric(x):
            array = np.array(x, dtype=float)
            storage = Storage("state", name, array.shape)
            fields.append(Field(name, array.shape, array.ravel().tolist(), storage))
            return Stored(trace, storage)
        if isinstance(x, bool) or not isinstance(x, float | int) or name in fixed:
            return x
        leaf = trace.leaf("state", name)
        fields.append(Field(name, (), [float(x)], leaf))
        return leaf

    return mapped(stored, memory)


def merged(choose: Callable[[Any, Any], Memory], memory: Memory, first: Memory) -> Memory:
    """Return a memory with each part chosen by ``choose`` from ``memory`` and ``first``."""
    return mapped(lambda _, one, its: one if one is its else choose(one, its), memory, first)


def since(trace: Trace, started: Node, memory: Memory, first: Memory) -> Memory:
    """Return ``memory`` if ``started`` is true, else ``first``, the memory of a first sample."""

    def chosen(memory: Any, first: Any) -> Memory:
        if isinstance(memory, Node):
            return trace.made("?", started, memory, first)
        if isinstance(memory, Stored) and isinstance(first, list | tuple):
            return [*map(chosen, memory, first)]
        return started if memory is None and first is False else memory

    return merged(chosen, memory, first)


def leaves(memory: Memory, after: Memory) -> list[tuple[Any, Any]]:
    """Return pairs of a node or array of a memory and its counterpart in ``after``."""
    pairs = (pair for _, *pair in things(memory, after))
    return [(leaf, x) for leaf, x in pairs if isinstance(leaf, Node | Array)]


def computed(trace: Trace, after: Memory) -> Iterator[Any]:
    """Yield the computed numbers of a memory; of an array a sum, finite only if all numbers are."""
    if (inside := parts(after, "")) is not None:
        after = [*inside.values()]
    if isinstance(after, Node):
        if after.op not in ("input", "state"):
            yield after
    elif isinstance(after, Put):
        yield from (value for _, value in after.changes)
    elif isinstance(after, Lazy | Each):
        stored = trace.stored(after)
        size = prod(stored.shape)
        yield trace.total(Lazy(trace, (size,), lambda k: 0.0 * stored.flat(k)))
    elif isinstance(after, list | tuple):
        for one in after:
            yield from computed(trace, one)
