"""What a law remembers: its numbers under names, before a sample, behind one, and in files."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from math import prod
from typing import Any, NamedTuple

import numpy as np

from hfc_design.codegen.nodes import Array, Each, Lazy, Node, Put, Storage, Stored
from hfc_design.codegen.trace import Trace
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Memory

#: A memory that is one number, or one array.
ALL = "memory"


class Field(NamedTuple):
    """What a controller remembers under one name."""

    name: str
    shape: tuple[int, ...]  # () of a number
    start: list[float]  # before the first sample
    holds: Node | Storage

    @property
    def size(self) -> int:
        """How many numbers it is."""
        return len(self.start)


class Axes(dict[str, Any]):
    """Memories of the axes of a machine by their names, where its controller has a tuple."""


def by_axis(memory: Memory, axes: tuple[str, ...]) -> Memory:
    """A memory with names for the axes of a machine."""
    if hasattr(memory, "_fields"):
        return type(memory)(*(by_axis(one, axes) for one in memory))
    if isinstance(memory, tuple) and len(memory) == len(axes) and not numeric(memory):
        return Axes(zip(axes, memory, strict=True))
    return memory


def like(before: Memory, after: Memory) -> Memory:
    """A memory as the controller gives it, with names for the axes where those ``before`` have."""
    if isinstance(before, Axes):
        pairs = zip(before.items(), after, strict=True)
        return Axes({key: like(one, its) for (key, one), its in pairs})
    if not hasattr(before, "_fields"):
        return after
    return type(after)(*map(like, before, after))


def in_order(memory: Memory) -> Memory:
    """A memory without them."""
    if hasattr(memory, "_fields"):
        return type(memory)(*map(in_order, memory))
    return tuple(memory.values()) if isinstance(memory, Axes) else memory


def parts(memory: Memory, name: str) -> dict[str, Memory] | None:
    """What a memory is made of, by the names that these have in code; None: it is one thing."""
    if hasattr(memory, "_fields"):
        memory = memory._asdict()
    if not isinstance(memory, Mapping):
        return None
    head = f"{name}_" if name else ""
    return {head + identifier(key): one for key, one in memory.items()}


def again(memory: Memory, values: Iterable[Memory]) -> Memory:
    """A memory that is made of other parts."""
    if hasattr(memory, "_fields"):
        return type(memory)(*values)
    return type(memory)(zip(memory, values, strict=True))


def numeric(rows: Any) -> bool:
    """Whether rows of equal lengths hold nothing but numbers."""
    if not isinstance(rows, list | tuple) or hasattr(rows, "_fields"):
        return isinstance(rows, float | int) and not isinstance(rows, bool)
    lengths = {len(row) if isinstance(row, list | tuple) else -1 for row in rows}
    return len(lengths) == 1 and all(map(numeric, rows))


def numbers_of(memory: Memory, name: str = "") -> dict[str, list[float]]:
    """The numbers of a memory by the names that the code has for them."""
    found: dict[str, list[float]] = {}
    if (inside := parts(memory, name)) is not None:
        for key, one in inside.items():
            found |= numbers_of(one, key)
    elif numeric(memory) and np.size(memory):
        found[name or ALL] = np.ravel(memory).tolist()
    return found


def filled(memory: Memory, numbers: dict[str, list[float]], name: str = "") -> Memory:
    """A memory with these numbers in the places of those that the code calls so."""
    if (inside := parts(memory, name)) is not None:
        return again(memory, (filled(one, numbers, key) for key, one in inside.items()))
    if (name or ALL) not in numbers:
        return memory
    return np.reshape(numbers[name or ALL], np.shape(memory)).tolist()


def remembered(
    trace: Trace, value: Memory, fields: list[Field], fixed: set[str], name: str = ""
) -> Memory:
    """A memory whose numbers are those that the state of the code has, but ``fixed`` ones."""
    if (inside := parts(value, name)) is not None:
        made = (remembered(trace, one, fields, fixed, key) for key, one in inside.items())
        return again(value, made)
    name = name or ALL
    if isinstance(value, list | tuple) and value and numeric(value):
        array = np.array(value, dtype=float)
        storage = Storage("state", name, array.shape)
        fields.append(Field(name, array.shape, array.ravel().tolist(), storage))
        return Stored(trace, storage)
    if isinstance(value, bool) or not isinstance(value, float | int) or name in fixed:
        return value
    leaf = trace.leaf("state", name)
    fields.append(Field(name, (), [float(value)], leaf))
    return leaf


def merged(choose: Callable[[Any, Any], Memory], memory: Memory, first: Memory) -> Memory:
    """What is remembered, or what a first sample begins with, as ``choose`` has it of each part."""
    if memory is first:
        return memory
    inside, other = parts(memory, ""), parts(first, "")
    if inside is not None and other is not None:
        pairs = zip(inside.values(), other.values(), strict=True)
        return again(memory, (merged(choose, *pair) for pair in pairs))
    return choose(memory, first)


def since(trace: Trace, started: Node, memory: Memory, first: Memory) -> Memory:
    """What is remembered where there was a sample, or what a first one begins with."""

    def chosen(memory: Any, first: Any) -> Memory:
        if isinstance(memory, Node):
            return trace.made("?", started, memory, first)
        if isinstance(memory, Stored) and isinstance(first, list | tuple):
            return [*map(chosen, memory, first)]
        return started if memory is None and first is False else memory

    return merged(chosen, memory, first)


def leaves(memory: Memory, after: Memory) -> Iterator[tuple[Any, Any]]:
    """Numbers and arrays of a memory, each with what is in its place in another one."""
    if isinstance(memory, Node | Array):
        yield memory, after
    inside, other = parts(memory, ""), parts(after, "")
    if inside is not None and other is not None:
        for one, its in zip(inside.values(), other.values(), strict=True):
            yield from leaves(one, its)


def computed(trace: Trace, after: Memory) -> Iterator[Any]:
    """The numbers of a memory that were computed; arrays of them as a sum."""
    if (inside := parts(after, "")) is not None:
        after = [*inside.values()]
    if isinstance(after, Node):
        if after.op not in ("input", "state"):
            yield after
    elif isinstance(after, Put):
        yield from (value for _, value in after.changes)
    elif isinstance(after, Lazy | Each):
        found = trace.stored(after)
        size = prod(found.shape)
        yield trace.total(Lazy(trace, (size,), lambda k: 0.0 * found.flat(k)))
    elif isinstance(after, list | tuple):
        for one in after:
            yield from computed(trace, one)
