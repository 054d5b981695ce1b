"""Metrics that are computed from recorded motions and are not sums over samples."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from hfc_design.core.numbers import Floats, Mask
from hfc_design.motion.circularity import full_turns
from hfc_design.motion.contour import Contour
from hfc_design.motion.program import Program
from hfc_design.motion.reversals import Glitch, turns
from hfc_design.motion.trajectories import Circle
from hfc_design.objectives.metric import AxisRecord, MotionRecord
from hfc_design.objectives.stick_share import is_stuck

#: The loop has settled once its error stays below this share of its maximum.
SETTLED = 0.1


def settling_time(axis: AxisRecord) -> float | None:
    """Return the time from which the error stays within ``SETTLED`` of its maximum [s], or None."""
    error = np.abs(axis.error)
    outside = np.flatnonzero(error > SETTLED * error.max())
    settled = 0 if len(outside) == 0 else outside[-1] + 1
    return float(axis.time[settled]) if settled < len(axis.time) else None


def stands(axis: AxisRecord) -> Mask:
    """Return the mask (settled samples,): the axis stands still although it should move."""
    return np.asarray(is_stuck(axis.velocity, axis.reference_rate)[axis.settled])


def stick_events(axis: AxisRecord) -> float:
    """Return how often the axis came to a standstill once settled, although it should move."""
    still = stands(axis)
    return float(np.count_nonzero(still & ~np.concatenate([[False], still[:-1]])))


def overshoot(reference: Floats, position: Floats) -> float:
    """Return how far ``position`` goes beyond points where ``reference`` (steps,) turns or ends.

    It is measured from one turning point to the next; it is 0 if the axis never goes beyond, or if
    the reference does not move. An axis that was beyond the point all along, because friction holds
    it or because it lags, has not overshot: then the distance counts from the position nearest to
    the point that the axis has had since the reference set out for the point.
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
    """Return the largest magnitude."""
    return float(np.abs(errors).max())


def cutting(off: Contour) -> Floats:
    """Return the contour error (samples,) without the samples of rapids."""
    assert isinstance(off.trajectory, Program)
    return off.error[off.trajectory.cutting(off.samples.distance)]


def circular(reduce_turns: Callable[..., Any], directions: int, off: Contour) -> Floats | None:
    """Return a function of the full turns of a circle and its radius; None: few, or no motion."""
    assert isinstance(off.trajectory, Circle)
    radius = off.trajectory.radius_mm
    parts = full_turns(off.samples.position, radius)[0].values()
    turns = [off.actual[:, part] / off.millimetres for part in parts]
    if len(turns) < directions or not all(np.ptp(turn, axis=1).any() for turn in turns):
        return None
    return np.asarray(reduce_turns(turns, radius / off.millimetres))


def after(glitches: Sequence[Glitch]) -> Floats:
    """Return the errors (glitches,) after the reversals of axes."""
    return np.array([glitch.error for glitch in glitches])


def velocity_share(motion: MotionRecord) -> float:
    """Return the largest velocity of an axis of a program, as a share of the limit of the axis."""
    assert motion.contour is not None
    program = motion.contour.trajectory
    assert isinstance(program, Program)
    fastest = np.array([np.abs(axis.velocity).max() for axis in motion.axes])
    units = np.array([axis.unit for axis in program.axes])
    return float((fastest * units / program.bounds.velocity).max())


def limited(motion: MotionRecord) -> float:
    """Return the share of the samples at which the command of any axis is at a limit."""
    at_limit = [(x.command <= x.limits[0]) | (x.command >= x.limits[1]) for x in motion.axes]
    return float(np.logical_or.reduce(at_limit).mean())
