"""What is read off the motion of an X-Y machine: contour error, axial errors, glitches."""

from typing import NamedTuple

import numpy as np

from hfc_design.motion.contour import Glitch, contour_error, glitches
from hfc_design.motion.shapes import Floats
from hfc_design.motion.trajectories import PathSamples, Trajectory

#: Unit and meaning of each metric, in the order of every table.
CONTOUR_METRICS = {
    "rms_contour_error_BLU": "root mean square of the contour error [BLU]",
    "max_contour_error_BLU": "largest contour error [BLU]",
    "worst_glitch_BLU": "largest contour error after an axis reverses [BLU]",
    "x_rms_error_BLU": "root mean square of the tracking error of X [BLU]",
    "y_rms_error_BLU": "root mean square of the tracking error of Y [BLU]",
    "x_max_error_BLU": "largest tracking error of X [BLU]",
    "y_max_error_BLU": "largest tracking error of Y [BLU]",
    "peak_command": "largest command of an axis [unit]",
    "rms_command_change": "root mean square of the change of the command from sample to sample, "
    "of the axis that chatters more [unit]",
}


class Contour(NamedTuple):
    """The path of an X-Y machine and how far off it was."""

    trajectory: Trajectory
    samples: PathSamples
    actual: Floats  # (2, steps) [mm]
    error: Floats  # (steps,) [BLU]
    glitches: list[Glitch]  # errors in BLU


def contour(trajectory: Trajectory, time: Floats, positions: Floats, blu: float) -> Contour:
    """The contour error of ``positions`` (2, steps) [BLU], counted from where the path starts."""
    samples = trajectory.samples(time)
    actual = positions * blu + samples.position[:, :1]
    error = contour_error(trajectory, samples, actual) / blu
    return Contour(trajectory, samples, actual, error, glitches(time, samples, error))


def during(found: Contour, time: Floats, part: slice) -> Contour:
    """Its errors and glitches in a part of ``time`` (steps,) [s]."""
    own = time[part]
    glitched = [glitch for glitch in found.glitches if own[0] <= glitch.time_s <= own[-1]]
    return found._replace(error=found.error[part], glitches=glitched)


def contour_metrics(found: Contour, errors: Floats, commands: Floats) -> dict[str, float | None]:
    """``CONTOUR_METRICS``; all None where the motion diverged.

    Args:
        found: the path and its contour error.
        errors: (2, steps) tracking errors of both axes [BLU].
        commands: (2, steps) [unit].
    """
    if not all(np.isfinite(part).all() for part in (found.error, errors, commands)):
        return dict.fromkeys(CONTOUR_METRICS)
    values = (
        _rms(found.error),
        np.abs(found.error).max(),
        max((abs(glitch.error) for glitch in found.glitches), default=None),
        *(_rms(error) for error in errors),
        *(np.abs(error).max() for error in errors),
        np.abs(commands).max(),
        max(_rms(change) for change in np.diff(commands)) if commands.shape[1] > 1 else None,
    )
    numbers = (None if value is None else float(value) for value in values)
    return dict(zip(CONTOUR_METRICS, numbers, strict=True))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
