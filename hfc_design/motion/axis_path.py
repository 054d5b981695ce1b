"""The path of a machine of any axes: blocks of a program, one after the other.

Its parameter is the way along which a feed is meant: in X-Y-Z [mm], or in A-B-C [deg] where none
of these moves. Each axis has its own unit, mm or deg.
"""

from collections.abc import Sequence
from math import pi
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Indices, Integers, Mask
from hfc_design.motion.gcode import AXES, Block
from hfc_design.motion.paths import SAME_PLACE, turned


class Places(NamedTuple):
    """Points of a path, one column each."""

    position: Floats  # (axes, points) [mm or deg]
    direction: Floats  # (axes, points) by the way
    bend: Floats  # (axes, points) of the direction, by the way


class AxisPath(NamedTuple):
    """Blocks in their order, one column each."""

    plane: tuple[int, int]  # rows of X and Y, where there are arcs
    lines: Integers  # (blocks,) of the program
    start: Floats  # (axes, blocks)
    rate: Floats  # (axes, blocks) by the way; 0 in X and Y of an arc
    length: Floats  # (blocks,) of the way [mm or deg]
    feed: Floats  # (blocks,) [mm/s or deg/s]; infinite for G0
    linear: Mask  # (blocks,) whether the way is in mm
    tangent: Floats  # (2, blocks) at the start of an arc, in X-Y; 0 for a line
    turning: Floats  # (blocks,) of that tangent by the way [rad/mm], to the left if positive
    knots: Floats  # (blocks + 1,) way up to each block and at its end

    @classmethod
    def of(cls, blocks: Sequence[Block], axes: Sequence[str]) -> "AxisPath":
        """The path of blocks that move no other ``axes``, names in small letters."""
        rows = [AXES.index(axis.upper()) for axis in axes]
        start, end = (np.array([getattr(b, key) for b in blocks]).T for key in ("start", "end"))
        length = np.array([block.length for block in blocks])
        radius = np.zeros((2, len(blocks)))
        turning = np.zeros(len(blocks))
        for k, block in enumerate(blocks):
            if block.centre is not None:
                turning[k] = block.sweep / length[k]
                radius[:, k] = np.subtract(block.start[:2], block.centre)
        rate = np.where((np.arange(len(AXES)) < 2)[:, None] & (turning != 0), 0.0, end - start)
        tangent = turning * np.stack([-radius[1], radius[0]])  # of the length that X and Y share
        feeds = [np.inf if block.feed is None else block.feed for block in blocks]
        places = [axes.index(axis) if axis in axes else 0 for axis in "xy"]
        return cls(
            (places[0], places[1]),
            np.array([block.line for block in blocks]),
            start[rows],
            (rate / length)[rows],
            length,
            np.array(feeds) / 60.0,
            np.array([block.linear for block in blocks]),
            tangent,
            turning,
            np.concatenate([[0.0], np.cumsum(length)]),
        )

    def at(self, way: Floats) -> Places:
        """Where the path is after the ``way`` (points,); beyond its ends it holds."""
        k = self.block(way)
        return self.on(k, np.clip(way - self.knots[k], 0.0, self.length[k]))

    def tip_at(self, way: Floats) -> Places:
        """As ``at``, but on blocks that only turn, where the linear axes moved last.

        That is the end of the last block that moves them, or else the start of the first.
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
        """(points,) the block in which the ``way`` (points,) ends."""
        last = len(self.length) - 1
        return np.clip(np.searchsorted(self.knots, way, side="right") - 1, 0, last)

    def on(self, k: Indices, s: Floats) -> Places:
        """Where block ``k`` (points,) is after the way ``s`` (points,) of its own."""
        direction = self.rate[:, k]
        position = self.start[:, k] + direction * s
        bend = np.zeros_like(direction)
        if self.turning.any():
            plane, turning, tangent = list(self.plane), self.turning[k], self.tangent[:, k]
            half = 0.5 * turning * s
            position[plane] += s * np.sinc(half / pi) * turned(tangent, half)
            now = turned(tangent, 2 * half)
            direction[plane] += now
            bend[plane] = turning * np.stack([-now[1], now[0]])
        return Places(position, direction, bend)

    @property
    def curvature(self) -> Floats:
        """(blocks,) of arcs that stay in X-Y [1/mm], positive to the left; 0 of any other block."""
        whole = np.hypot(*self.tangent) > 1.0 - 1e-12
        return np.where(whole, self.turning, 0.0)

    @property
    def fastest(self) -> Floats:
        """(axes, blocks) the largest direction of each axis, of an arc no less than that."""
        found = np.abs(self.rate)
        found[list(self.plane)] += np.hypot(*self.tangent)
        return found

    def spans(self) -> tuple[Floats, Floats]:
        """(axes, blocks) the lowest and the highest place of each axis on each block."""
        blocks = np.arange(len(self.length))
        ends = np.stack([self.start, self.on(blocks, self.length).position])
        low, high = ends.min(axis=0), ends.max(axis=0)
        for k in np.flatnonzero(self.turning):  # X or Y may turn back
            first = np.arctan2(*self.tangent[::-1, k]) / (pi / 2)
            last = first + self.turning[k] * self.length[k] / (pi / 2)
            quarters = np.arange(np.ceil(min(first, last)), np.floor(max(first, last)) + 1)
            ways = (quarters - first) * (pi / 2) / self.turning[k]
            places = self.on(np.full(len(ways), k), ways).position
            low[:, k] = np.minimum(low[:, k], places.min(axis=1, initial=np.inf))
            high[:, k] = np.maximum(high[:, k], places.max(axis=1, initial=-np.inf))
        return low, high


def travel_fault(
    path: AxisPath, axes: Sequence[str], travel: Sequence[tuple[float, float] | None]
) -> str | None:
    """A line if the path leaves the ``travel`` of an axis somewhere."""
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
    """A line if blocks move an axis that is none of these."""
    for block in blocks:
        for axis, a, b in zip(AXES, block.start, block.end, strict=True):
            moves = a != b or (block.centre is not None and axis in "XY")
            if moves and axis.lower() not in axes:
                known = ", ".join(axes)
                return (
                    f"line {block.line}: moves {axis}; the machine has no such axis, only {known}"
                )
    return None
