"""Motion of a machine of any axes through a program, block by block within its limits."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import SAME, Floats, Mask
from hfc_design.motion import gcode
from hfc_design.motion.axis_path import AxisPath, Bounds, look_ahead, other_axis_fault, travel_fault
from hfc_design.motion.limits import AxisLimits, MovedAxis, bounds_of
from hfc_design.motion.paths import Motion
from hfc_design.motion.reversals import reversing, undisturbed
from hfc_design.motion.samples import AxisSamples, PathFrame, PathSamples


class Program(NamedTuple):
    """Motion of a machine through a program: the path, and the commanded places over time."""

    axes: tuple[MovedAxis, ...]
    path: AxisPath
    motion: Motion
    bounds: Bounds

    @property
    def duration_s(self) -> float:
        """Time at which the end is reached [s]; from then on the machine holds."""
        return self.motion.duration

    @property
    def start(self) -> dict[str, float]:
        """Initial place of each axis, in the unit of its drive."""
        each = zip(self.axes, self.path.start[:, 0].tolist(), strict=True)
        return {axis.name: place / axis.unit for axis, place in each}

    @property
    def linear(self) -> Mask:
        """True (axes,) for axes in mm."""
        return np.array([not axis.rotary for axis in self.axes])

    def cutting(self, way: Floats) -> Mask:
        """Return (points,) True where the block at the ``way`` has a feed, and is not a G0."""
        return np.isfinite(self.path.feed[self.path.block(way)])

    def samples(self, time: Floats) -> PathSamples:
        """Return the motion at ``time`` (steps,) [s], in mm and deg."""
        way, speed, change = self.motion.at(time)
        position, direction, bend = self.path.at(way)
        acceleration = change * direction + speed**2 * bend
        curvature = self.path.curvature[self.path.block(way)]
        return PathSamples(position, speed * direction, direction, curvature, way, acceleration)

    def axis_samples(self, time: Floats) -> tuple[list[AxisSamples], PathFrame]:
        """Return the samples of each axis in units (not yet steps) of its drive, and the path."""
        samples, units = self.samples(time), [axis.unit for axis in self.axes]
        rows = zip(samples.position, samples.velocity, samples.acceleration, units, strict=True)
        axes = [AxisSamples(x / u, v / u, None, None, x / u, a / u) for x, v, a, u in rows]
        way, speed, _ = self.motion.at(time)
        block = self.path.block(way)
        feed = np.where(np.isinf(self.path.feed), self.motion.peak, self.path.feed)[block]
        unit = next((axis.unit for axis in self.axes if not axis.rotary), units[0])
        tip = self.path.tip_at(way)
        tangents = np.where(self.linear[:, None], tip.direction, samples.tangent)
        each = zip(self.axes, tip.bend * unit, strict=True)
        bends = tuple(None if axis.rotary else bend for axis, bend in each)
        marks = undisturbed(time, samples.velocity), reversing(time, samples.velocity[self.linear])
        only_turning = ~self.path.linear[block]
        return axes, PathFrame(
            tuple(t * unit / u for t, u in zip(tangents, units, strict=True)),
            samples.curvature,
            speed / unit,
            feed / unit,
            bends,
            *(np.where(mark, 1.0, 0.0) for mark in (*marks, only_turning)),
        )


def program(
    blocks: Sequence[gcode.Block],
    axes: tuple[MovedAxis, ...],
    limits: Mapping[str, AxisLimits],
    cycle: float,
) -> Program:
    """Return the motion through ``blocks``, interpolated every ``cycle`` [s], of these ``axes``.

    Raises:
        ValueError: there are no blocks, they move another axis, or an axis leaves its travel.
    """
    names = [axis.name for axis in axes]
    if not blocks:
        raise ValueError(f"has no motion in {', '.join(names)}")
    if fault := other_axis_fault(blocks, names):
        raise ValueError(fault)
    path = AxisPath.of(blocks, names)
    if fault := travel_fault(path, names, [limits[name].travel for name in names]):
        raise ValueError(fault)
    bounds = bounds_of(limits, axes)
    return Program(axes, path, look_ahead(path, bounds, cycle), bounds)


def top_speed_fault(program: Program) -> str | None:
    """Return a line if a program needs an axis to exceed the top speed of its drive, else None."""
    wanted = program.path.fastest * program.motion.peak
    reached = np.array([[axis.top_speed] for axis in program.axes])
    if not (wanted > reached * (1.0 + SAME)).any():
        return None
    k, block = map(int, np.unravel_index(int((wanted / reached).argmax()), wanted.shape))
    axis, unit = program.axes[k], "deg" if program.axes[k].rotary else "mm"
    return (
        f"line {program.path.lines[block]}: needs {axis.name.upper()} at "
        f"{60.0 * wanted[k, block]:.5g} {unit}/min, but its drive reaches "
        f"{60.0 * axis.top_speed:.5g} {unit}/min; set limits.{axis.name}.velocity_per_min"
    )
