"""Path of a machine of any axes: blocks of a program, one after the other.

Places on the path are given by the *way* from its start, the length along which a feed is meant: in
X-Y-Z [mm], or in A-B-C [deg] where none of X, Y, Z moves. Each axis has its own unit, mm or deg.
``look_ahead`` finds the fastest motion along a path.
"""

from collections.abc import Sequence
from math import pi
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import SAME, Floats, Indices, Integers, Mask
from hfc_design.motion.gcode import AXES, Block
from hfc_design.motion.paths import SAME_PLACE, Motion, fastest_motion, turned


class Places(NamedTuple):
    """Points of a path, one column each."""

    position: Floats  # (axes, points) [mm or deg]
    direction: Floats  # (axes, points) derivative of the position by the way
    bend: Floats  # (axes, points) derivative of the direction by the way


class AxisPath(NamedTuple):
    """Path through the blocks of a program, one column each."""

    plane: Indices  # (2, blocks) rows in the arrays of both axes that an arc turns
    lines: Integers  # (blocks,) line of each block in the program
    start: Floats  # (axes, blocks)
    rate: Floats  # (axes, blocks) derivative of the position by the way; 0 in an arc's plane
    length: Floats  # (blocks,) way along each block [mm or deg]
    feed: Floats  # (blocks,) [mm/s or deg/s]; infinite for G0
    rest: Floats  # (blocks,) time at the start of each [s]
    linear: Mask  # (blocks,) True if the way is in mm
    tangent: Floats  # (2, blocks) derivative of the plane's axes at an arc's start; 0 for a line
    turning: Floats  # (blocks,) turn of that tangent per way [rad/mm], to the left if positive
    knots: Floats  # (blocks + 1,) way at the start of each block, and at the end of the path

    @classmethod
    def of(cls, blocks: Sequence[Block], axes: Sequence[str]) -> "AxisPath":
        """Return the path of ``blocks``, which move only ``axes`` (names in small letters)."""
        rows = [AXES.index(axis.upper()) for axis in axes]
        start, end = (np.array([getattr(b, key) for b in blocks]).T for key in ("start", "end"))
        length = np.array([block.length for block in blocks])
        radius, planes = np.zeros((2, len(blocks))), np.array([block.plane for block in blocks]).T
        turning = np.zeros(len(blocks))
        for k, block in enumerate(blocks):
            if block.centre is not None:
                turning[k] = block.sweep / length[k]
                radius[:, k] = np.take(block.start, block.plane) - block.centre
        rate, bent = end - start, np.flatnonzero(turning)
        rate[planes[:, bent], bent] = 0.0
        tangent = turning * np.stack([-radius[1], radius[0]])  # its length: the arc's share of way
        feeds = [np.inf if block.feed is None else block.feed for block in blocks]
        return cls(
            np.array([axes.index(axis) if axis in axes else 0 for axis in "xyz"])[planes],
            np.array([block.line for block in blocks]),
            start[rows],
            (rate / length)[rows],
            length,
            np.array(feeds) / 60.0,
            np.array([block.rest for block in blocks]),
            np.array([block.linear for block in blocks]),
            tangent,
            turning,
            np.concatenate([[0.0], np.cumsum(length)]),
        )

    def at(self, way: Floats) -> Places:
        """Return the places at the ``way`` (points,), limited to the length of the path."""
        k = self.block(way)
        return self.on(k, np.clip(way - self.knots[k], 0.0, self.length[k]))

    def tip_at(self, way: Floats) -> Places:
        """Return ``at``, but in a block that only turns, the place where linear axes moved last.

        That is the end of the last block that moves them; before the first of these, its start.
        """
        k, moving = self.block(way), np.flatnonzero(self.linear)
        if not len(moving):
            return self.at(way)
        last = np.searchsorted(moving, k, side="right") - 1
        moved = moving[np.maximum(last, 0)]
        s = np.clip(way - self.knots[k], 0.0, self.length[k])
        stopped = np.where(last < 0, 0.0, self.length[moved])
        return self.on(moved, np.where(self.linear[k], s, stopped))

    def block(self, way: Floats) -> Indices:
        """Return the indices (points,) of the blocks that contain the ``way`` (points,)."""
        last = len(self.length) - 1
        return np.clip(np.searchsorted(self.knots, way, side="right") - 1, 0, last)

    def on(self, k: Indices, s: Floats) -> Places:
        """Return the places on block ``k`` (points,) after the way ``s`` (points,) within it."""
        direction = self.rate[:, k]
        position = self.start[:, k] + direction * s
        bend = np.zeros_like(direction)
        if self.turning.any():
            turning, tangent = self.turning[k], self.tangent[:, k]
            plane, half = (self.plane[:, k], np.arange(len(k))), 0.5 * turning * s
            position[plane] += s * np.sinc(half / pi) * turned(tangent, half)
            now = turned(tangent, 2 * half)
            direction[plane] += now
            bend[plane] = turning * np.stack([-now[1], now[0]])
        return Places(position, direction, bend)

    @property
    def curvature(self) -> Floats:
        """Curvature (blocks,) of arcs in the first two axes alone [1/mm], left positive; else 0."""
        whole = (np.hypot(*self.tangent) > 1.0 - 1e-12) & (self.plane.max(axis=0) < 2)
        return np.where(whole, (self.plane[1] - self.plane[0]) * self.turning, 0.0)

    @property
    def fastest(self) -> Floats:
        """Largest derivative (axes, blocks) of each axis by the way; on an arc an upper bound."""
        largest = np.abs(self.rate)
        largest[self.plane, np.arange(len(self.length))] += np.hypot(*self.tangent)
        return largest

    def spans(self) -> tuple[Floats, Floats]:
        """Return the lowest and the highest place (axes, blocks) of each axis on each block."""
        blocks = np.arange(len(self.length))
        ends = np.stack([self.start, self.on(blocks, self.length).position])
        low, high = ends.min(axis=0), ends.max(axis=0)
        for k in np.flatnonzero(self.turning):  # an axis of the plane may turn back
            first = np.arctan2(*self.tangent[::-1, k]) / (pi / 2)
            last = first + np.clip(self.turning[k] * self.length[k] / (pi / 2), -4.0, 4.0)
            quarters = np.arange(np.ceil(min(first, last)), np.floor(max(first, last)) + 1)
            ways = (quarters - first) * (pi / 2) / self.turning[k]
            places = self.on(np.full(len(ways), k), ways).position
            low[:, k] = np.minimum(low[:, k], places.min(axis=1, initial=np.inf))
            high[:, k] = np.maximum(high[:, k], places.max(axis=1, initial=-np.inf))
        return low, high


def travel_fault(
    path: AxisPath, axes: Sequence[str], travel: Sequence[tuple[float, float] | None]
) -> str | None:
    """Return a line if the path leaves the ``travel`` of an axis, else None."""
    lowest, highest = np.transpose([(-np.inf, np.inf) if one is None else one for one in travel])
    low, high = path.spans()
    below, above = low < lowest[:, None] - SAME_PLACE, high > highest[:, None] + SAME_PLACE
    outside = below | above
    if not outside.any():
        return None
    block = int(outside.any(axis=0).argmax())
    axis = int(outside[:, block].argmax())
    where = (low if below[axis, block] else high)[axis, block]
    return (
        f"line {path.lines[block]}: {axes[axis].upper()} goes to {where:.6g}, outside its travel "
        f"of {lowest[axis]:g} to {highest[axis]:g} {'mm' if axes[axis] in 'xyz' else 'deg'}"
    )


def other_axis_fault(blocks: Sequence[Block], axes: Sequence[str]) -> str | None:
    """Return a line if blocks move an axis that is not in ``axes``, else None."""
    for block in blocks:
        for k, axis in enumerate(AXES):
            turns = block.centre is not None and k in block.plane
            moves = turns or block.start[k] != block.end[k]
            if moves and axis.lower() not in axes:
                known = ", ".join(axes)
                return f"line {block.line}: moves {axis}; the machine has only the axes {known}"
    return None


#: Share of the acceleration that a corner may take, and share that the bend of an arc may take.
CORNER, BEND = 0.5, 0.4
#: The factor 3/4 in the limit of the velocity jump at a corner, see below.
FREE = 0.75
#: At a corner that can only be passed slower than so many cycles accelerate to, the motion stops.
CYCLES = 2.0


class Bounds(NamedTuple):
    """Limits of each axis: arrays (axes,) in mm or deg and s."""

    velocity: Floats
    rapid: Floats  # the velocity of G0
    acceleration: Floats
    jerk: Floats | float = np.inf  # along straight lines; see ``look_ahead``


# Velocity and acceleration of every axis are limited. The path is exact, so the velocity of an axis
# jumps at a corner. The interpolator, whose cycle is T, measures the acceleration as
# ``(x(t+T) - 2 x(t) + x(t-T)) / T^2``: the mean of the true acceleration with triangular weights
# between t - T and t + T, in which a jump is an impulse. This mean stays within the limit ``a`` if
# at every corner a share U of the limit is kept for the jump,
#
#     |jump| <= 3/4 U a min(T, s),
#
# where s is the time of the shorter of the two adjacent blocks, and the share 1 - U for the
# acceleration within these blocks. Each impulse is then less than U a times the area of the
# triangle over the time s about the corner. (Around the tip of the triangle this area is at least
# 3/4 of s times its height. The times of two corners do not overlap.)
def look_ahead(path: AxisPath, bounds: Bounds, cycle: float) -> Motion:
    """Return the fastest motion from rest to rest with piecewise constant acceleration or jerk.

    With limits of the jerk the way is averaged over so long a time that every axis keeps its own on
    straight lines. Corners and arcs are passed as without.

    Args:
        path: path of the motion; its feeds are not exceeded.
        bounds: limits of the axes, which are not exceeded either, see above.
        cycle: cycle T of the interpolator [s].

    Raises:
        ValueError: a block is so slow or short that its speed is rounded to 0.
    """
    most, rate, bent = _alone(path, bounds)
    between, share = _corners(path, bounds, cycle, most, rate)
    # With averages, a speed that is held between pieces costs more than less acceleration does.
    near = most * cycle if np.isinf(bounds.jerk).all() else np.full_like(most, np.inf)
    block, length, fastest, used = _pieces(path, most, between, share, near)
    rate = rate[block] * np.sqrt((1.0 - used) ** 2 - bent[block] ** 2)
    half = float((rate * path.fastest[:, block] / np.reshape(bounds.jerk, (-1, 1))).max())
    first, rest = np.flatnonzero(np.diff(block, prepend=-1)), np.zeros_like(length)
    rest[first] = path.rest
    motion = fastest_motion(length, most[block], fastest, rate, rest, half)
    if not motion.peak.all():  # rounded to 0: no machine has such limits
        raise ValueError("a block of its program cannot start; check its limits")
    return motion._replace(peak=np.maximum.reduceat(motion.peak, first))


def _pieces(
    path: AxisPath, most: Floats, between: Floats, share: Floats, near: Floats
) -> tuple[Indices, Floats, Floats, Floats]:
    """Cut each long block into three pieces: the way ``near`` to each corner, and in between.

    Returns:
        Block and length of each piece, the largest speeds at the ends of the pieces
        (pieces + 1,), and the share of the acceleration that corners take in each piece.
    """
    count = len(path.length)
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
    """Return limits of speed and acceleration of each block, and the share that its bend takes."""
    with np.errstate(divide="ignore"):
        inverse = 1.0 / path.fastest
    limit = np.where(np.isinf(path.feed), bounds.rapid[:, None], bounds.velocity[:, None])
    most = np.minimum(path.feed, (limit * inverse).min(axis=0))
    rate = (bounds.acceleration[:, None] * inverse).min(axis=0)
    weakest = bounds.acceleration[path.plane].min(axis=0)  # an arc needs both
    bend = np.abs(path.turning) * np.hypot(*path.tangent)
    arc = bend > 0
    rate[arc] = np.minimum(rate[arc], weakest[arc] / np.hypot(*path.tangent[:, arc]))
    most[arc] = np.minimum(most[arc], np.sqrt(BEND * weakest[arc] / bend[arc]))
    return most, rate, bend * most**2 / weakest


def _corners(
    path: AxisPath, bounds: Bounds, cycle: float, most: Floats, rate: Floats
) -> tuple[Floats, Floats]:
    """Return the largest speed at each corner, and the share of the acceleration that it takes."""
    ends = np.arange(len(path.length))
    leaving = path.on(ends, path.length).direction[:, :-1]
    jump = np.abs(path.on(ends, np.zeros_like(path.length)).direction[:, 1:] - leaving)
    # The limit of the jump (above ``look_ahead``) is: speed * strain <= U min(T, s).
    strain = (jump / bounds.acceleration[:, None]).max(axis=0) / FREE
    gain = 2.0 * rate * path.length  # largest change of the squared speed on a block
    sides = [(path.length[k], gain[k], most[k]) for k in (slice(None, -1), slice(1, None))]
    speed = np.minimum(most[:-1], most[1:])
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = np.minimum(speed, CORNER * cycle / strain)
        for length, more, _ in sides:  # s = length / peak at least, with peak^2 = speed^2 + more
            half = CORNER * length / strain
            square = 2.0 * half * (half / (more + np.hypot(more, 2.0 * half)))
            speed = np.where(strain > 0.0, np.minimum(speed, np.sqrt(square)), speed)
    slow = speed * (1.0 + SAME) < CYCLES * cycle * np.minimum(rate[:-1], rate[1:])
    other = path.linear[:-1] != path.linear[1:]  # the way changes between mm and deg: stop
    speed = np.where(slow | other | (path.rest[1:] > 0.0), 0.0, speed)
    peaks = [np.minimum(top, np.sqrt(speed**2 + more)) for _, more, top in sides]
    times = [length / peak for (length, *_), peak in zip(sides, peaks, strict=True)]
    return speed, speed * strain / np.minimum(np.minimum(*times), cycle)
