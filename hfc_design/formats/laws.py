"""The law of an axis as it is recorded for code, of a record."""

from collections.abc import Callable
from functools import partial
from typing import Any

from hfc_design.codegen.axis import Recorded, filled, numbers_of, recorded
from hfc_design.controllers.controller import AxisLaw
from hfc_design.controllers.kind import ControllerRecord, kinds, needed
from hfc_design.core.numbers import SCALARS, Floats, Memory
from hfc_design.files.design import Design

#: Of the last records that were asked for: several parts of an export read the same one.
_KEPT: dict[tuple[Any, ...], Recorded] = {}
MOST = 64
#: By how much of themselves numbers are put aside, to see who reads them.
ASIDE = 1e-3


def recorded_law(
    record: ControllerRecord, change: float | None = None, law: AxisLaw | None = None
) -> Recorded:
    """What the law of an axis does at a sample, with a largest ``change`` of its command.

    ``law`` is another one for the same numbers.

    Raises:
        TraceError: it does what no code can be made of.
        UserError: it reads whatever there is, so that code has no inputs.
    """
    kind = kinds().get(record.kind)
    assert kind.law is not None  # see code.sources
    make = partial(recorded, gains=kind.gains(record), reads=_reads(record), change=change)
    if law is not None:
        return make(law)
    return _kept(
        (record.model_dump_json(), change),
        lambda: make(kind.law(record, None), learnt=learnt(record)),
    )


def flat_law(design: Design) -> Recorded:
    """The same of a design for languages without functions; its limits are in it.

    Raises:
        UserError: the kind is none of an axis; or as ``recorded_law``.
    """
    law: Any = needed(design.kind.law, design, "it commands a whole machine; --to c has its code")
    record = design.controller
    change = design.changes([design.axis])[design.axis]
    limit = design.limits.command
    gains = design.kind.gains(record)
    make = partial(recorded, reads=_reads(record), learnt=learnt(record), change=change, flat=True)
    key = record.model_dump_json(), change, limit
    return _kept(key, lambda: make(law(record, limit), gains))


def _reads(record: ControllerRecord) -> list[str]:
    found = kinds().get(record.kind).reads
    assert found is not None  # see code.signals
    return found(record)


def _kept(key: tuple[Any, ...], make: Callable[[], Recorded]) -> Recorded:
    if key not in _KEPT:
        while len(_KEPT) >= MOST:
            del _KEPT[next(iter(_KEPT))]
        _KEPT[key] = make()
    return _KEPT[key]


def learnt(record: ControllerRecord) -> list[str]:
    """Names of what the law of a record learns: with other numbers there it is another record."""
    kind, memory = kinds().get(record.kind), _begun(record)
    if kind.adapted is None or (same := kind.adapted(record, memory)) is None:
        return []
    found = []
    for name, numbers in numbers_of(memory).items():
        other = filled(memory, {name: [x + ASIDE * max(abs(x), 1.0) for x in numbers]})
        if kind.adapted(record, other) != same:
            found.append(name)
    return found


def taken(record: ControllerRecord, numbers: dict[str, Floats]) -> ControllerRecord:
    """A record with what the code of its law has learnt, by the names of its state's members."""
    memory = filled(_begun(record), {name: x.tolist() for name, x in numbers.items()})
    adapted = kinds().get(record.kind).adapted
    assert adapted is not None  # or it had learnt nothing
    found: ControllerRecord = adapted(record, memory)
    return found


def _begun(record: ControllerRecord) -> Memory:
    kind = kinds().get(record.kind)
    assert kind.law is not None  # whoever asks has looked
    return kind.law(record, None).begun(SCALARS, 0.0, kind.gains(record))
