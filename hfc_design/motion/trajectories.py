"""References of several axes, as a user writes them, and their samples in the X-Y plane.

The machine starts at rest where the path starts: a circle at (R, 0) about the origin, a line at
the origin, a polyline at its first point, a G-code program at X0 Y0. A program with limits of each
axis can move any axes (see ``program``), and starts where the reference says.
"""

from abc import abstractmethod
from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import pairwise
from math import cos, dist, pi, radians, sin
from operator import not_
from typing import TYPE_CHECKING, Annotated, Literal, Self

import numpy as np
from pydantic import (
    AfterValidator,
    Field,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)

from hfc_design.core.embedded_files import WRITTEN, readable_by
from hfc_design.core.numbers import SAME, Floats, floored
from hfc_design.core.records import Finite, Label, Positive, Record
from hfc_design.core.texts import as_user_error
from hfc_design.motion import gcode
from hfc_design.motion.limits import AxisLimits, Limits, MovedAxis
from hfc_design.motion.paths import SAME_PLACE, Motion, Path, Segment, arc, line, motion
from hfc_design.motion.program import Program, program
from hfc_design.motion.reversals import reversing, undisturbed
from hfc_design.motion.samples import AxisSamples, PathFrame, PathSamples


class Trajectory(Record):
    """Path with a limit of acceleration; each subclass is a kind of path."""

    if TYPE_CHECKING:  # a field of each subclass, so that its place in a file stays the same
        kind: str
    #: largest acceleration along the path [mm/s2]; left out: unlimited, also at corners, as in the
    #: simulations of the papers
    acceleration_mm_s2: Positive | None = None
    #: largest jerk along the path, needs an acceleration [mm/s3]; left out: unlimited
    jerk_mm_s3: Positive | None = Field(None, exclude_if=not_)

    @abstractmethod
    def _segments(self) -> Iterable[Segment]:
        """Return the segments of the path, at least one."""

    def on(self, axes: tuple[MovedAxis, ...], cycle: float) -> "Trajectory | Program":
        """Return the motion of a machine with these ``axes``, interpolated every ``cycle`` [s]."""
        return self

    @property
    def path(self) -> Path:
        """Path of the trajectory, without times."""
        return Path.of(self._segments())

    @property
    def motion(self) -> Motion:
        """Motion along the path, over time."""
        if self.jerk_mm_s3 and not self.acceleration_mm_s2:
            raise ValueError("reference.jerk_mm_s3: needs reference.acceleration_mm_s2")
        return motion(self.path, self.acceleration_mm_s2, self.jerk_mm_s3)

    @property
    def duration_s(self) -> float:
        """Time at which the end is reached [s]; from then on the machine holds."""
        return self.motion.duration

    def samples(self, time: Floats) -> PathSamples:
        """Return the trajectory at ``time`` (steps,) [s]."""
        path, along = self.path, self.motion
        way, speed, change = along.at(time)
        position, tangent, curvature = path.at(way)
        left = np.stack([-tangent[1], tangent[0]])
        bent = change * tangent + curvature * speed**2 * left
        return PathSamples(position, speed * tangent, tangent, curvature, way, bent)

    def axis_samples(self, time: Floats, unit: float | None) -> tuple[list[AxisSamples], PathFrame]:
        """Return the samples of both axes in units (not yet steps) of their drives, and the path.

        Positions count from the start of the path. ``unit`` is the length of their unit [mm].
        """
        assert unit is not None  # the scenario has been checked
        way = self.samples(time)
        target = (way.position - way.position[:, :1]) / unit
        each = zip(target, way.velocity / unit, way.acceleration / unit, strict=True)
        axes = [AxisSamples(place, rate, None, None, place, change) for place, rate, change in each]
        path, along = self.path, self.motion
        speed = along.at(time)[1] / unit
        feed = path.feed[path.segment(way.distance)] / 60.0 / unit
        marks = undisturbed(time, way.velocity), reversing(time, way.velocity)
        quiet, turning = (np.where(mark, 1.0, 0.0) for mark in marks)
        return axes, PathFrame(
            tuple(way.tangent), way.curvature * unit, speed, feed, (), quiet, turning
        )


class Circle(Trajectory):
    """Circle about the origin, starting at (radius, 0), any number of cycles or part of one."""

    kind: Literal["circle"] = "circle"
    radius_mm: Positive  # radius about the origin, starting at (radius, 0) [mm]
    feed_mm_min: Positive  # feed along the path [mm/min]
    #: ccw: counter-clockwise; cw: clockwise; both: all cycles counter-clockwise, then back
    direction: Literal["ccw", "cw", "both"] = "ccw"
    cycles: Positive = 1.0  # number of cycles in a direction, also fractions [1]

    def _segments(self) -> Iterable[Segment]:
        angle = 2 * pi * self.cycles
        swept = {"ccw": [angle], "cw": [-angle], "both": [angle, -angle]}[self.direction]
        for begin, change in zip((0.0, angle), swept, strict=False):
            start = (self.radius_mm * cos(begin), self.radius_mm * sin(begin))
            yield arc(start, (0.0, 0.0), change, self.feed_mm_min)


class Line(Trajectory):
    """Straight line from the origin, at an angle to the X axis."""

    kind: Literal["line"] = "line"
    length_mm: Positive  # length from the origin [mm]
    angle_deg: Finite  # angle to the X axis [deg]
    feed_mm_min: Positive  # feed along the path [mm/min]

    def _segments(self) -> Iterable[Segment]:
        angle = radians(self.angle_deg)
        shares = cos(angle), sin(angle)  # at 90 deg X must not move at all
        x, y = (self.length_mm * share * (abs(share) > SAME) for share in shares)
        return [line((0.0, 0.0), (x, y), self.feed_mm_min)]


Vertex = tuple[Finite, Finite]


def _distinct(points: tuple[Vertex, ...]) -> tuple[Vertex, ...]:
    for k, (a, b) in enumerate(pairwise(points)):
        if dist(a, b) < SAME_PLACE:
            raise ValueError(f"points {k + 1} and {k + 2} are the same")
    return points


class Polyline(Trajectory):
    """Straight lines from point to point, with a stop at each corner."""

    kind: Literal["polyline"] = "polyline"
    #: [X, Y] of each point, with a stop at each [mm]
    points_mm: Annotated[tuple[Vertex, ...], Field(min_length=2), AfterValidator(_distinct)]
    feed_mm_min: Positive  # feed along the path [mm/min]
    acceleration_mm_s2: Positive = 100.0  # largest acceleration along the path [mm/s2]

    def _segments(self) -> Iterable[Segment]:
        return (line(a, b, self.feed_mm_min) for a, b in pairwise(self.points_mm))


PROGRAM = readable_by(lambda file: gcode.blocks(gcode.text_of(file)))
#: Keys that only a program in X-Y alone may have.
PLANAR = ("rapid_mm_min", "acceleration_mm_s2", "jerk_mm_s3")


class GCode(Trajectory):
    """Motion of a G-code program (``gcode``): in X-Y, or with ``limits`` in any axes."""

    kind: Literal["gcode"] = "gcode"
    file: Annotated[WRITTEN, PROGRAM]  # program in G-code
    rapid_mm_min: Positive = 1500.0  # speed of G0, for a program in X-Y [mm/min]
    #: largest acceleration along the path, for a program in X-Y [mm/s2]
    acceleration_mm_s2: Positive = 100.0
    #: initial position of each axis [mm or deg]; left out: 0; needs limits
    start: dict[Label, Finite] = Field({}, exclude_if=not_)
    #: limits of each axis by its name; with them a program may move any axes
    limits: Limits = Field({}, exclude_if=not_)

    @model_validator(mode="after")
    def _planar_or_not(self) -> Self:
        if self.limits:
            for key in sorted(self.model_fields_set & {*PLANAR}):
                raise ValueError(
                    f"{key}: must be left out beside reference.limits, which has it for each axis"
                )
        elif self.start:
            raise ValueError("start: needs limits; without them a program starts at X0 Y0")
        return self

    @model_serializer(mode="wrap")
    def _own_keys(self, whole: SerializerFunctionWrapHandler) -> dict[str, object]:
        data: dict[str, object] = whole(self)
        return {key: x for key, x in data.items() if not (self.limits and key in PLANAR)}

    def _segments(self) -> Iterable[Segment]:
        return gcode.read(self.file, self.rapid_mm_min)

    def on(self, axes: tuple[MovedAxis, ...], cycle: float) -> Trajectory | Program:
        """Return itself in X-Y, else a Program; UserError, ValueError: these axes cannot run it."""
        planar = len(axes) == 2 and not any(axis.rotary for axis in axes)
        if planar and not self.limits:
            return self
        if fault := self._fault(axes):
            raise ValueError(fault)
        start = tuple(self.start.get(letter.lower(), 0.0) for letter in gcode.AXES)
        with as_user_error(self.file):
            return _planned(
                gcode.text_of(self.file), start, axes, tuple(self.limits.items()), cycle
            )

    def _fault(self, axes: tuple[MovedAxis, ...]) -> str | None:
        """Return why these axes cannot run any program with these settings; None: they can."""
        names, letters = [axis.name for axis in axes], [*gcode.AXES.lower()]
        for key, named in (("limits", self.limits), ("start", self.start)):
            if unknown := next((name for name in named if name not in names), None):
                return f"{key}.{unknown}: unknown axis; the machine has {', '.join(names)}"
        for name, unit, rotary, _ in axes:
            if name not in letters:
                return f"kind = 'gcode': moves the axes {', '.join(letters)} (got {name!r})"
            if not unit or rotary != (name in letters[3:]):
                kind = "lengths" if name in letters[:3] else "angles"
                return f"kind = 'gcode': the drive of axis {name} does not count {kind}"
            if name not in self.limits:
                return f"limits.{name}: is missing; such a program needs the limits of every axis"
        if len({unit for _, unit, rotary, _ in axes if not rotary}) > 1:
            return "kind = 'gcode': the axes of a path must count in the same length"
        return None


@lru_cache(maxsize=8)
def _planned(
    text: str,
    start: gcode.Places,
    axes: tuple[MovedAxis, ...],
    limits: tuple[tuple[str, AxisLimits], ...],
    cycle: float,
) -> Program:
    return program(gcode.blocks(text, start), axes, dict(limits), cycle)


PathReference = Annotated[Circle | Line | Polyline | GCode, Field(discriminator="kind")]


def speed_fault(trajectory: Trajectory, drive_speeds: Sequence[float]) -> str | None:
    """Return a line if a trajectory needs X or Y to exceed its drive's speed [mm/s], else None.

    On a segment that is too short for its feed, the speed that is reached there counts. The line
    names the feed and the largest feed that is possible.
    """
    path = trajectory.path
    share = path.largest_components()  # (2, segments)
    wanted = share * trajectory.motion.peak
    reached = np.broadcast_to(np.reshape(drive_speeds, (2, 1)), wanted.shape)
    too_fast = wanted > reached * (1.0 + SAME)
    if not too_fast.any():
        return None
    none = np.where(too_fast, np.inf, 0.0)  # for a drive that friction keeps at rest
    excess = np.divide(wanted, reached, out=none, where=too_fast & (reached > 0.0))
    axis, k = map(int, np.unravel_index(int(excess.argmax()), excess.shape))
    allowed = floored(60.0 * drive_speeds[axis] / share[axis, k])
    return (
        f"a feed of {path.feed[k]:g} mm/min needs {'XY'[axis]} at "
        f"{wanted[axis, k]:.4g} mm/s, but its drive reaches {drive_speeds[axis]:.4g} "
        f"mm/s; the largest feed here is {allowed:g} mm/min"
    )
