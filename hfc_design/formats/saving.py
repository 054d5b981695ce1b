"""The state of a design's C code as numbers, and what such numbers have learnt."""

from collections.abc import Sequence
from itertools import accumulate
from math import prod

import numpy as np

from hfc_design.controllers.kind import ControllerRecord, Member, kinds, needed
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Floats, Json
from hfc_design.files.design import Design
from hfc_design.files.pairing import axes_of

INDICES = "ijkl"
#: Member of a state with that of a controller of the whole machine inside another one.
WHOLE = "inner"
#: Member of a state with the commands of the sample before, where their rate is limited.
PREVIOUS = "previous_command"


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
    # Of one axis the state of its law is a part of the state where there is another one.
    head = "law." if _rate(design) and not design.kind.inside else ""
    members = [*learnt, *past]
    firsts = list(accumulate((prod(member.shape) for member in members), initial=0))
    told = []
    for k, (first, member) in enumerate(zip(firsts, members, strict=False)):
        last = firsts[k + 1]
        told.append(
            {
                **member._asdict(),
                "place": ("" if member.name == PREVIOUS else head) + _place(member),
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
            first, shape = told["first"], told["shape"]
            parts[told["name"]] = np.array(numbers[first : first + prod(shape)]).reshape(shape)
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
    if kind.saved is None:
        return None
    count = sum(prod(one.shape) for one in (*kind.saved.learnt(record), *kind.saved.past(record)))
    inside = kind.inside.records(record, axes).values() if kind.inside else ()
    sizes = [_size(own, axes, real) for own in inside]
    whole = sum(sizes_known) if len(sizes_known := [x for x in sizes if x]) == len(sizes) else None
    if whole is None or not count:
        return 1 if whole == 0 else whole
    return -(-whole // real) * real + count * real


def _axes(design: Design) -> tuple[str, ...]:
    """Those of a controller with others inside; only there they have names."""
    return axes_of(design) if design.kind.inside else ()


def _members(
    record: ControllerRecord, axes: tuple[str, ...]
) -> tuple[list[Member], list[Member]] | None:
    """What the state of a controller has learnt, and its past; None where that is not known."""
    kind = kinds().get(record.kind)
    if kind.saved is None:
        return None
    learnt, past = kind.saved.learnt(record), kind.saved.past(record)
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
    assert kind.saved is not None  # or nothing were known of its state
    if kind.inside is not None:
        inside = {}
        for axis, own in kind.inside.records(record, axes).items():
            head = f"{part(axis)}."
            mine = {key.removeprefix(head): x for key, x in found.items() if key.startswith(head)}
            inside[axis] = _taken(own, axes, mine) if mine else own
        record = kind.inside.replaced(record, inside)
    own = {member.name for member in kind.saved.learnt(record)}
    mine = {key: x for key, x in found.items() if key in own}
    return kind.saved.taken(record, mine) if mine else record


def part(axis: str) -> str:
    """The member of a state with what is inside of an axis; "": of the whole machine."""
    return identifier(axis) if axis else WHOLE


def _place(member: Member) -> str:
    """A member as C reads the number at i, j, k."""
    index = "".join(f"[{INDICES[k]}]" for k in range(len(member.shape)))
    return member.name.replace("[]", index) if "[]" in member.name else member.name + index
