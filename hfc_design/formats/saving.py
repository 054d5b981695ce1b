"""The state of a design's C code as numbers, and what such numbers have learnt."""

from collections.abc import Sequence
from contextlib import suppress
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from hfc_design.codegen.recorded import STARTED
from hfc_design.controllers.kind import ControllerRecord, needed
from hfc_design.core.numbers import Json
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.formats import laws
from hfc_design.formats.connection import connect


class Member(NamedTuple):
    """Numbers in the state of C code."""

    name: str
    size: int = 0  # of an array; 0: it is none
    what: str = ""  # for people
    whole: bool = False  # whether it is a truth


def learns(design: Design) -> bool:
    """Whether the code of a design learns."""
    if design.kind.axis_records:
        return any(map(learns, design.by_axis().values()))
    return design.kind.reads is not None and bool(laws.learnt(design))


def members(design: Design) -> tuple[list[Member], int]:
    """What is saved, and how many members of that, the first ones, are learnt."""
    found, names = laws.recorded_law(design), laws.learnt(design)
    learnt: list[Member] = []
    past: list[Member] = []
    for k, field in enumerate(found.fields):
        if found.started and found.started[1] == k:
            past.append(Member(STARTED, 0, "whether there was a sample before", whole=True))
        what = " x ".join(map(str, field.shape)) if len(field.shape) > 1 else ""
        member = Member(field.name, field.size if field.shape else 0, what)
        (learnt if field.name in names else past).append(member)
    return [*learnt, *past], len(learnt)


def values(design: Design, learning: bool = True) -> Json | None:
    """What the templates read of the numbers that are saved.

    None where nothing is learnt if that is asked for.
    """
    found, learnt = members(design)
    if learning and not learnt:
        return None
    firsts = list(accumulate((member.size or 1 for member in found), initial=0))
    told = []
    for k, (first, member) in enumerate(zip(firsts, found, strict=False)):
        last = firsts[k + 1]
        at = f"{first}" if last == first + 1 else f"{first} to {last - 1}"
        told.append({**member._asdict(), "first": first, "at": at, "learnt": k < learnt})
    return {"members": told, "learnt": firsts[learnt], "numbers": firsts[-1]}


def taken(design: Design, numbers: Sequence[float]) -> ControllerRecord:
    """The controller of a design with what ``numbers`` of ``NAME_save`` have learnt.

    The first ``NAME_LEARNT`` of them are enough.

    Raises:
        UserError: the C code learns nothing.
        ValueError: it saves another number of them.
    """
    found = needed(values(design), design, "its C code saves nothing that it would have learnt")
    count, known = len(numbers), [_count(design)]
    with suppress(UserError):  # it is bare code alone
        known = [_count(connect(design)), *known]
    if count not in (*known, found["learnt"]):
        saved = " or, bare, ".join(map(str, dict.fromkeys(known)))
        first = f"of which the first {found['learnt']} are learnt"
        told = f"the C code of design {design.name} saves {saved}, {first}"
        raise ValueError(f"holds {count} numbers, but {told}")
    parts = {}
    for told in found["members"]:
        if told["learnt"]:
            first = told["first"]
            parts[told["name"]] = np.array(numbers[first : first + (told["size"] or 1)])
    return laws.taken(design, parts)


def _count(design: Design) -> int:
    """How many numbers a state has."""
    return sum(member.size or 1 for member in members(design)[0])


def size(design: Design) -> tuple[int, int]:
    """Bytes of a state in double and in float, by the usual rules of C."""
    count = _count(design)
    return (8 * count, 4 * count) if count else (1, 1)
