"""The state of a design's C code as numbers, and what such numbers have learnt."""

from collections.abc import Sequence
from itertools import accumulate
from math import prod

import numpy as np

from hfc_design.controllers.kind import ControllerRecord, Member, needed
from hfc_design.core.numbers import Json
from hfc_design.files.design import Design

INDICES = "ijk"


def learns(design: Design) -> bool:
    """Whether the C code of a design learns."""
    return bool(_learnt(design))


def values(design: Design) -> Json | None:
    """What the templates read of the numbers that are saved; None where nothing is learnt."""
    learnt, saved = _learnt(design), design.kind.saved
    if saved is None or not learnt:
        return None
    members = [*learnt, *saved.past(design.controller)]
    firsts = list(accumulate((prod(member.shape) for member in members), initial=0))
    told = []
    for k, (first, member) in enumerate(zip(firsts, members, strict=False)):
        last = firsts[k + 1]
        told.append(
            {
                **member._asdict(),
                "place": _place(member),
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
    saved, count = design.kind.saved, len(numbers)
    assert saved is not None  # or there were no values
    if count not in (found["numbers"], found["learnt"]):
        first = f"of which the first {found['learnt']} are learnt"
        told = f"the C code of design {design.name} saves {found['numbers']}, {first}"
        raise ValueError(f"holds {count} numbers, but {told}")
    parts = {}
    for told, member in zip(found["members"], _learnt(design), strict=False):
        first = told["first"]
        part = np.array(numbers[first : first + prod(member.shape)], np.float64)
        parts[member.name] = part.reshape(member.shape)
    record: ControllerRecord = saved.taken(design.controller, parts)
    return record


def _learnt(design: Design) -> list[Member]:
    saved = design.kind.saved
    return saved.learnt(design.controller) if saved else []


def _place(member: Member) -> str:
    """A member as C reads the number at i, j, k."""
    index = "".join(f"[{INDICES[k]}]" for k in range(len(member.shape)))
    return member.name.replace("[]", index) if "[]" in member.name else member.name + index
