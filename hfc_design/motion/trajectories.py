"""References in the X-Y plane, as a user writes them, and their samples.

The machine starts at rest where the path starts: a circle at (R, 0) about the origin, a line at
the origin, a polyline at its first point, a G-code program at X0 Y0.
"""

from abc import abstractmethod
from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import cos, dist, pi, radians, sin
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

import numpy as np
from pydantic import AfterValidator, Field

from hfc_design.core.numbers import Floats
from hfc_design.core.records import Finite, Positive, Record, readable_by
from hfc_design.motion import gcode
from hfc_design.motion.paths import SAME_PLACE, Motion, Path, Segment, arc, line, motion
from hfc_design.motion.samples import AxisSamples, PathFrame


class PathSamples(NamedTuple):
    """A trajectory at each control sample."""

    position: Floats  # (2, steps) [mm]
    velocity: Floats  # (2, steps) [mm/s]
    tangent: Floats  # (2, steps) unit vector in the direction of motion
    curvature: Floats  # (steps,) [1/mm], positive to the left
    distance: Floats  # (steps,) length of the path so far [mm]
    acceleration: Floats  # (2, steps) [mm/s2]; the jump at a start without a limit is left out


class Trajectory(Record):
    """A path and a limit of acceleration; each kind has its own path."""

    if TYPE_CHECKING:  # each one's own field, which stands where it always has in a file
        kind: str
    #: None: full feed at once, corners included, as in the papers' simulations.
    acceleration_mm_s2: Positive | None = None

    @abstractmethod
    def _segments(self) -> Iterable[Segment]:
        """Where it goes, at least one of them."""

    @property
    def path(self) -> Path:
        """Where it goes."""
        return Path.of(self._segments())

    @property
    def motion(self) -> Motion:
        """When it is where."""
        return motion(self.path, self.acceleration_mm_s2)

    @property
    def duration_s(self) -> float:
        """When the end is reached [s]; from then on it holds."""
        return self.motion.duration

    def samples(self, time: Floats) -> PathSamples:
        """The trajectory at ``time`` (steps,) [s]."""
        path, along = self.path, self.motion
        way, speed, change = along.at(time)
        position, tangent, curvature = path.at(way)
        left = np.stack([-tangent[1], tangent[0]])
        bent = change * tangent + curvature * speed**2 * left
        return PathSamples(position, speed * tangent, tangent, curvature, way, bent)

    def axis_samples(self, time: Floats, unit: float | None) -> tuple[list[AxisSamples], PathFrame]:
        """Both axes, not yet in steps of their drives, and the path.

        The machine starts where it stands; a ``unit`` of the positions has so many mm.
        """
        assert unit is not None  # the scenario has been checked
        way = self.samples(time)
        target = (way.position - way.position[:, :1]) / unit
        each = zip(target, way.velocity / unit, way.acceleration / unit, strict=True)
        axes = [AxisSamples(place, rate, None, None, place, change) for place, rate, change in each]
        return axes, PathFrame(way.tangent[0], way.tangent[1], way.curvature * unit)


class Circle(Trajectory):
    """About the origin from (radius, 0), any number of cycles or part of one."""

    kind: Literal["circle"] = "circle"
    radius_mm: Positive
    feed_mm_min: Positive
    direction: Literal["ccw", "cw"] = "ccw"
    cycles: Positive = 1.0

    def _segments(self) -> Iterable[Segment]:
        turns = self.cycles if self.direction == "ccw" else -self.cycles
        start, centre = (self.radius_mm, 0.0), (0.0, 0.0)
        return [arc(start, centre, 2 * pi * turns, self.feed_mm_min)]


class Line(Trajectory):
    """From the origin straight on, at an angle to the X axis."""

    kind: Literal["line"] = "line"
    length_mm: Positive
    angle_deg: Finite
    feed_mm_min: Positive

    def _segments(self) -> Iterable[Segment]:
        angle = radians(self.angle_deg)
        end = (self.length_mm * cos(angle), self.length_mm * sin(angle))
        return [line((0.0, 0.0), end, self.feed_mm_min)]


Vertex = tuple[Finite, Finite]


def _distinct(points: tuple[Vertex, ...]) -> tuple[Vertex, ...]:
    for k, (a, b) in enumerate(pairwise(points)):
        if dist(a, b) < SAME_PLACE:
            raise ValueError(f"points {k + 1} and {k + 2} are the same")
    return points


class Polyline(Trajectory):
    """Straight from point to point, with a stop at each corner."""

    kind: Literal["polyline"] = "polyline"
    points_mm: Annotated[tuple[Vertex, ...], Field(min_length=2), AfterValidator(_distinct)]
    feed_mm_min: Positive
    acceleration_mm_s2: Positive = 100.0

    def _segments(self) -> Iterable[Segment]:
        return (line(a, b, self.feed_mm_min) for a, b in pairwise(self.points_mm))


PROGRAM = readable_by(lambda file: gcode.segments(gcode.text_of(file), rapid=1500.0))


class GCode(Trajectory):
    """The X-Y motion of a G-code program (``gcode``)."""

    kind: Literal["gcode"] = "gcode"
    file: Annotated[FilePath, PROGRAM]
    rapid_mm_min: Positive = 1500.0  # of G0
    acceleration_mm_s2: Positive = 100.0

    def _segments(self) -> Iterable[Segment]:
        return gcode.read(self.file, self.rapid_mm_min)


PathReference = Annotated[Circle | Line | Polyline | GCode, Field(discriminator="kind")]


def speed_fault(trajectory: Trajectory, drive_speeds: Sequence[float]) -> str | None:
    """A line if a trajectory asks an axis for more than its drive's speed [mm/s].

    On a segment that is too short for its feed, the speed that it does reach counts. The line
    names the feed and the one allowed.
    """
    path = trajectory.path
    share = path.largest_components()  # (2, segments)
    wanted = share * trajectory.motion.peak
    reached = np.broadcast_to(np.reshape(drive_speeds, (2, 1)), wanted.shape)
    too_fast = wanted > reached
    if not too_fast.any():
        return None
    none = np.where(too_fast, np.inf, 0.0)  # of a drive that friction keeps at rest
    excess = np.divide(wanted, reached, out=none, where=too_fast & (reached > 0.0))
    axis, k = map(int, np.unravel_index(int(excess.argmax()), excess.shape))
    allowed = np.floor(60.0 * drive_speeds[axis] / share[axis, k])
    return (
        f"a feed of {path.feed[k]:g} mm/min asks the {'XY'[axis]} axis for "
        f"{wanted[axis, k]:.4g} mm/s, but its drive reaches {drive_speeds[axis]:.4g} mm/s; "
        f"the largest feed here is {allowed:g} mm/min"
    )
