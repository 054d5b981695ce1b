"""Paths of straight lines and circular arcs in the X-Y plane, and motion along them.

One formula serves lines and arcs. After a length s from its start, a segment of curvature c has
turned by the angle c s. Its chord has turned by c s / 2, and is s sinc(c s / 2) long.
"""

from collections.abc import Iterable
from functools import partial
from math import hypot, pi, sqrt
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import SAME, Floats, Indices, Mask, passed

Point = tuple[float, float]


class Segment(NamedTuple):
    """Straight line, or arc of any number of turns."""

    start: Point  # [mm]
    tangent: Point  # unit vector at the start
    length: float  # [mm]
    curvature: float  # [1/mm], positive to the left, 0 for a line
    feed: float  # [mm/min]
    rest: float = 0.0  # time at its start [s]


def line(start: Point, end: Point, feed: float) -> Segment:
    """Return the straight line between two different points [mm] at ``feed`` [mm/min]."""
    x, y = end[0] - start[0], end[1] - start[1]
    length = hypot(x, y)
    return Segment(start, (x / length, y / length), length, 0.0, feed)


def arc(start: Point, centre: Point, sweep: float, feed: float) -> Segment:
    """Return the arc from ``start`` about ``centre`` [mm] by ``sweep`` [rad], ccw if positive."""
    x, y = start[0] - centre[0], start[1] - centre[1]
    radius = hypot(x, y)
    side = 1.0 if sweep > 0 else -1.0
    tangent = (-side * y / radius, side * x / radius)
    return Segment(start, tangent, radius * abs(sweep), side / radius, feed)


#: Largest distance of two points that count as the same place [mm].
SAME_PLACE = 1e-6
#: Largest change of direction that does not count as a corner [deg]. A circle of 360 lines changes
#: it by 1 deg, but for rounding (programs have three digits of a mm), and has no corners.
CORNER = 1.000001


class Places(NamedTuple):
    """Points of a path, one column each."""

    position: Floats  # (2, points) [mm]
    tangent: Floats  # (2, points) unit vectors
    curvature: Floats  # (points,) [1/mm], positive to the left


class Path(NamedTuple):
    """Path through segments in their order, one column each."""

    start: Floats  # (2, segments) [mm]
    tangent: Floats  # (2, segments)
    length: Floats  # (segments,) [mm]
    curvature: Floats  # (segments,) [1/mm]
    feed: Floats  # (segments,) [mm/min]
    rest: Floats  # (segments,) time at the start of each [s]
    knots: Floats  # (segments + 1,) length of the path up to each segment and at its end [mm]

    @classmethod
    def of(cls, segments: Iterable[Segment]) -> "Path":
        """Return the path of at least one segment; each starts where the one before ends."""
        columns = zip(*segments, strict=True)
        start, tangent, length, curvature, feed, rest = (
            np.array(column, dtype=np.float64).T for column in columns
        )
        knots = np.concatenate([[0.0], np.cumsum(length)])
        return cls(start, tangent, length, curvature, feed, rest, knots)

    def at(self, distance: Floats) -> Places:
        """Return the places at ``distance`` (points,) [mm], limited to the length of the path."""
        distance = np.clip(distance, 0.0, self.knots[-1])
        k = self.segment(distance)
        return self.on(k, distance - self.knots[k])

    def segment(self, distance: Floats) -> Indices:
        """Return the index (points,) of the segment at a ``distance`` (points,) [mm]."""
        last = len(self.length) - 1
        return np.clip(passed(self.knots, distance) - 1, 0, last)

    def on(self, k: Indices, s: Floats) -> Places:
        """Return the places on segment ``k`` (points,) after its length ``s`` (points,) [mm]."""
        curvature, tangent = self.curvature[k], self.tangent[:, k]
        half = 0.5 * curvature * s
        chord = s * np.sinc(half / pi) * turned(tangent, half)
        return Places(self.start[:, k] + chord, turned(tangent, 2 * half), curvature)

    def corners(self) -> Mask:
        """Return (segments - 1,) True where the direction jumps from a segment to the next."""
        before = turned(self.tangent, self.curvature * self.length)[:, :-1]
        after = self.tangent[:, 1:]
        cross = before[0] * after[1] - before[1] * after[0]
        jump = np.arctan2(cross, (before * after).sum(axis=0))
        return np.asarray(np.abs(jump) > np.radians(CORNER))

    def largest_components(self) -> Floats:
        """Return (2, segments) the largest share of X and Y in the speed along each segment."""
        first = np.arctan2(self.tangent[1], self.tangent[0])
        ends = np.sort([first, first + self.curvature * self.length], axis=0) / pi
        shifted = np.stack([ends, ends - 0.5])  # an axis moves fastest where this is an integer
        passed = np.floor(shifted[:, 1]) >= np.ceil(shifted[:, 0])
        largest = np.abs(np.cos(pi * shifted)).max(axis=1)
        return np.where(passed, 1.0, largest)


def turned(vector: Floats, angle: Floats) -> Floats:
    """Return vectors (2, points) turned to the left by an ``angle`` (points,) [rad]."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.stack([cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1]])


class Motion(NamedTuple):
    """Motion in phases of constant jerk; without a limit of the jerk it is 0 in all of them."""

    start: Floats  # (phases,) when each begins [s]
    distance: Floats  # (phases,) way along the path at its start [mm]
    speed: Floats  # (phases,) at its start [mm/s]
    acceleration: Floats  # (phases,) at its start [mm/s2]
    jerk: Floats  # (phases,) [mm/s3]
    peak: Floats  # (segments,) largest speed on each segment [mm/s]

    @property
    def finite(self) -> bool:
        """True if all numbers of the motion are finite."""
        return all(bool(np.isfinite(part).all()) for part in self)

    @property
    def duration(self) -> float:
        """Time at which the end of the path is reached [s]."""
        return float(self.start[-1])

    def at(self, time: Floats) -> tuple[Floats, Floats, Floats]:
        """Return distance [mm], speed [mm/s], acceleration along the path [mm/s2] at a time [s]."""
        k = np.maximum(passed(self.start, time) - 1, 0)
        since = np.maximum(time, 0.0) - self.start[k]
        speed, rate, jerk = self.speed[k], self.acceleration[k], self.jerk[k]
        way = self.distance[k] + (speed + (0.5 * rate + jerk * since / 6.0) * since) * since
        speed = np.maximum(speed + (rate + 0.5 * jerk * since) * since, 0.0)
        return np.minimum(way, self.distance[-1]), speed, rate + jerk * since

    def averaged(self, time: float) -> "Motion":
        """Return the motion whose way, speed and acceleration are means of the last ``time`` [s].

        Its jerk is the change of the acceleration in this time, divided by the time.
        """
        start = np.unique([self.start, self.start + time])
        pairs = zip(self.at(start), self.at(start - time), strict=True)
        speed, rate, jerk = ((now - before) / time for now, before in pairs)
        step = np.diff(start, append=start[-1:])
        moved = (speed + (0.5 * rate + jerk * step / 6.0) * step) * step
        way = np.cumsum(moved) - moved
        way[-1] = self.distance[-1]
        return Motion(start, way, speed, rate, jerk, self.peak)


def motion(path: Path, acceleration: float | None, jerk: float | None = None) -> Motion:
    """Return the fastest motion along ``path`` from rest to rest.

    The motion stops at a rest, and where the direction jumps. Elsewhere it passes from segment to
    segment at the lower of both feeds, or slower where that leaves too little way to brake. Only
    the acceleration along the path is limited; the centripetal acceleration of an arc is not.

    Args:
        path: the segments and their feeds.
        acceleration: limit [mm/s2]; None: full feed at once on every segment, also at corners.
        jerk: limit of the jerk along the path [mm/s3], needs an acceleration; None: unlimited.
    """
    feed, stops = path.feed / 60.0, path.corners() | (path.rest[1:] > 0.0)
    passing, still = np.minimum(feed[:-1], feed[1:]), np.zeros(1)
    fastest = np.concatenate([still, np.where(stops, 0.0, passing), still])
    if acceleration is None:  # a huge one, with which the speed changes at once
        acceleration, fastest = 1e100, np.concatenate([feed[:1], passing, feed[-1:]])
    rate, time = np.full_like(feed, acceleration), acceleration / jerk if jerk else 0.0
    averaged = partial(fastest_motion, path.length, feed, fastest, rate, path.rest)
    once = averaged(0.5 * time)  # long enough unless braking follows on acceleration at once
    enough = not jerk or np.abs(once.jerk).max() <= jerk * (1.0 + SAME)
    return once if enough else averaged(time)


# A mean over the time T (``Motion.averaged``) could pass the end of a slow segment too fast, since
# it contains speeds and accelerations of the next one. Therefore the speed at each end is held for
# half of T before and after it. The mean then has exactly this speed when its way passes the end,
# and on a segment it contains no acceleration and no higher speed than those of that segment.
@np.errstate(divide="ignore", invalid="ignore")  # a segment so slow or short that its peak is 0
def fastest_motion(
    length: Floats, most: Floats, fastest: Floats, rate: Floats, rest: Floats, half: float = 0.0
) -> Motion:
    """Return the fastest motion through segments, averaged over twice the time ``half`` [s].

    Each segment has a ``length`` [mm], a largest speed ``most`` [mm/s], an acceleration ``rate``
    [mm/s2] and a time of ``rest`` at its start [s]. ``fastest`` (segments + 1,) limits the speed at
    the ends [mm/s]. On a segment that is passed at one speed, the times of holding it may overlap.
    """
    speed = reachable(fastest, 2.0 * rate * length, rate * half)
    entry, leave = speed[:-1], speed[1:]
    held = np.minimum(half, length / (entry + leave))
    room = length - (entry + leave) * held
    peak = np.minimum(most, np.sqrt(rate * room + 0.5 * (entry**2 + leave**2)))
    up, down = (peak - entry) / rate, (peak - leave) / rate
    rise, fall = 0.5 * (entry + peak) * up, 0.5 * (leave + peak) * down
    even = np.maximum(room - rise - fall, 0.0) / peak
    wait = rest + np.append(0.0, held[:-1] + held[1:])
    end = np.cumsum(np.stack([wait, up, even, down], axis=1))
    knots = np.append(0.0, np.cumsum(length))
    waits, begins = knots[:-1] - entry * np.append(0.0, held[:-1]), knots[:-1] + entry * held
    ways = np.stack([waits, begins, begins + rise, knots[1:] - leave * held - fall], axis=1)
    none = np.zeros_like(length)
    motion = Motion(
        np.append(0.0, end),
        np.append(ways, knots[-1]),
        np.append(np.stack([entry, entry, peak, peak], axis=1), 0.0),
        np.append(np.stack([none, rate, none, -rate], axis=1), 0.0),
        np.zeros(len(end) + 1),
        peak,
    )
    return motion.averaged(2.0 * half) if half else motion


def reachable(most: Floats, gain: Floats, held: Floats) -> Floats:
    """Return the speeds (segments + 1,) [mm/s] at the ends of segments, ``most`` where possible.

    The square of the speed changes by at most ``gain`` (segments,) on each segment, less if the
    speed at both ends is held for a time in which it could change by ``held`` (segments,).
    """
    squares, each = (most**2).tolist(), [*enumerate(zip(gain.tolist(), held.tolist(), strict=True))]
    for k, about in each:  # no faster than it can get there
        squares[k + 1] = min(squares[k + 1], _changed(squares[k], *about))
    for k, about in reversed(each):  # no faster than it can brake
        squares[k] = min(squares[k], _changed(squares[k + 1], *about))
    return np.sqrt(squares)


def _changed(square: float, gain: float, held: float) -> float:
    """Return the largest square of the speed at one end of a segment, by that at the other end."""
    if not held:
        return square + gain
    speed = sqrt(square)
    return max(speed, sqrt((speed - held) ** 2 + gain) - held) ** 2
