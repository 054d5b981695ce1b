"""What metrics compute from recorded motions, where no sum over samples gives it."""

from collections.abc import Sequence

import numpy as np

from hfc_design.core.numbers import Floats, Mask
from hfc_design.motion.contour import Contour
from hfc_design.motion.program import Program
from hfc_design.motion.reversals import Glitch, turns
from hfc_design.objectives.metric import AxisRecord, MotionRecord
from hfc_design.objectives.stick_share import is_stuck

#: The loop has settled once its error stays below this share of its maximum.
SETTLED = 0.1


def settling_time(axis: AxisRecord) -> float | None:
    """When the error has come below ``SETTLED`` of its maximum for good [s]; None: never."""
    error = np.abs(axis.error)
    outside = np.flatnonzero(error > SETTLED * error.max())
    settled = 0 if len(outside) == 0 else outside[-1] + 1
    return float(axis.time[settled]) if settled < len(axis.time) else None


def stands(axis: AxisRecord) -> Mask:
    """(settled samples,) whether the axis stands that should move."""
    return np.asarray(is_stuck(axis.velocity, axis.reference_rate)[axis.settled])


def stick_events(axis: AxisRecord) -> float:
    """How often it began to stand."""
    still = stands(axis)
    return float(np.count_nonzero(still & ~np.concatenate([[False], still[:-1]])))


def overshoot(reference: Floats, position: Floats) -> float:
    """How far ``position`` goes beyond where the ``reference`` (steps,) turns back or ends.

    Beyond a reversal until the next one; 0 where it never does, and where nothing is to move. An
    axis that was beyond the place all along, as friction holds it or it lags, has not gone there:
    it counts from the place nearest to the reversal since the reference set out for it.
    """
    change = np.diff(reference)
    places = [0, *turns(reference), len(reference)]
    farthest = 0.0
    for before, place, until in zip(places, places[1:], places[2:], strict=False):
        forwards = np.sign(change[place - 1])
        travel = forwards * position[before:until]
        since = np.maximum(forwards * reference[place], np.minimum.accumulate(travel))
        farthest = max(farthest, float((travel - since)[place - before :].max(initial=0.0)))
    return farthest


def largest(errors: Floats) -> float:
    """In magnitude."""
    return float(np.abs(errors).max())


def cutting(off: Contour) -> Floats:
    """The contour error without rapids."""
    assert isinstance(off.trajectory, Program)
    return off.error[off.trajectory.cutting(off.samples.distance)]


def after(glitches: Sequence[Glitch]) -> Floats:
    """(glitches,) their errors."""
    return np.array([glitch.error for glitch in glitches])


def velocity_share(motion: MotionRecord) -> float:
    """Largest velocity of an axis of a program, as a share of its limit."""
    assert motion.contour is not None
    program = motion.contour.trajectory
    assert isinstance(program, Program)
    fastest = np.array([np.abs(axis.velocity).max() for axis in motion.axes])
    units = np.array([axis.unit for axis in program.axes])
    return float((fastest * units / program.bounds.velocity).max())


def limited(motion: MotionRecord) -> float:
    """Share of the samples at which the command of an axis is at its limit."""
    at_limit = [(x.command <= x.limits[0]) | (x.command >= x.limits[1]) for x in motion.axes]
    return float(np.logical_or.reduce(at_limit).mean())
