"""Paths in the X-Y plane: straight lines and circular arcs, one after the other.

One formula serves both. From a start with unit tangent t, a segment of curvature c has turned by
c s after the length s; its chord has turned by half of that and is s sinc(c s / 2) long.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import hypot, pi
from typing import NamedTuple

import numpy as np

from hfc_design.core.shapes import Floats, Indices, Mask

Point = tuple[float, float]


class Segment(NamedTuple):
    """A line, or an arc of any number of turns."""

    start: Point  # [mm]
    tangent: Point  # unit vector at the start
    length: float  # [mm]
    curvature: float  # [1/mm], positive to the left, 0 for a line
    feed: float  # [mm/min]


def line(start: Point, end: Point, feed: float) -> Segment:
    """The straight line between two different points [mm] at ``feed`` [mm/min]."""
    x, y = end[0] - start[0], end[1] - start[1]
    length = hypot(x, y)
    return Segment(start, (x / length, y / length), length, 0.0, feed)


def arc(start: Point, centre: Point, sweep: float, feed: float) -> Segment:
    """The arc from ``start`` about ``centre`` [mm] through ``sweep`` [rad], ccw if positive."""
    x, y = start[0] - centre[0], start[1] - centre[1]
    radius = hypot(x, y)
    side = 1.0 if sweep > 0 else -1.0
    tangent = (-side * y / radius, side * x / radius)
    return Segment(start, tangent, radius * abs(sweep), side / radius, feed)


#: Points nearer than this are the same place [mm].
SAME_PLACE = 1e-6
#: A change of direction below this is no corner [deg]; programs print three digits of a mm.
CORNER = 1.0


class Places(NamedTuple):
    """Points of a path, one column each."""

    position: Floats  # (2, points) [mm]
    tangent: Floats  # (2, points) unit vectors
    curvature: Floats  # (points,) [1/mm], positive to the left


@dataclass(frozen=True, eq=False)
class Path:
    """Segments in their order, one column each."""

    start: Floats  # (2, segments) [mm]
    tangent: Floats  # (2, segments)
    length: Floats  # (segments,) [mm]
    curvature: Floats  # (segments,) [1/mm]
    feed: Floats  # (segments,) [mm/min]
    knots: Floats  # (segments + 1,) length of the path up to each segment and at its end [mm]

    @classmethod
    def of(cls, segments: Iterable[Segment]) -> "Path":
        """The path of at least one segment; each starts where the one before ends."""
        columns = zip(*segments, strict=True)
        start, tangent, length, curvature, feed = (
            np.array(column, dtype=np.float64).T for column in columns
        )
        knots = np.concatenate([[0.0], np.cumsum(length)])
        return cls(start, tangent, length, curvature, feed, knots)

    def at(self, distance: Floats) -> Places:
        """Where the path is after ``distance`` (points,) [mm]; beyond its ends it holds."""
        last = len(self.length) - 1
        k = np.clip(np.searchsorted(self.knots, distance, side="right") - 1, 0, last)
        return self.on(k, np.clip(distance - self.knots[k], 0.0, self.length[k]))

    def on(self, k: Indices, s: Floats) -> Places:
        """Where segment ``k`` (points,) is after the length ``s`` (points,) [mm] of its own."""
        curvature, tangent = self.curvature[k], self.tangent[:, k]
        half = 0.5 * curvature * s
        chord = s * np.sinc(half / pi) * _turned(tangent, half)
        return Places(self.start[:, k] + chord, _turned(tangent, 2 * half), curvature)

    def corners(self) -> Mask:
        """(segments - 1,) whether the direction jumps between a segment and the next."""
        before = _turned(self.tangent, self.curvature * self.length)[:, :-1]
        after = self.tangent[:, 1:]
        cross = before[0] * after[1] - before[1] * after[0]
        jump = np.arctan2(cross, (before * after).sum(axis=0))
        return np.asarray(np.abs(jump) > np.radians(CORNER))

    def largest_components(self) -> Floats:
        """(2, segments) the largest share of the speed that X and Y get on each segment."""
        first = np.arctan2(self.tangent[1], self.tangent[0])
        ends = np.sort([first, first + self.curvature * self.length], axis=0) / pi
        shifted = np.stack([ends, ends - 0.5])  # an axis moves fastest where this is an integer
        passed = np.floor(shifted[:, 1]) >= np.ceil(shifted[:, 0])
        largest = np.abs(np.cos(pi * shifted)).max(axis=1)
        return np.where(passed, 1.0, largest)


def distance(a: Point, b: Point) -> float:
    """Between two points [mm]."""
    return hypot(b[0] - a[0], b[1] - a[1])


def _turned(vector: Floats, angle: Floats) -> Floats:
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.stack([cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1]])
