"""Metrics that are computed from recorded motions and are not sums over samples."""

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
    """Time from which the error stays below ``SETTLED`` of its maximum [s]; None: never."""
    error = np.abs(axis.error)
    outside = np.flatnonzero(error > SETTLED * error.max())
    settled = 0 if len(outside) == 0 else outside[-1] + 1
    return float(axis.time[settled]) if settled < len(axis.time) else None


def stands(axis: AxisRecord) -> Mask:
    """(settled samples,) whether the axis stands still although it should move."""
    return np.asarray(is_stuck(axis.velocity, axis.reference_rate)[axis.settled])


def stick_events(axis: AxisRecord) -> float:
    """Number of times that the axis came to a standstill."""
    still = stands(axis)
    return float(np.count_nonzero(still & ~np.concatenate([[False], still[:-1]])))


def overshoot(reference: Floats, position: Floats) -> float:
    """Distance of ``position`` beyond a place where the ``reference`` (steps,) turns back or ends.

    It is measured after a reversal until the next one; it is 0 if the axis never goes beyond, and
    if the reference does not move. An axis that was beyond the place all along, because friction
    holds it or it lags, has not overshot: its distance counts from the place nearest to the
    reversal since the reference set out for it.
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
    """Largest magnitude."""
    return float(np.abs(errors).max())


def cutting(off: Contour) -> Floats:
    """Contour error without rapids."""
    assert isinstance(off.trajectory, Program)
    return off.error[off.trajectory.cutting(off.samples.distance)]


def after(glitches: Sequence[Glitch]) -> Floats:
    """(glitches,) errors after each of them."""
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
