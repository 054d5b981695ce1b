"""What is read off the motion of an X-Y machine: contour error, axial errors, glitches."""

from typing import NamedTuple

import numpy as np

from hfc_design.core.shapes import Floats
from hfc_design.motion.contour import Glitch, glitches, nearest
from hfc_design.motion.trajectories import PathSamples, Trajectory


def contour_meanings(unit: str, command: str) -> dict[str, str]:
    """Meaning and unit of each metric, in the order of every table."""
    own = unit.replace(" ", "")
    return {
        f"rms_contour_error_{own}": f"root mean square of the contour error [{unit}]",
        f"max_contour_error_{own}": f"largest contour error [{unit}]",
        f"worst_glitch_{own}": f"largest contour error after an axis reverses [{unit}]",
        f"x_rms_error_{own}": f"root mean square of the tracking error of X [{unit}]",
        f"y_rms_error_{own}": f"root mean square of the tracking error of Y [{unit}]",
        f"x_max_error_{own}": f"largest tracking error of X [{unit}]",
        f"y_max_error_{own}": f"largest tracking error of Y [{unit}]",
        "peak_command": f"largest command of an axis [{command}]",
        "rms_command_change": "root mean square of the change of the command from sample to "
        f"sample, of the axis that chatters more [{command}]",
    }


class Contour(NamedTuple):
    """The path of an X-Y machine and how far off it was."""

    trajectory: Trajectory
    samples: PathSamples
    actual: Floats  # (2, steps) [mm]
    error: Floats  # (steps,) [unit]
    glitches: list[Glitch]  # errors in the unit
    unit: str  # of the positions
    millimetres: float  # of the unit


def contour(
    trajectory: Trajectory, time: Floats, positions: Floats, unit: str, millimetres: float
) -> Contour:
    """The contour error of ``positions`` (2, steps) [unit], counted from where the path starts."""
    samples = trajectory.samples(time)
    actual = positions * millimetres + samples.position[:, :1]
    error = nearest(trajectory, samples, actual).error / millimetres
    found = glitches(time, samples, error)
    return Contour(trajectory, samples, actual, error, found, unit, millimetres)


def during(found: Contour, time: Floats, part: slice) -> Contour:
    """Its errors and glitches in a part of ``time`` (steps,) [s]."""
    own = time[part]
    glitched = [glitch for glitch in found.glitches if own[0] <= glitch.time_s <= own[-1]]
    return found._replace(error=found.error[part], glitches=glitched)


def contour_metrics(
    meanings: dict[str, str], found: Contour, errors: Floats, commands: Floats
) -> dict[str, float | None]:
    """``contour_meanings`` in numbers; all None where the motion diverged.

    Args:
        meanings: of each metric.
        found: the path and its contour error.
        errors: (2, steps) tracking errors of both axes [unit].
        commands: (2, steps).
    """
    if not all(np.isfinite(part).all() for part in (found.error, errors, commands)):
        return dict.fromkeys(meanings)
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
    return dict(zip(meanings, numbers, strict=True))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
