"""What a log does not tell stays where it began, and what it tells then.

Of parameters that only matter together, as a gain and everything that it drives, one is held: the
others are told if that one is right. What is known badly stays where it began, all of it.
"""

from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Mask
from hfc_design.identify.certainty import Certainty, both, certainty
from hfc_design.identify.search import Found, held, opened

#: A combination that may change by this much, relative, is one that no log of this kind tells.
TOGETHER = 1.0
#: Of parameters that a combination changes nearly as much as the first one, the last is held.
NEARLY = 0.8
#: What is not told stays where it began, unless the residual then is this much larger.
SAME_FIT = 1.1


class Kept(NamedTuple):
    """The fit, and of each parameter how far it is told."""

    found: Found
    known: Certainty
    state: tuple[str, ...]  # "yes"; "given", if those held are right; "held"; "no"
    note: str  # for the user; "" where the log tells everything


def kept(found: Found, known: Certainty, delayed: bool) -> Kept:
    """The fit with what the log does not tell where it began."""
    if all(known.told):
        return Kept(found, known, ("yes",) * len(known.told), "")
    free = _one_of_each(found, known)
    sure = certainty(found.fit, free)
    for _ in known.told:
        again = held(found, (free & np.array(sure.told)).tolist(), delayed)
        there = both(sure, certainty(opened(again, delayed), free))
        sure, before = there, sure
        if sure.told == before.told:
            break
    if not (again.fit.rms <= SAME_FIT * found.fit.rms).all():
        states = tuple("yes" if told else "no" for told in known.told)
        return Kept(found, known, states, _note(found, states, ", but does not fit"))
    states = tuple(map(_state, known.told, sure.told, free.tolist()))
    ends = {
        name: np.where(np.array(sure.told) | free, getattr(sure, name), getattr(known, name))
        for name in ("low", "high", "error")
    }
    value = again.fit.free.values(again.fit.numbers)
    whole = known._replace(value=value, told=tuple(x in ("yes", "given") for x in states), **ends)
    return Kept(again, whole, states, _note(found, states, ""))


def _state(told: bool, then: bool, free: bool) -> str:
    if not free:
        return "held"
    if not then:
        return "no"
    return "yes" if told else "given"


def _one_of_each(found: Found, known: Certainty) -> Mask:
    """(names,) what is not held: one parameter is of each combination that nothing tells."""
    names, free, now = found.fit.free.names, np.ones(len(known.told), bool), known
    while now.untold and now.untold[0].change > TOGETHER:
        shares = now.untold[0].shares
        most = max(map(abs, shares.values()))
        near = [name for name in names if abs(shares.get(name, 0.0)) >= NEARLY * most]
        free[names.index(near[-1])] = False
        now = certainty(found.fit, free)
    return free


def _note(found: Found, states: tuple[str, ...], but: str) -> str:
    names = found.fit.free.names
    one, other = (
        ", ".join(name for name, x in zip(names, states, strict=True) if x == state)
        for state in ("held", "no")
    )
    parts = []
    if one:
        parts.append(
            f"only ratios to {one} are told, held where it began: 'given' means if that is right"
        )
    if other:
        parts.append(f"the log does not tell {other}: left where it began{but}")
    return "; ".join(parts)
