"""Sampled inputs of the closed loop: references, loads, sensor noise, the path.

Positions, loads and commands count in the units of each axis' drive (``Drive.units``): rad, N m
and V for the C-axis; BLU and units of the converter for a feed drive.
"""

from typing import NamedTuple

import numpy as np
from pydantic import Field

from hfc_design.core.numbers import Floats, Series, State
from hfc_design.core.records import Positive, Record

MAX_SUBSTEPS = 1000


class AxisSamples(NamedTuple):
    """Inputs of one axis, one column per control sample."""

    reference: Series  # (steps,) set point of the control, in whole steps if it counts in steps
    reference_rate: Series  # (steps,)
    loads: Series  # (2 substeps + 1, steps) load at the times of the integrator
    noise: Series  # (encoders + readings, steps) added to what the sensors read
    target: Series  # (steps,) where the axis should be
    reference_acceleration: Series | None = None  # (steps,)
    sliding: Series = None  # (steps,) 1 where the reference has at least half its largest speed
    end: Series = None  # (steps,) place where the motion ends; in a program, the last turning point
    heading: Series = None  # (steps,) 1 or -1: direction of motion towards that place; 0: none


class PathFrame(NamedTuple):
    """Path of a machine at the commanded places, one column per control sample.

    The way along it has the unit of the linear axes, or of the rotary axes if only these move.
    """

    #: Derivative (steps,) of each axis by the way; a unit vector in the axes that the way is in.
    #: While only rotary axes move, linear axes keep the derivative of their last motion.
    tangent: tuple[Series, ...]
    curvature: Series  # (steps,) of arcs in the first two axes, left positive [1/unit]; else 0
    speed: Series  # (steps,) commanded along the path [unit/s]
    feed: Series  # (steps,) programmed there [unit/s]
    #: Derivative (steps,) of the tangent by the way [1/unit], None for a rotary axis; () if there
    #: cannot be other axes than X and Y.
    bend: tuple[Series | None, ...] = ()
    undisturbed: Series = None  # (steps,) 0 soon after an axis starts or reverses, else 1
    reversing: Series = None  # (steps,) 1 soon after a linear axis reverses, else 0
    only_turning: Series = None  # (steps,) 1 where rotary axes move alone, else 0


class PathSamples(NamedTuple):
    """Commanded places of a machine at each control sample; a row for each axis, in mm or deg."""

    position: Floats  # (axes, steps)
    velocity: Floats  # (axes, steps) [1/s]
    tangent: Floats  # (axes, steps) derivative by the way
    curvature: Floats  # (steps,) of arcs in the first two axes [1/mm], left positive; else 0
    distance: Floats  # (steps,) way so far [mm; deg where only rotary axes move]
    acceleration: Floats  # (axes, steps) [1/s2]; without impulses at jumps of the velocity


class Samples(NamedTuple):
    """All inputs of the loop, one column per control sample."""

    axes: tuple[AxisSamples, ...]
    path: PathFrame | None  # None for a machine that follows none
    settled: Series  # (steps,) 1 once the loop should have settled, before that 0
    sample_time: Series  # scalar [s]
    time: Series  # (steps,) [s]
    late: Series  # (steps,) 1 and 2 in the halves of the last quarter, before that 0
    start: tuple[State, ...]  # state of each axis before the first sample, in numbers
    copy_start: tuple[State, ...]  # the same for a slightly displaced copy, see ``unsettled``


class Simulation(Record):
    """Duration and time step of a motion; LL prints neither.

    With one step per millisecond, the motions of the published controllers on their ramps are exact
    to 2e-8 rad. Designs that are searched for the cutting load are more aggressive and may be
    chaotic: then the time step, or the last bit of a number, changes the motion by up to 2e-3 rad,
    and only a range of the fitness is meaningful.
    """

    duration_s: Positive = 10.0  # duration of a motion [s]
    sample_time_s: Positive = 0.001  # sample time of the control [s]
    substeps: int = Field(1, ge=1, le=MAX_SUBSTEPS)  # integration steps in a control sample

    @property
    def steps(self) -> int:
        """Number of control samples."""
        return round(self.duration_s / self.sample_time_s)

    @property
    def time(self) -> Floats:
        """Time (steps,) of each sample [s]."""
        return np.arange(self.steps, dtype=np.float64) * self.sample_time_s

    @property
    def moments(self) -> list[Floats]:
        """Times at which a load is needed [s]: arrays (steps,), 2 substeps + 1 of them."""
        shares = np.arange(2 * self.substeps + 1) / (2 * self.substeps)
        return [self.time + share * self.sample_time_s for share in shares]
