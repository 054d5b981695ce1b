"""Recording of a design's controller for code generation, for one axis or a whole machine."""

from collections.abc import Iterator
from typing import Any

from hfc_design.codegen.memory import by_axis, filled, in_order, numbers_of
from hfc_design.codegen.recorded import PATH, Recorded, Source, of_axis, of_machine, recorded
from hfc_design.controllers.controller import AxisLaw, begun, within_rate
from hfc_design.controllers.kind import ControllerRecord, require
from hfc_design.core.numbers import SCALARS, Floats, Memory
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import axes_of

#: Recordings of the last requested designs: several parts of an export read the same one.
_KEPT: dict[tuple[Any, ...], Recorded] = {}
MOST = 64
#: Relative change of a number in memory that shows whether the controller's record depends on it.
ASIDE = 1e-3
#: Reason why no code can be generated for a kind.
NO_CODE = "its inputs are not known; export its numbers with json"


def recorded_law(design: Design, law: AxisLaw | None = None, flat: bool = False) -> Recorded:
    """Return the recording of one sample of a design's controller.

    If ``law`` is given, it is recorded in place of the design's own law, with the same numbers. For
    ``flat`` see ``codegen.recorded``; the law of one axis then keeps to the limit of the design.

    Raises:
        TraceError: the controller does something that no code can be generated for.
        UserError: it is not known which signals the controller reads.
    """
    if law is not None:
        return recorded(_source(design, law, flat), flat=flat)
    key = _key_of(design)
    key += (design.limits.command if flat or design.kind.law is None else None, flat)
    if key not in _KEPT:
        while len(_KEPT) >= MOST:
            del _KEPT[next(iter(_KEPT))]
        _KEPT[key] = recorded(_source(design, None, flat), learnt(design), flat)
    return _KEPT[key]


def _key_of(design: Design) -> tuple[Any, ...]:
    limits = None if design.kind.law else design.limits.model_dump_json()
    changes = tuple(design.changes(machine_axes(design) or (design.axis,)).values())
    # ``around`` is a function: it is equal only for the same connected design.
    connection = design.connected and (design.connected.around, *design.connected.units)
    return design.controller.model_dump_json(), limits, changes, machine_axes(design), connection


def machine_axes(design: Design) -> tuple[str, ...]:
    """Return the axes that one controller commands together; () if each axis has its own."""
    return () if design.kind.law or design.kind.axis_records else axes_of(design)


def of_path(design: Design) -> tuple[str, ...]:
    """Return the path values that a machine's controller, or one inside it, reads; possibly none.

    A connected controller does not read the contour error, because it computes it.
    """
    axes = machine_axes(design)
    seen = bool(axes) and any(x.path for x in inside(design.controller, axes))
    return PATH[: 3 if design.connected else 4] if seen else ()


def inside(record: ControllerRecord, axes: tuple[str, ...]) -> Iterator[ControllerRecord]:
    """Yield a controller and all controllers inside it."""
    yield record
    for inner in record.inside(axes).values():
        yield from inside(inner, axes)


def _source(design: Design, law: AxisLaw | None, flat: bool) -> Source:
    kind, record = design.kind, design.controller
    gains, reads = record.law_gains(), require(kind.reads, design, NO_CODE)(record)
    connection = design.connected
    reads = list(connection.units) if connection else reads
    truths = connection.truths if connection and flat else ()
    if not (axes := machine_axes(design)):
        made = law or require(kind.law, design, NO_CODE)(
            record, design.limits.command if flat else None
        )
        if connection:
            return of_axis(connection.around(made), gains, reads, None, truths)
        return of_axis(made, gains, reads, design.changes([design.axis])[design.axis])
    return of_machine(design.commanding(axes), gains, axes, reads, of_path(design), truths)


def learnt(design: Design) -> list[str]:
    """Return the names of numbers in memory that a controller learns: its record contains them."""
    memory = begun_law(design)
    if (same := _adapted(design, memory)) is None:
        return []
    values = []
    for name, numbers in numbers_of(memory).items():
        other = filled(memory, {name: [x + ASIDE * max(abs(x), 1.0) for x in numbers]})
        if _adapted(design, other) != same:
            values.append(name)
    return values


def taken(design: Design, numbers: dict[str, Floats]) -> ControllerRecord:
    """Return the controller's record with learned ``numbers``: member of the state -> values."""
    memory = filled(begun_law(design), {name: x.tolist() for name, x in numbers.items()})
    adapted = _adapted(design, memory)
    assert adapted is not None  # None only if nothing is learned
    return adapted


def _adapted(design: Design, memory: Memory) -> ControllerRecord | None:
    kind, record = design.kind, design.controller
    law_memory = memory.law if design.connected else memory
    if axes := machine_axes(design):
        return kind.learnt(record, axes, within_rate(in_order(law_memory))) if kind.learnt else None
    return kind.adapted(record, law_memory) if kind.adapted else None


def begun_law(design: Design) -> Memory:
    """Return the memory of a design's controller before its first sample."""
    kind, record = design.kind, design.controller
    if axes := machine_axes(design):
        memory = begun(design.commanding(axes), SCALARS, 0.0, record.law_gains())
        return by_axis(memory, axes)
    law = require(kind.law, design, NO_CODE)(record, None)
    law = design.connected.around(law) if design.connected else law
    return law.begun(SCALARS, 0.0, record.law_gains())
