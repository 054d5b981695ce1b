"""Where the centres of a sampled table lie: where it is nearest to the original between them.

They move one by one, from evenly spaced ones and from those of the file's terms. Of an original
that says the opposite on the opposite side they move in pairs, so that the table does so too.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Integers
from hfc_design.formats.reading.inference import Variable

#: Deviations count with this power, so that the largest decide.
POWER = 8
#: How often every centre may move.
SWEEPS = 12
#: What differs by less, in shares of the largest output or of a range, is the same.
SAME = 1e-9


class Side(NamedTuple):
    """An input on a grid."""

    values: Floats  # (points,) from the lowest to the highest of its range
    allowed: Integers  # places in ``values`` at which a centre can lie
    centres: int  # how many
    held: int | None  # number of the centre that stays on 0


def fitted(
    grid: Floats, sides: list[Side], inputs: tuple[Variable, Variable]
) -> tuple[Integers, Integers]:
    """Places of the centres on both axes."""
    coarse = grid[np.ix_(sides[0].allowed, sides[1].allowed)]
    scale = float(np.ptp(coarse)) or 1.0
    axes = [side.values[side.allowed] for side in sides]
    odd = _is_odd(coarse / scale, axes)
    starts = [[_even(side, axis) for side, axis in zip(sides, axes, strict=True)]]
    own = [_own(*each) for each in zip(sides, axes, inputs, strict=True)]
    starts += [[own[0], own[1]]] if own[0] and own[1] else []
    found = [_moved(coarse / scale, axes, start, sides, odd) for start in starts]
    best = found[-1][1] if _less(found[-1][0], found[0][0]) else found[0][1]
    return sides[0].allowed[best[0]], sides[1].allowed[best[1]]


def _is_odd(grid: Floats, axes: list[Floats]) -> bool:
    """Whether it says the opposite on the opposite side, but for what it says in the middle."""
    twice = grid + grid[::-1, ::-1]
    ends = [np.abs(axis + axis[::-1]).max() <= SAME * np.ptp(axis) for axis in axes]
    return all(ends) and float(np.ptp(twice)) <= SAME


def _even(side: Side, axis: Floats) -> list[int]:
    """Evenly spaced, on either side of 0 where one stays there."""
    if side.held is None:
        wanted = np.linspace(axis[0], axis[-1], side.centres)
    else:
        half = side.centres // 2 + 1
        below, above = np.linspace(axis[0], 0.0, half), np.linspace(0.0, axis[-1], half)
        wanted = np.concatenate([below, above[1:]])
    return _different([int(np.abs(axis - value).argmin()) for value in wanted], len(axis))


def _own(side: Side, axis: Floats, variable: Variable) -> list[int]:
    """Where the file's terms are highest; none if these are not as many, or miss 0."""
    found = sorted({core(term.degree(axis)) for term in variable.terms})
    if len(found) != side.centres or (side.held is not None and axis[found[side.held]] != 0.0):
        return []
    return found


def core(degree: Floats) -> int:
    """Where a term is highest; of a flat top the middle, or its end where it begins at the edge."""
    highest = np.flatnonzero(degree >= (1.0 - SAME) * degree.max())
    first, last = int(highest[0]), int(highest[-1])
    if first == 0 or last == len(degree) - 1:
        return last if first == 0 else first
    return (first + last) // 2


def _different(places: list[int], count: int) -> list[int]:
    """The places, rising, each at least one behind the one before."""
    for k in range(1, len(places)):
        places[k] = max(places[k], places[k - 1] + 1)
    for k in range(len(places) - 1, -1, -1):
        places[k] = min(places[k], count - len(places) + k)
    return places


def _moved(
    grid: Floats, axes: list[Floats], places: list[list[int]], sides: list[Side], odd: bool
) -> tuple[float, list[list[int]]]:
    """The deviation, and the places after each has moved to where it is least."""
    counts = [len(axis) for axis in axes]
    places = [
        _paired(own, count) if odd else [*own] for own, count in zip(places, counts, strict=True)
    ]
    within = [straight(axis, axis[own]) for axis, own in zip(axes, places, strict=True)]
    least = _deviation(grid, within, places)
    for _ in range(SWEEPS):
        before = least
        for side in (0, 1):
            moving = range(len(places[side]) // 2 if odd else len(places[side]))
            for k in moving:
                if k == sides[side].held:
                    continue
                for tried in _tries(places[side], k, counts[side], odd):
                    trial = [*within]
                    trial[side] = straight(axes[side], axes[side][tried])
                    both = [*places]
                    both[side] = tried
                    if _less(found := _deviation(grid, trial, both), least):
                        least, within, places = found, trial, both
        if least >= before:
            break
    return least, places


def _tries(own: list[int], k: int, count: int, odd: bool) -> Iterator[list[int]]:
    """The places with the one of number ``k`` anywhere between its neighbours."""
    low = own[k - 1] + 1 if k else 0
    high = own[k + 1] if k + 1 < len(own) else count
    for place in range(low, min(high, count // 2) if odd else high):
        tried = [*own[:k], place, *own[k + 1 :]]
        yield _paired(tried, count) if odd else tried


def _paired(places: list[int], count: int) -> list[int]:
    """The places with those of the upper half opposite to those of the lower one."""
    half = len(places) // 2
    return [*places[: len(places) - half], *(count - 1 - place for place in places[:half][::-1])]


def _less(one: float, other: float) -> bool:
    """Whether a deviation is less than another, by more than rounding."""
    return one < (1.0 - SAME) * other and other > SAME**POWER


def _deviation(grid: Floats, within: list[Floats], places: list[list[int]]) -> float:
    table = grid[np.ix_(*places)]
    off = within[0] @ table @ within[1].T - grid
    return float(np.mean((off * off) ** (POWER // 2)))


def straight(values: Floats, centres: Floats) -> Floats:
    """(values, centres) degrees in triangles from centre to centre, the outermost flat."""
    return np.stack([np.interp(values, centres, unit) for unit in np.eye(len(centres))], axis=1)
