"""State of a design's C code as numbers, and recovery of learned values from such numbers."""

from collections.abc import Sequence
from contextlib import suppress
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from hfc_design.codegen.recorded import STARTED
from hfc_design.controllers.kind import ControllerRecord, require
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.formats import laws
from hfc_design.formats.connection import connect


class Member(NamedTuple):
    """Member of the state in C code: one number or an array."""

    name: str
    size: int  # length of an array; 0: one number
    what: str  # shape or meaning, for the comment in the header
    whole: bool  # whether it is a truth value, 0 or 1
    learnt: bool  # whether the controller learns it
    first: int = 0  # index of its first value among the saved numbers

    @property
    def length(self) -> int:
        """Number of values."""
        return self.size or 1

    @property
    def at(self) -> str:
        """Indices of the member among the saved numbers, as text."""
        last = f" to {self.first + self.length - 1}" if self.length > 1 else ""
        return f"{self.first}{last}"


class Saved(NamedTuple):
    """Saved members of a state, the learned ones first."""

    members: list[Member]
    learnt: int  # count of learned numbers
    numbers: int  # count of all numbers


def saved(design: Design) -> Saved:
    """Return what ``NAME_save`` of a design's code writes."""
    law, learnt = laws.recorded_law(design), laws.learnt(design)
    members: list[Member] = []
    for k, field in enumerate(law.fields):
        if law.started and law.started[1] == k:
            what = "whether there was a sample before"
            members.append(Member(STARTED, 0, what, whole=True, learnt=False))
        what = " x ".join(map(str, field.shape)) if len(field.shape) > 1 else ""
        size = field.size if field.shape else 0
        members.append(Member(field.name, size, what, whole=False, learnt=field.name in learnt))
    members.sort(key=lambda member: not member.learnt)
    firsts = [*accumulate((member.length for member in members), initial=0)]
    placed = [member._replace(first=first) for member, first in zip(members, firsts, strict=False)]
    return Saved(placed, firsts[sum(member.learnt for member in members)], firsts[-1])


def learns(design: Design) -> bool:
    """True if the code of a design learns."""
    if design.kind.axis_records:
        return any(map(learns, design.by_axis().values()))
    return design.kind.reads is not None and bool(laws.learnt(design))


def learning(design: Design) -> Saved | None:
    """Return the saved state of a design that learns; None if it learns nothing."""
    numbers = saved(design)
    return numbers if numbers.learnt else None


def taken(design: Design, numbers: Sequence[float]) -> ControllerRecord:
    """Return the controller of a design with the learned values in ``numbers`` of ``NAME_save``.

    The first ``NAME_LEARNT`` numbers are enough.

    Raises:
        UserError: the C code learns nothing.
        ValueError: the C code saves another number of values.
    """
    nothing = "its C code has no learned state"
    numbers_saved: Saved = require(learning(design), design, nothing)
    count, counts = len(numbers), [numbers_saved.numbers]
    with suppress(UserError):  # only bare code exists
        counts.insert(0, saved(connect(design)).numbers)
    if count not in (*counts, numbers_saved.learnt):
        known = " or, bare, ".join(map(str, dict.fromkeys(counts)))
        first = f"of which the first {numbers_saved.learnt} are learned"
        message = f"the C code of design {design.name} saves {known}, {first}"
        raise ValueError(f"has {count} numbers, but {message}")
    members = (member for member in numbers_saved.members if member.learnt)
    return laws.taken(
        design, {x.name: np.array(numbers[x.first : x.first + x.length]) for x in members}
    )


def size(design: Design) -> tuple[int, int]:
    """Return the usual size of a C state in bytes, with numbers in double and in float."""
    count = saved(design).numbers
    return (8 * count, 4 * count) if count else (1, 1)
