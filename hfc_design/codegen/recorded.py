"""Recording of a controller: its inputs, memory and commands."""

from collections.abc import Callable, Collection, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from hfc_design.codegen.live import LEAVES, counted
from hfc_design.codegen.memory import (
    Field,
    by_axis,
    computed,
    in_order,
    leaves,
    like,
    numeric,
    remembered,
    since,
)
from hfc_design.codegen.nodes import (
    REAL,
    TRUTH,
    Block,
    Node,
    Put,
    Storage,
    Store,
    Stored,
    TraceError,
)
from hfc_design.codegen.sayings import named
from hfc_design.codegen.trace import Trace
from hfc_design.codegen.values import numbers_in
from hfc_design.controllers.controller import (
    AxisLaw,
    Controller,
    PathView,
    View,
    begun,
    limited,
    primed,
)
from hfc_design.controllers.rules import identifier
from hfc_design.core.lanes import LANES
from hfc_design.core.numbers import SCALARS, Gains, Memory, clipped

#: Name of the previous command in memory, which is needed if its rate is limited.
PREVIOUS = "previous_command"
#: Name of the state member that is true after the first sample.
STARTED = "started"
#: Names in code of the path values that a controller of a machine reads.
PATH = ("path_tangent_x", "path_tangent_y", "path_curvature", "path_contour_error")


class Recorded(NamedTuple):
    """Recorded controller; ``after`` runs once the commands are known to be finite."""

    trace: Trace
    after: Block
    fields: list[Field]
    inputs: list[Node]
    limit: Node | None  # largest command of either sign
    commands: list[Any]  # command of each axis
    doubtful: list[Any]  # values that are not finite if a command or the new memory is not
    early: bool  # True if ``doubtful`` can be computed before anything is written to memory
    #: Node that is true after the first sample, and the index of the field before which it is
    #: stored; None if it is not needed.
    started: tuple[Node, int] | None
    numbers: list[Node]  # numbers of the design, with names


#: A source that reads certain nodes: (largest command, (gains, memory) -> memory for the first
#: sample, or None, (gains, memory) -> (commands, new memory)).
Bound: TypeAlias = "tuple[Any, Callable[..., Memory] | None, Callable[..., Any]]"


class Source(NamedTuple):
    """Controller to record."""

    reads: list[str]  # names of its inputs
    gains: Gains
    memory: Memory  # before the first sample
    #: (trace, inputs by name, list to which it adds numbers of the design) -> ``Bound``.
    bound: Callable[[Trace, dict[str, Node], list[Node]], Bound]
    tells: bool = False  # see ``AxisLaw``
    within: bool = False  # True if its commands are already within their limits
    change: float | None = None  # largest change of its command in a sample; None: any
    truths: Collection[str] = ()  # names of the inputs that are true or false


def of_axis(
    law: AxisLaw, gains: Gains, reads: list[str], change: float | None, truths: Collection[str] = ()
) -> Source:
    """Return the source of an axis' law; its limit is a number if flat, else a parameter."""

    def bound(trace: Trace, inputs: dict[str, Node], numbers: list[Node]) -> Bound:
        limit: Any = None
        if not trace.flat:
            limit = trace.leaf("parameter", "largest")
        elif law.limit is not None:
            limit = _number(trace, "largest", law.limit, numbers)
        every: Any = _number(trace, "sample_time", law.sample_time, numbers)
        limited_law = law._replace(limit=limit, sample_time=every)

        def first(gains: Gains, memory: Memory) -> Memory:
            return limited_law.primed(trace.xp, gains, memory, inputs)

        def step(gains: Gains, memory: Memory) -> tuple[list[Any], Memory]:
            try:
                command, after, _ = limited_law.sample(trace.xp, limited_law, gains, memory, inputs)
            except TypeError as error:
                if Node.__name__ not in str(error):
                    raise
                command, after = _through_jax(trace, limited_law, gains, memory, inputs)
            return [command], after

        return limit, first if limited_law.prime else None, step

    memory = law.begun(SCALARS, 0.0, gains)
    return Source(reads, gains, memory, bound, law.tells, change=change, truths=truths)


def _through_jax(
    trace: Trace, law: AxisLaw, gains: Gains, memory: Memory, inputs: dict[str, Node]
) -> tuple[Any, Memory]:
    """Return the command and the new memory of a law that calls JAX."""

    def sample(
        limit: Any, every: Any, gains: Gains, memory: Memory, inputs: Any
    ) -> tuple[Any, Memory]:
        limited_law = law._replace(limit=limit, sample_time=every)
        command, after, _ = law.sample(LANES, limited_law, gains, memory, inputs)
        return command, after

    try:
        given = law.limit, law.sample_time, gains, memory, dict(inputs)
        results: tuple[Any, Memory] = trace.foreign(sample, *given)
    except TraceError as error:
        code = law.sample.__code__
        raise error.at(f"{code.co_filename}:{code.co_firstlineno}") from None
    return results


def of_machine(
    controller: Controller,
    gains: Gains,
    axes: tuple[str, ...],
    reads: list[str],
    path: Sequence[str],
    truths: Collection[str] = (),
) -> Source:
    """Return the source of a machine's controller; names of inputs begin with their axis."""
    names = [identifier(axis) for axis in axes]
    known = [f"{axis}_{name}" for axis in names for name in reads]

    def bound(trace: Trace, inputs: dict[str, Node], numbers: list[Node]) -> Bound:
        xp = trace.xp
        each = tuple({name: inputs[f"{axis}_{name}"] for name in reads} for axis in names)
        way = None
        if path:
            x, y, curvature, *error = (inputs[name] for name in path)
            way = PathView((x, y), curvature, error[0] if error else 0.0)
        view = View(each, way)

        def first(gains: Gains, memory: Memory) -> Memory:
            return like(memory, primed(controller, xp, gains, in_order(memory), view))

        def step(gains: Gains, memory: Memory) -> tuple[list[Any], Memory]:
            commands, after = controller.step(xp, gains, in_order(memory), view)
            return [*commands], like(memory, after)

        return None, first, step

    memory = by_axis(begun(controller, SCALARS, 0.0, gains), axes)
    names_of_truths = [f"{axis}_{name}" for axis in names for name in truths]
    return Source([*known, *path], gains, memory, bound, within=True, truths=names_of_truths)


def used(recording: Recorded) -> list[str]:
    """Return the names of the inputs on which a command or the memory depends."""
    alive, _ = counted(recording.trace, [*recording.commands, *recording.doubtful], recording.after)
    return [node.name for node in recording.inputs if id(node) in alive]


def recorded(source: Source, learnt: Collection[str] = (), flat: bool = False) -> Recorded:
    """Record one sample of a controller.

    Numbers of the memory that never change or are never read are left out, unless their names are
    in ``learnt``. ``flat`` is for languages without functions: called functions are recorded in
    place.

    Raises:
        TraceError: the controller does something that no code can be generated for.
    """
    fixed: set[str] = set()
    in_place = True
    while True:
        recording = _recorded(Trace(in_place=in_place, flat=flat), source, fixed)
        if in_place and not recording.early and recording.trace.rewritten:
            in_place = False
            continue
        fields = (field for field in recording.fields if field.name not in learnt)
        more = {field.name for field in fields if _idle(recording, field)}
        if not more:
            return recording
        fixed |= more


def _idle(recording: Recorded, field: Field) -> bool:
    """True if a number in memory never changes, or is never read."""
    if isinstance(field.holds, Storage):
        return False
    stored = [x for x in recording.after.items if isinstance(x, Store) and x.storage is field.holds]
    if all(not isinstance(x.value, Node) and x.value == field.start[0] for x in stored):
        return True
    alive, _ = counted(recording.trace, [*recording.commands, *recording.doubtful], recording.after)
    return id(field.holds) not in alive


def _recorded(trace: Trace, source: Source, fixed: set[str]) -> Recorded:
    numbers: list[Node] = []
    inputs = {
        name: trace.leaf("input", identifier(name), TRUTH if name in source.truths else REAL)
        for name in source.reads
    }
    gains = _wrapped(trace, source.gains, "", numbers)
    limit, prime, step = source.bound(trace, inputs, numbers)
    fields: list[Field] = []
    memory = remembered(trace, source.memory, fields, fixed)
    started = None
    with named(trace):
        before = memory
        if prime is not None:
            flag = trace.leaf("state", STARTED, TRUTH)
            first = prime(gains, memory)
            before = since(trace, flag, memory, first)
            pairs = [pair for pair in leaves(memory, first) if pair[1] is not pair[0]]
            holds = [x.storage if isinstance(x, Stored) else x for x, _ in pairs]
            places = [k for k, field in enumerate(fields) if any(field.holds is x for x in holds)]
            started = (flag, places[0]) if places else None
        commands, after = step(gains, before)
    doubtful: set[Node] = set()
    for x in [*commands, *([] if source.tells else computed(trace, after))]:
        doubtful |= {x} if source.within else _doubtful(trace, x)
    commands = [limited(trace.xp, limit, command) for command in commands]
    done = trace.block = Block(trace, trace.root)
    if source.change is not None:
        numbers.append(trace.leaf("number", "largest_change", REAL, source.change))
        commands = [_ramped(trace, fields, numbers[-1], commands[0], limit)]
    _commit(trace, memory, after)
    trace.block = trace.root
    unknown = (x for x in doubtful if isinstance(x, Node) and x.op not in FINITE)
    in_order_of_use = sorted((x for x in unknown if x not in trace.sure), key=hash)
    return Recorded(
        trace,
        done,
        fields,
        [*inputs.values()],
        limit,
        commands,
        in_order_of_use,
        all(map(_early, in_order_of_use)),
        started,
        numbers,
    )


def _ramped(trace: Trace, fields: list[Field], change: Node, command: Any, limit: Any) -> Any:
    """Return the command limited in its change from the previous one, which is kept in memory."""
    before = trace.leaf("state", PREVIOUS)
    fields.append(Field(PREVIOUS, (), [0.0], before))
    stepped = clipped(trace.xp, command, before - change, before + change)
    ramped = limited(trace.xp, limit, stepped)
    trace.bound.add(ramped)
    trace.block.items.append(Store(before, None, ramped))
    return ramped


def _doubtful(trace: Trace, x: Any) -> set[Node]:
    """Return nodes of which at least one is not finite if ``x`` is not finite."""
    known: dict[Node, set[Node]] = {}

    def parts_of(x: Any) -> set[Node]:
        if not isinstance(x, Node) or x in trace.sure or x.value is not None or x.op in FINITE:
            return set()
        if x not in known:
            known[x] = set()  # for a variable that depends on itself, in a loop
            known[x] = of_parts(x)
        return known[x]

    def of_parts(x: Node) -> set[Node]:
        parts = [parts_of(part) for part in trace.assigned.get(x, x.args[x.op == "?" :])]
        if x in trace.assigned:  # a node of an inner block cannot be checked: then x itself
            known_here = all(part.block is trace.root for nodes in parts for part in nodes)
            return set().union(*parts) if known_here else {x}
        if x.op in ("?", "min", "max", "neg"):
            return set().union(*parts)
        if x.op in ("+", "-") and not all(parts):
            return set().union(*parts)
        scaled = x.op == "*" and any(isinstance(a, Node) and a.value is not None for a in x.args)
        return set() if scaled and any(a in trace.sure for a in x.args) else {x}

    return parts_of(x)


#: Operations of nodes that are always finite: a sample checks its inputs before it computes.
FINITE = frozenset(("input", "state", "number", "parameter", "index", "whole"))


def _early(x: Any) -> bool:
    """True if a number is computed without loops and arrays that may have been written to."""
    if not isinstance(x, Node) or x.op in LEAVES:
        return not isinstance(x, Node) or x.op not in ("variable", "called")
    if x.op == "read":
        return x.args[0].kind == "table" and _early(x.args[1])
    return all(map(_early, x.args))


def _number(trace: Trace, name: str, value: float, numbers: list[Node]) -> Node:
    leaf = trace.leaf("number", name, REAL, float(value))
    numbers.append(leaf)
    return leaf


def _wrapped(trace: Trace, value: Any, name: str, numbers: list[Node]) -> Any:
    """Return gains with named nodes and tables instead of numbers; add the nodes to ``numbers``."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if hasattr(value, "_fields"):
        parts = zip(value._fields, value, strict=True)
        return type(value)(*(_wrapped(trace, one, key, numbers) for key, one in parts))
    if isinstance(value, float | np.floating) and not isinstance(value, bool):
        return _number(trace, name, float(value), numbers)
    if isinstance(value, list | tuple):
        if value and numeric(value):
            return trace.table(value, name)
        return type(value)(_wrapped(trace, one, name, numbers) for one in value)
    return value


def _commit(trace: Trace, memory: Memory, after: Memory) -> None:
    """Record the writes of the new memory."""
    pairs = [*leaves(memory, after)]
    scalars = [(leaf, trace.plain(value)) for leaf, value in pairs if isinstance(leaf, Node)]
    whole: dict[tuple[int, ...], list[tuple[Storage, Any]]] = {}
    for leaf, value in pairs:
        if isinstance(value, list | tuple):  # read before any of it is written
            trace.bound |= {x for x in numbers_in(value) if isinstance(x, Node)}
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
    """True if ``value`` is in ``storage`` already; numbers that a ``Put`` changes are written."""
    if isinstance(value, Put) and value.base.storage is storage and value.written is None:
        for place, one in value.changes:
            trace.bound |= {x for x in (place, one) if isinstance(x, Node)}
            trace.store(storage, place, one)
        return True
    value = value.written if isinstance(value, Put) else value
    return isinstance(value, Stored) and value.storage is storage
