"""The law of an axis as it is recorded: what it reads, remembers and commands."""

from collections.abc import Collection, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from hfc_design.codegen.live import LEAVES, counted
from hfc_design.codegen.nodes import (
    REAL,
    TRUTH,
    Array,
    Block,
    Each,
    Lazy,
    Node,
    Put,
    Storage,
    Store,
    Stored,
)
from hfc_design.codegen.sayings import named
from hfc_design.codegen.trace import Trace
from hfc_design.controllers.controller import AxisLaw, limited
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import SCALARS, Gains, Memory, clipped

#: What is remembered of a command whose rate is limited.
PREVIOUS = "previous_command"
#: A memory that is one number, or one array.
ALL = "memory"
#: What tells whether there was a sample.
STARTED = "started"


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


class Recorded(NamedTuple):
    """A law, and in ``after`` what is done once the command is known to be finite."""

    trace: Trace
    after: Block
    fields: list[Field]
    inputs: list[Node]
    limit: Node | None  # largest command of either sign
    command: Any
    doubtful: list[Any]  # what is not finite where the command is not, or what is remembered
    early: bool  # whether that is known before anything is remembered
    #: Whether there was a sample before, and the number of the field that this is before; None:
    #: it does not matter.
    started: tuple[Node, int] | None
    numbers: list[Node]  # of the design


def recorded(
    law: AxisLaw,
    gains: Gains,
    reads: list[str],
    learnt: Collection[str] = (),
    change: float | None = None,
    flat: bool = False,
) -> Recorded:
    """What a law does with ``gains`` at a sample; its command changes by no more than ``change``.

    ``flat`` is for languages without functions: what it calls stands where it is called, and its
    limit is the law's, where else the code is given one with each sample.

    What it remembers and never changes, or never reads, is no part of the state, but for what is
    ``learnt``, by its names.

    Raises:
        TraceError: it does what no code can be made of.
    """
    fixed: set[str] = set()
    in_place = True
    while True:
        trace = Trace(in_place=in_place, flat=flat)
        found = _recorded(trace, law, gains, reads, change, fixed)
        if in_place and not found.early and found.trace.rewritten:
            in_place = False
            continue
        kept = (field for field in found.fields if field.name not in learnt)
        more = {field.name for field in kept if _idle(found, field)}
        if not more:
            return found
        fixed |= more


def _idle(found: Recorded, field: Field) -> bool:
    """Whether a number that is remembered stays what it is, or is read by nothing."""
    if isinstance(field.holds, Storage):
        return False
    stored = [x for x in found.after.items if isinstance(x, Store) and x.storage is field.holds]
    if all(not isinstance(x.value, Node) and x.value == field.start[0] for x in stored):
        return True
    alive, _ = counted(found.trace, [found.command, *found.doubtful], found.after)
    return id(field.holds) not in alive


def _recorded(
    trace: Trace,
    law: AxisLaw,
    gains: Gains,
    reads: list[str],
    change: float | None,
    fixed: set[str],
) -> Recorded:
    numbers: list[Node] = []
    inputs = {name: trace.leaf("input", identifier(name)) for name in reads}
    limit: Any = None if trace.flat else trace.leaf("parameter", "largest")
    if trace.flat and law.limit is not None:
        limit = _number(trace, "largest", law.limit, numbers)
    own = _wrapped(trace, gains, "", numbers)
    rate: Any = _number(trace, "sample_time", law.sample_time, numbers)
    law = law._replace(limit=limit, sample_time=rate)
    fields: list[Field] = []
    memory = _remembered(trace, law.begun(SCALARS, 0.0, gains), "", fields, fixed)
    started = None
    with named(trace):
        before = memory
        if law.prime is not None:
            flag = trace.leaf("state", STARTED, TRUTH)
            first = law.prime(trace.xp, law, own, memory, inputs)
            before = _merged(trace, flag, memory, first)
            holds = [leaf for leaf, value in _leaves(memory, first) if value is not leaf]
            places = [k for k, field in enumerate(fields) if any(field.holds is x for x in holds)]
            started = (flag, places[0]) if places else None
        command, after, _ = law.sample(trace.xp, law, own, before, inputs)
    doubtful = _doubtful(trace, command)
    for x in [] if law.tells else _checked(trace, after):
        doubtful |= _doubtful(trace, x)
    command = limited(trace.xp, limit, command)
    done = trace.block = Block(trace, trace.root)
    if change is not None:
        numbers.append(trace.leaf("number", "largest_change", REAL, change))
        command = _ramped(trace, fields, numbers[-1], command, limit)
    _commit(trace, memory, after)
    trace.block = trace.root
    in_order = sorted(doubtful, key=hash)
    return Recorded(
        trace,
        done,
        fields,
        [*inputs.values()],
        limit,
        command,
        in_order,
        all(map(_early, in_order)),
        started,
        numbers,
    )


def _ramped(trace: Trace, fields: list[Field], change: Node, command: Any, limit: Any) -> Any:
    """A command on its way from the one before, which is remembered."""
    before = trace.leaf("state", PREVIOUS)
    fields.append(Field(PREVIOUS, (), [0.0], before))
    stepped = clipped(trace.xp, command, before - change, before + change)
    found = limited(trace.xp, limit, stepped)
    trace.bound.add(found)
    trace.block.items.append(Store(before, None, found))
    return found


def filled(memory: Memory, numbers: dict[str, list[float]], name: str = "") -> Memory:
    """A memory with these numbers in the places of those that the code calls so."""
    if hasattr(memory, "_fields"):
        parts = zip(memory._fields, memory, strict=True)
        return type(memory)(*(filled(one, numbers, _joined(name, key)) for key, one in parts))
    if isinstance(memory, Mapping):
        return {
            key: filled(one, numbers, _joined(name, identifier(key))) for key, one in memory.items()
        }
    if (name or ALL) not in numbers:
        return memory
    return np.reshape(numbers[name or ALL], np.shape(memory)).tolist()


def _doubtful(trace: Trace, x: Any) -> set[Node]:
    """The numbers one of which is not finite where ``x`` is not."""
    known: dict[Node, set[Node]] = {}

    def found(x: Any) -> set[Node]:
        if not isinstance(x, Node) or x in trace.sure or x.value is not None or x.op in FINITE:
            return set()
        if x not in known:
            known[x] = of_parts(x)
        return known[x]

    def of_parts(x: Node) -> set[Node]:
        parts = [found(part) for part in trace.assigned.get(x, x.args[x.op == "?" :])]
        if x.op in ("?", "min", "max", "neg") or x in trace.assigned:
            return set().union(*parts)
        if x.op in ("+", "-") and not all(parts):
            return set().union(*parts)
        scaled = x.op == "*" and any(isinstance(a, Node) and a.value is not None for a in x.args)
        return set() if scaled and any(a in trace.sure for a in x.args) else {x}

    return found(x)


#: What is finite, or the sample is faulty before anything is computed.
FINITE = frozenset(("input", "state", "number", "index", "whole"))


def _early(x: Any) -> bool:
    """Whether a number is computed without arrays that may have been written to, or loops."""
    if not isinstance(x, Node) or x.op in LEAVES:
        return not isinstance(x, Node) or x.op not in ("variable", "called")
    if x.op == "read":
        return x.args[0].kind == "table" and _early(x.args[1])
    return all(map(_early, x.args))


def _number(trace: Trace, name: str, value: float, numbers: list[Node]) -> Node:
    found = trace.leaf("number", name, REAL, float(value))
    numbers.append(found)
    return found


def _wrapped(trace: Trace, value: Any, name: str, numbers: list[Node]) -> Any:
    """Numbers of a design under the names that they have in its gains."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if hasattr(value, "_fields"):
        parts = zip(value._fields, value, strict=True)
        return type(value)(*(_wrapped(trace, one, key, numbers) for key, one in parts))
    if isinstance(value, float | np.floating) and not isinstance(value, bool):
        return _number(trace, name, float(value), numbers)
    if isinstance(value, list | tuple):
        if value and _numeric(value):
            return trace.table(value, name)
        return type(value)(_wrapped(trace, one, name, numbers) for one in value)
    return value


def _numeric(rows: Any) -> bool:
    """Whether rows of equal lengths hold nothing but numbers."""
    if not isinstance(rows, list | tuple) or hasattr(rows, "_fields"):
        return isinstance(rows, float | int) and not isinstance(rows, bool)
    lengths = {len(row) if isinstance(row, list | tuple) else -1 for row in rows}
    return len(lengths) == 1 and all(map(_numeric, rows))


def _remembered(
    trace: Trace, value: Memory, name: str, fields: list[Field], fixed: set[str]
) -> Memory:
    """A memory whose numbers are those that the state of the code has."""
    if hasattr(value, "_fields"):
        parts = zip(value._fields, value, strict=True)
        return type(value)(
            *(_remembered(trace, one, _joined(name, key), fields, fixed) for key, one in parts)
        )
    if isinstance(value, Mapping):
        return {
            key: _remembered(trace, one, _joined(name, identifier(key)), fields, fixed)
            for key, one in value.items()
        }
    if isinstance(value, list | tuple) and value and _numeric(value):
        array = np.array(value, dtype=float)
        storage = Storage("state", name or ALL, array.shape)
        fields.append(Field(storage.name, array.shape, array.ravel().tolist(), storage))
        return Stored(trace, storage)
    if (
        isinstance(value, float | int)
        and not isinstance(value, bool)
        and (name or ALL) not in fixed
    ):
        leaf = trace.leaf("state", name or ALL)
        fields.append(Field(leaf.name, (), [float(value)], leaf))
        return leaf
    return value


def numbers_of(memory: Memory, name: str = "") -> dict[str, list[float]]:
    """The numbers of a memory by the names that the code has for them."""
    found: dict[str, list[float]] = {}
    if hasattr(memory, "_fields") or isinstance(memory, Mapping):
        parts = memory.items() if isinstance(memory, Mapping) else memory._asdict().items()
        for key, one in parts:
            found |= numbers_of(one, _joined(name, identifier(key)))
    elif _numeric(memory) and np.size(memory):
        found[name or ALL] = np.ravel(memory).tolist()
    return found


def _joined(name: str, key: str) -> str:
    return f"{name}_{key}" if name else key


def _merged(trace: Trace, started: Node, memory: Memory, first: Memory) -> Memory:
    """What is remembered, or what a first sample begins with."""
    if memory is first:
        return memory
    if hasattr(memory, "_fields"):
        pairs = zip(memory, first, strict=True)
        return type(memory)(*(_merged(trace, started, *pair) for pair in pairs))
    if isinstance(memory, Mapping):
        return {key: _merged(trace, started, x, first[key]) for key, x in memory.items()}
    if isinstance(memory, Node):
        return trace.made("?", started, memory, first)
    return started if memory is None and first is False else memory


def _leaves(memory: Memory, after: Memory) -> Iterator[tuple[Any, Any]]:
    if isinstance(memory, Node | Array):
        yield memory, after
    elif hasattr(memory, "_fields"):
        for one, other in zip(memory, after, strict=True):
            yield from _leaves(one, other)
    elif isinstance(memory, Mapping):
        for key, one in memory.items():
            yield from _leaves(one, after[key])


def _checked(trace: Trace, after: Memory) -> Iterator[Any]:
    """The numbers of a memory that were computed; arrays of them as a sum."""
    if isinstance(after, Node):
        if after.op not in ("input", "state"):
            yield after
    elif isinstance(after, Put):
        yield from (value for _, value in after.changes)
    elif isinstance(after, Lazy | Each):
        yield trace.total(trace.each(lambda x: 0.0 * x, trace.stored(after)))
    elif isinstance(after, Mapping):
        for one in after.values():
            yield from _checked(trace, one)
    elif isinstance(after, list | tuple):
        for one in after:
            yield from _checked(trace, one)


def _commit(trace: Trace, memory: Memory, after: Memory) -> None:
    """Store what is to be remembered."""
    pairs = [*_leaves(memory, after)]
    scalars = [(leaf, trace.plain(value)) for leaf, value in pairs if isinstance(leaf, Node)]
    whole: dict[tuple[int, ...], list[tuple[Storage, Any]]] = {}
    for leaf, value in pairs:
        if isinstance(leaf, Stored) and not _in_place(trace, leaf.storage, value):
            whole.setdefault(leaf.shape, []).append((leaf.storage, value))
    for alike in whole.values():
        trace.replace(alike)
    for leaf, value in scalars:
        if value is not leaf:
            if isinstance(value, Node) and value.op not in ("input", "called", "variable"):
                trace.bound.add(value)
            trace.block.items.append(Store(leaf, None, value))


def _in_place(trace: Trace, storage: Storage, value: Any) -> bool:
    """Whether what is remembered is there already, but for numbers that are put there."""
    if isinstance(value, Put) and value.base.storage is storage and value.written is None:
        for place, one in value.changes:
            trace.bound |= {x for x in (place, one) if isinstance(x, Node)}
            trace.store(storage, place, one)
        return True
    value = value.written if isinstance(value, Put) else value
    return isinstance(value, Stored) and value.storage is storage
