"""Circular tests (ISO 230-4:2005): full turns in a path, their deviations, the causes of these.

``Turns`` are positions (2, samples) about the nominal centre by direction: 1 is counter-clockwise,
or XY after the order in which the axes are passed, -1 is clockwise, or YX.
"""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from hfc_design.core.numbers import Floats, rms

Turns: TypeAlias = Mapping[int, Floats]
NAMES = {1: "XY", -1: "YX"}
#: A path may be off its circle by this share of the radius, a reference by that; a turn may lack
#: this angle, as its last sample need not be its first; within that a path only trembles [rad].
NEAR, EXACT, GAP, BACK = 0.03, 1e-3, 0.07, 0.2
#: Points that try circles; steps of Gauss and Newton, and most linear programs.
POINTS, STEPS, PROGRAMS = 400, 8, 60
#: Sectors of a turn, which count alike; least share of the squares left that a cause must explain;
#: share of its largest deviation at which a spike ends; widths and decays that are tried [deg].
SECTORS, LEAST, TAIL = 1440, 0.05, 0.05
WIDTHS, DECAYS = 0.15 * 1.5 ** np.arange(12), (0.5, 2.0, 8.0)
RADIUS, OFFSET, SCALE, REST = "radius", "centre offset", "scale mismatch", "vibration and rest"
SQUARE, SERVO, EITHER = "squareness", "servo mismatch", "squareness or servo mismatch"
BACKLASH, SPIKES = "backlash of {}", "reversal spikes of {}"


def nominal_circle(
    path: Floats, radius: float | None = None, near: float = NEAR
) -> tuple[Floats, float]:
    """Return centre and radius of the circle, near ``radius``, that most of a path is on."""
    extent = np.ptp(path, axis=1).max() or 1.0
    cells = np.round(path * (POINTS / extent))
    moved = np.flatnonzero((np.diff(cells, prepend=np.nan) != 0).any(axis=0))  # dwells count once
    points = path[:, moved[:: 1 + len(moved) // POINTS]]
    step = max(points.shape[1] // 40, 1)
    first, *others = (points[:, k * step : points.shape[1] - (2 - k) * step] for k in range(3))
    (ax, ay), (bx, by) = (other - first for other in others)
    with np.errstate(all="ignore"):  # lines
        a, b, twice = ax * ax + ay * ay, bx * bx + by * by, 2.0 * (ax * by - ay * bx)
        from_first = np.stack([by * a - ay * b, ax * b - bx * a]) / twice  # to the circumcentres
        size, centres = np.hypot(*from_first), first + from_first
        off = np.abs(np.hypot(*(points[:, :, None] - centres[:, None])) - size)
        fits = (np.abs(size - (radius or size)) <= NEAR * size) & (size < extent)
        best = int(np.where(fits, (off <= NEAR * size).sum(axis=0), -1).argmax())
    if not fits[best]:
        return path.mean(axis=1), 0.0
    centre, found = centres[:, best], float(radius or size[best])
    for share in (NEAR, near):
        if turns := full_turns(path - centre[:, None], found, share)[0].values():
            centre, found = least_squares_circle(np.hstack([path[:, part] for part in turns]))
    return centre, found


def full_turns(path: Floats, radius: float, near: float = NEAR) -> tuple[dict[int, slice], float]:
    """Return the first full turn of a path about the origin in each direction, as its samples.

    Of a longer arc the middle is taken, without run-up and feed-out. The longest arc [rad] follows.
    The path belongs to the circle where its ``radius`` is off by less than the share ``near``.
    """
    from scipy.signal import find_peaks  # takes long to import

    angle = np.unwrap(np.arctan2(path[1], path[0]))
    inside = np.abs(np.hypot(*path) - radius) <= near * radius
    back = [find_peaks(side * angle, prominence=BACK)[0] for side in NAMES]
    cuts = np.unique(np.hstack([0, len(angle), np.flatnonzero(np.diff(inside)) + 1, *back]))
    turns, longest = dict[int, slice](), 0.0
    for begin, end in pairwise(cuts.tolist()):
        change = angle[begin:end] - angle[begin]
        side = 1 if change[-1] > 0 else -1
        swept, arc = side * change, float(abs(change[-1]))
        lead = 0.5 * max(arc - 2.0 * np.pi, 0.0)
        longest = max(longest, arc if inside[begin] else 0.0)
        if inside[begin] and arc >= 2.0 * np.pi - GAP and side not in turns:
            first = begin + np.flatnonzero(swept <= lead)[-1]
            last = begin + np.flatnonzero(swept >= min(lead + 2.0 * np.pi, arc))[0]
            turns[side] = slice(int(first), int(last) + 1)
    return turns, longest


def least_squares_circle(points: Floats) -> tuple[Floats, float]:
    """Return centre (2,) and radius of the circle with the least squares of radial distances."""
    centre, radius = points.mean(axis=1), 0.0
    for _ in range(STEPS):
        away = points - centre[:, None]
        distance = np.hypot(*away)
        columns = np.stack([*(away / distance), np.ones_like(distance)], axis=1)
        *change, radius = np.linalg.lstsq(columns, distance)[0]
        centre = centre + change
    return centre, float(radius)


def minimum_zone(points: Floats) -> float:
    """Return the least radial distance of two concentric circles with all ``points`` between them.

    A sequence of linear programs, each linearised about the centre of the last one, converges
    quadratically. A program has the points only that limited one before.
    """
    from scipy.optimize import linprog  # takes long to import

    centre, least = least_squares_circle(points)[0], np.inf
    chosen = np.arange(0, points.shape[1], 1 + points.shape[1] // 64)
    for _ in range(PROGRAMS):
        away = points - centre[:, None]
        distance = np.hypot(*away)
        width, inner = float(np.ptp(distance)), distance.min()
        least = min(least, width)
        chosen = np.union1d(chosen, [distance.argmax(), distance.argmin()])
        x, y = (away / distance)[:, chosen]
        off, one = (distance[chosen] - inner) / max(width, 1e-300), np.ones(len(chosen))
        # Unknown, in units of the width: shift of the centre, radius of the inner circle, distance.
        rows = np.hstack([np.stack([x, y, one, 0 * one]), -np.stack([x, y, one, one])])
        limits = np.hstack([off, -off])
        program: Any = linprog([0, 0, 0, 1], rows.T, limits, bounds=(None, None))
        if width * (1.0 - program.fun) <= 1e-14 * inner:
            break
        centre = centre + width * program.x[:2]
    return least


def deviations(turns: Turns, radius: float, centred: bool = False) -> dict[str, float]:
    """Return the deviations that ISO 230-4:2005, clause 3, defines, by symbol and direction.

    G is the minimum zone, G(b) that of both directions. F is the distance from the nominal centre,
    or with ``centred`` the least-squares centre, less the nominal ``radius``; D is the radius of
    the least-squares circle of both directions less the nominal radius.
    """
    found = {f"G({NAMES[side]})": minimum_zone(points) for side, points in turns.items()}
    both = np.hstack([*turns.values()])
    found |= {"G(b)": minimum_zone(both)} if len(turns) > 1 else {}
    for side, points in turns.items():
        centre = least_squares_circle(points)[0] if centred else np.zeros(2)
        off = np.hypot(*(points - centre[:, None])) - radius
        found |= {f"Fmax({NAMES[side]})": float(off.max())}
        found |= {f"Fmin({NAMES[side]})": float(off.min())}
    return found | ({"D": least_squares_circle(both)[1] - radius} if len(turns) > 1 else {})


class Cause(NamedTuple):
    """A cause of radial deviations, with those that it would make alone."""

    name: str
    size: float  # from farthest inside the nominal circle to farthest outside
    value: float  # the same with a sign, see docs/circle.md
    width: float | None = None  # of spikes [deg]


def causes(turns: Turns, radius: float) -> list[Cause]:
    """Return the causes of the radial deviations, the largest first.

    The patterns that causes leave over the angle (Kakino, Ihara, Shinohara: Accuracy inspection of
    NC machine tools by double ball bar method, Hanser 1993) are taken one by one, each time that
    which explains most, and fitted together by least squares.
    """
    centre, _ = least_squares_circle(np.hstack([*turns.values()]))
    parts = [_sectors(side, x - centre[:, None], radius) for side, x in turns.items()]
    side, angle, off = np.hstack(parts)
    names, widths, columns = zip(*_patterns(side, angle, len(turns) > 1), strict=True)
    table, taken, chosen = np.stack(columns, axis=1), np.zeros(len(names), bool), list[int]()
    free, left = table.copy(), off
    while True:
        norm = np.linalg.norm(free, axis=0)
        usable = ~taken & (norm > LEAST * np.linalg.norm(table, axis=0))
        gain = np.where(usable, (left @ free) ** 2 / np.where(usable, norm**2, 1.0), 0.0)
        best = len(chosen) if len(chosen) < 3 else int(gain.argmax())  # radius and offset anyway
        if len(chosen) >= 3 and gain[best] <= LEAST * (left @ left):
            break
        along = free[:, best] / norm[best]
        free, left = free - np.outer(along, along @ free), left - along * (along @ left)
        chosen.append(best)
        taken |= np.array(names) == names[best]
    values = np.linalg.lstsq(table[:, chosen], off)[0]
    shift = 2.0 * float(np.hypot(*(centre + values[1:3])))
    found = [Cause(OFFSET, shift, shift)]
    for k, value in zip(chosen, values, strict=True):
        alone = value * table[:, k]
        if widths[k]:  # the pattern says where spikes are; how they are is the mean of all
            window = np.abs(alone) > TAIL * np.abs(alone).max()
            after = (SECTORS / 360.0 * _since(side, angle, names[k][-1])).astype(int)
            sums = np.bincount(after, np.where(window, alone + left, 0.0))
            mean = (sums / np.maximum(np.bincount(after, window), 1.0))[after]
            alone, left = np.where(window, mean, alone), np.where(window, left + alone - mean, left)
        if names[k] != OFFSET:
            peak = float(alone[np.abs(alone).argmax()]) if widths[k] else float(value)
            size = float(np.ptp(np.append(alone, 0.0)))
            found.append(Cause(names[k], size, peak, widths[k]))
    noise = 8.0**0.5 * rms(left)  # from peak to peak, if it is a sine
    return sorted([*found, Cause(REST, noise, noise)], key=lambda one: -one.size)


def _sectors(side: int, points: Floats, radius: float) -> Floats:
    """Return direction, angle and radial deviation (3, sectors) of each sector with samples."""
    angle = np.mod(np.arctan2(points[1], points[0]), 2.0 * np.pi)
    sector = (SECTORS / (2.0 * np.pi) * angle).astype(int)
    count = np.maximum(np.bincount(sector), 1)
    means = [np.bincount(sector, x) / count for x in (angle, np.hypot(*points) - radius)]
    return np.stack([np.full(len(count), side), *means])[:, np.unique(sector)]


def _since(side: Floats, angle: Floats, axis: str) -> Floats:
    """Return the angle since the last reversal of an axis (samples,) [deg]."""
    reversal = 0.0 if axis == "X" else 0.5 * np.pi
    return np.degrees(np.mod(side * (angle - reversal), np.pi))


def _patterns(
    side: Floats, angle: Floats, both: bool
) -> Iterator[tuple[str, float | None, Floats]]:
    """Yield each cause, the width of a spike, and the deviation that one unit of it makes.

    After a reversal an axis stands while the circle goes on, at first by the square of the angle:
    until a backlash is crossed, or a spike breaks off and decays.
    """
    x, y = np.cos(angle), np.sin(angle)
    yield from ((RADIUS, None, np.ones_like(x)), (OFFSET, None, x), (OFFSET, None, y))
    yield SCALE, None, 0.5 * (x * x - y * y)
    yield SQUARE if both else EITHER, None, x * y
    yield SERVO, None, side * x * y
    for axis in "XY":
        since = _since(side, angle, axis)
        for width in WIDTHS:
            stood = np.minimum(since / width, 1.0) ** 2
            yield BACKLASH.format(axis), None, (stood - 0.5) * np.cos(np.radians(since))
            for decay in DECAYS:
                spike = np.where(since < width, stood, np.exp((width - since) / decay))
                yield SPIKES.format(axis), float(width), spike
