"""How fast a path of any axes can be passed: no axis beyond its velocity and its acceleration.

The path is exact, so at a corner the velocity of an axis jumps. In the sense of the interpolator,
whose cycle is T, an axis accelerates by ``(x(t+T) - 2 x(t) + x(t-T)) / T^2``: the mean of its true
acceleration, weighed by a triangle of that height about t, jumps being its impulses. That mean
stays within the limit ``a`` where at every corner a share U of the limit is kept for the jump,

    |jump| <= 3/4 U a min(T, s),

s being the time of the shorter of the blocks beside it, and 1 - U for the acceleration within these
blocks: each impulse then is less than what the triangle has of the time s about it, left free by U.
(At the triangle's tip that is 3/4 of s or more; time of one corner is not time of another.)
"""

from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import SAME, Floats, Indices
from hfc_design.motion.axis_path import AxisPath
from hfc_design.motion.paths import Motion, Speeds, phased, reachable

#: Share of the acceleration that a corner may take, and that the bend of an arc may.
CORNER, BEND = 0.5, 0.4
#: Of a jump in the time beside it.
FREE = 0.75
#: Speeds that are reached from rest in so many cycles are no speeds to pass a corner with.
CYCLES = 2.0


class Bounds(NamedTuple):
    """What each axis can do, (axes,) in mm or deg and s."""

    velocity: Floats
    rapid: Floats  # the velocity of G0
    acceleration: Floats


def look_ahead(path: AxisPath, bounds: Bounds, cycle: float) -> Motion:
    """The fastest motion along ``path`` from rest to rest, block by block at constant acceleration.

    Args:
        path: its feeds are not exceeded.
        bounds: neither are these, see above.
        cycle: T [s].

    Raises:
        ValueError: a block is so slow or short that its speed is rounded to 0.
    """
    most, rate, bent = _alone(path, bounds)
    between, share = _corners(path, bounds, cycle, most, rate)
    block, length, fastest, used = _pieces(path, most, between, share, cycle)
    rate = rate[block] * np.sqrt((1.0 - used) ** 2 - bent[block] ** 2)
    speed = reachable(fastest, 2.0 * rate * length)
    entry, leave = speed[:-1], speed[1:]
    peak = np.minimum(most[block], np.sqrt(rate * length + 0.5 * (entry**2 + leave**2)))
    if not peak.all():  # rounded away, of what no machine is
        raise ValueError("a block of its program never gets going; see its limits")
    speeds = Speeds(entry, leave, peak, (peak - entry) / rate, (peak - leave) / rate)
    found = phased(np.append(0.0, np.cumsum(length)), length, speeds, rate)
    first = np.flatnonzero(np.diff(block, prepend=-1))
    return found._replace(peak=np.maximum.reduceat(peak, first))


def _pieces(
    path: AxisPath, most: Floats, between: Floats, share: Floats, cycle: float
) -> tuple[Indices, Floats, Floats, Floats]:
    """Blocks cut into what is near a corner, within a cycle, and what is not, if they are long.

    Of each piece the block, the length and the share of its acceleration that corners take; of
    what lies between them the largest speed.
    """
    count, near = len(path.length), most * cycle
    long = path.length > 4.0 * near * (1.0 + SAME)
    block = np.repeat(np.arange(count), np.where(long, 3, 1))
    first = np.flatnonzero(np.diff(block, prepend=-1))
    length = path.length[block]
    before, after = np.append(0.0, share), np.append(share, 0.0)
    used = np.maximum(before, after)[block]
    fastest = most[block]  # at the start of each piece
    fastest[first] = np.append(0.0, between)
    head = first[long]
    length[head] = length[head + 2] = near[long]
    length[head + 1] -= 2.0 * near[long]
    used[head], used[head + 1], used[head + 2] = before[long], 0.0, after[long]
    return block, length, np.append(fastest, 0.0), used


def _alone(path: AxisPath, bounds: Bounds) -> tuple[Floats, Floats, Floats]:
    """Of each block the largest speed, the acceleration, and the share of it that a bend takes."""
    with np.errstate(divide="ignore"):
        inverse = 1.0 / path.fastest
    limit = np.where(np.isinf(path.feed), bounds.rapid[:, None], bounds.velocity[:, None])
    most = np.minimum(path.feed, (limit * inverse).min(axis=0))
    rate = (bounds.acceleration[:, None] * inverse).min(axis=0)
    weakest = bounds.acceleration[list(path.plane)].min()  # of X and Y, which an arc needs both
    bend = np.abs(path.turning) * np.hypot(*path.tangent)
    arc = bend > 0
    rate[arc] = np.minimum(rate[arc], weakest / np.hypot(*path.tangent[:, arc]))
    most[arc] = np.minimum(most[arc], np.sqrt(BEND * weakest / bend[arc]))
    return most, rate, bend * most**2 / weakest


def _corners(
    path: AxisPath, bounds: Bounds, cycle: float, most: Floats, rate: Floats
) -> tuple[Floats, Floats]:
    """Of each corner the largest speed, and the share of the acceleration that it takes then."""
    ends = np.arange(len(path.length))
    leaving = path.on(ends, path.length).direction[:, :-1]
    jump = np.abs(path.on(ends, np.zeros_like(path.length)).direction[:, 1:] - leaving)
    # speed * strain <= U min(T, s) is what the module says
    strain = (jump / bounds.acceleration[:, None]).max(axis=0) / FREE
    gain = 2.0 * rate * path.length  # of a block's squared speed at most
    sides = [(path.length[k], gain[k], most[k]) for k in (slice(None, -1), slice(1, None))]
    speed = np.minimum(most[:-1], most[1:])
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = np.minimum(speed, CORNER * cycle / strain)
        for length, more, _ in sides:  # s = length / peak at least, with peak^2 = speed^2 + more
            half = CORNER * length / strain
            square = 2.0 * half * (half / (more + np.hypot(more, 2.0 * half)))
            speed = np.where(strain > 0.0, np.minimum(speed, np.sqrt(square)), speed)
    slow = speed * (1.0 + SAME) < CYCLES * cycle * np.minimum(rate[:-1], rate[1:])
    other = path.linear[:-1] != path.linear[1:]  # mm are no degrees
    speed = np.where(slow | other, 0.0, speed)
    peaks = [np.minimum(top, np.sqrt(speed**2 + more)) for _, more, top in sides]
    times = [length / peak for (length, *_), peak in zip(sides, peaks, strict=True)]
    return speed, speed * strain / np.minimum(np.minimum(*times), cycle)
