"""The state of a design's C code as numbers, and what such numbers have learnt."""

from collections.abc import Sequence
from itertools import accumulate
from math import prod

import numpy as np

from hfc_design.codegen.axis import PREVIOUS, STARTED
from hfc_design.controllers.kind import ControllerRecord, Member, kinds, needed
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Floats, Json
from hfc_design.files.design import Design
from hfc_design.files.pairing import axes_of
from hfc_design.formats import laws

#: Member of a state with that of a controller of the whole machine inside another one.
WHOLE = "inner"
#: Of a controller that compares a sample with the one before.
WAS = Member(STARTED, what="whether there was a sample before", whole=(0, 1))


def learns(design: Design) -> bool:
    """Whether the C code of a design learns."""
    found = _members(design.controller, _axes(design))
    return bool(found and found[0])


def values(design: Design, learning: bool = True) -> Json | None:
    """What the templates read of the numbers that are saved.

    None where the kind does not tell them, and where nothing is learnt if that is asked for.
    """
    found = _members(design.controller, _axes(design))
    if found is None or (learning and not found[0]):
        return None
    learnt, past = found[0], [*found[1], *_rate(design)]
    members = [*learnt, *past]
    firsts = list(accumulate((prod(member.shape) for member in members), initial=0))
    told = []
    for k, (first, member) in enumerate(zip(firsts, members, strict=False)):
        last = firsts[k + 1]
        told.append(
            {
                **member._asdict(),
                "place": member.name + ("[i]" if member.shape else ""),
                "first": first,
                "at": f"{first}" if last == first + 1 else f"{first} to {last - 1}",
                "learnt": k < len(learnt),
            }
        )
    return {"members": told, "learnt": firsts[len(learnt)], "numbers": firsts[-1]}


def taken(design: Design, numbers: Sequence[float]) -> ControllerRecord:
    """The controller of a design with what ``numbers`` of ``NAME_save`` have learnt.

    The first ``NAME_LEARNT`` of them are enough.

    Raises:
        UserError: the C code learns nothing.
        ValueError: it saves another number of them.
    """
    found = needed(values(design), design, "its C code saves nothing that it would have learnt")
    count = len(numbers)
    if count not in (found["numbers"], found["learnt"]):
        first = f"of which the first {found['learnt']} are learnt"
        told = f"the C code of design {design.name} saves {found['numbers']}, {first}"
        raise ValueError(f"holds {count} numbers, but {told}")
    parts = {}
    for told in found["members"]:
        if told["learnt"]:
            first, count = told["first"], prod(told["shape"])
            parts[told["name"]] = np.array(numbers[first : first + count])
    record: ControllerRecord = _taken(design.controller, _axes(design), parts)
    return record


def size(design: Design) -> tuple[int, int] | None:
    """Bytes of a state in double and in float, by the usual rules of C; None: not known."""
    found = [_size(design.controller, _axes(design), real) for real in (8, 4)]
    if found[0] is None or found[1] is None:
        return None
    more = sum(prod(member.shape) for member in _rate(design))
    if not more:
        return found[0], found[1]
    return (-(-found[0] // 8) + more) * 8, (-(-found[1] // 4) + more) * 4


def _rate(design: Design) -> list[Member]:
    """What is remembered for a limited rate, beside what the controller does."""
    axes = axes_of(design) if design.kind.law is None else (design.axis,)
    if not any(design.changes(axes).values()):
        return []
    shape = () if design.kind.law else (len(axes),)
    return [Member(PREVIOUS, shape, "of the sample before")]


def _size(record: ControllerRecord, axes: tuple[str, ...], real: int) -> int | None:
    """A whole number has 4 bytes, and before a real one as many as that."""
    kind = kinds().get(record.kind)
    if kind.law is not None:
        found = _of_law(record)
        count = None if found is None else sum(prod(one.shape) for one in (*found[0], *found[1]))
        return count * real if count else None if count is None else 1
    if kind.saved is None:
        return None
    count = sum(prod(one.shape) for one in kind.saved(record))
    inside = kind.inside.records(record, axes).values() if kind.inside else ()
    sizes = [_size(own, axes, real) for own in inside]
    whole = sum(sizes_known) if len(sizes_known := [x for x in sizes if x]) == len(sizes) else None
    if whole is None or not count:
        return 1 if whole == 0 else whole
    return -(-whole // real) * real + count * real


def _axes(design: Design) -> tuple[str, ...]:
    """Those of a controller with others inside; only there they have names."""
    return axes_of(design) if design.kind.inside else ()


def _of_law(record: ControllerRecord) -> tuple[list[Member], list[Member]] | None:
    """What the law of an axis has learnt, and its past."""
    kind = kinds().get(record.kind)
    if kind.reads is None:
        return None
    found = laws.recorded_law(record)
    names = laws.learnt(record)
    learnt: list[Member] = []
    past: list[Member] = []
    for k, field in enumerate(found.fields):
        if found.started and found.started[1] == k:
            past.append(WAS)
        what = " x ".join(map(str, field.shape)) if len(field.shape) > 1 else ""
        member = Member(field.name, (field.size,) if field.shape else (), what)
        (learnt if field.name in names else past).append(member)
    return learnt, past


def _members(
    record: ControllerRecord, axes: tuple[str, ...]
) -> tuple[list[Member], list[Member]] | None:
    """What the state of a controller has learnt, and its past; None where that is not known."""
    kind = kinds().get(record.kind)
    if kind.law is not None:
        return _of_law(record)
    if kind.saved is None:
        return None
    learnt: list[Member] = []
    past = list(kind.saved(record))
    for axis, own in (kind.inside.records(record, axes) if kind.inside else {}).items():
        found = _members(own, axes)
        if found is None:
            return None
        for all_of_them, some in zip((learnt, past), found, strict=True):
            all_of_them += [member._replace(name=f"{part(axis)}.{member.name}") for member in some]
    return learnt, past


def _taken(
    record: ControllerRecord, axes: tuple[str, ...], found: dict[str, Floats]
) -> ControllerRecord:
    """A controller with what its members, and those of what is inside, have learnt."""
    kind = kinds().get(record.kind)
    if kind.law is not None:
        return laws.taken(record, found)
    assert kind.inside is not None  # or it had learnt nothing
    inside = {}
    for axis, own in kind.inside.records(record, axes).items():
        head = f"{part(axis)}."
        mine = {key.removeprefix(head): x for key, x in found.items() if key.startswith(head)}
        inside[axis] = _taken(own, axes, mine) if mine else own
    replaced: ControllerRecord = kind.inside.replaced(record, inside)
    return replaced


def part(axis: str) -> str:
    """The member of a state with what is inside of an axis; "": of the whole machine."""
    return identifier(axis) if axis else WHOLE
