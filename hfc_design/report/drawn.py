"""How much of a motion is drawn, and the errors off a path and their units."""

import numpy as np

from hfc_design.core.numbers import Floats, Mask
from hfc_design.pictures.numbers import readable
from hfc_design.simulation.evaluating import AxisMotion, Evaluation

#: A diverged motion is not drawn once its error is this many times the largest reference.
RUNAWAY = 10.0


def path_errors(evaluation: Evaluation) -> list[tuple[str, float, str, Floats]]:
    """The same of the path of a program of any axes."""
    path = evaluation.contour
    if path is None or not path.any_axes:
        return []
    found = [("contour", *_easy(evaluation, path.unit), path.error)]
    return found if path.turned is None else [*found, ("orientation", 1.0, "deg", path.turned)]


def error_unit(evaluation: Evaluation, axis: AxisMotion) -> tuple[float, str]:
    """Factor and unit in which the errors of an axis, and of others alike, are easy to read."""
    return _easy(evaluation, axis.drive.units["error"])


def _easy(evaluation: Evaluation, unit: str) -> tuple[float, str]:
    """The same for all errors in a ``unit``: none is in mm beside others in µm."""
    drawn, path = slice(drawn_samples(evaluation)), evaluation.contour
    alike = [x.motion.error[drawn] for x in evaluation.axes if x.drive.units["error"] == unit]
    if path is not None and path.unit == unit:
        alike.append(path.error[drawn])
    return readable(unit, max((float(np.abs(error).max()) for error in alike), default=1.0))


def drawn_samples(evaluation: Evaluation) -> int:
    """Number of samples before a diverged motion runs away, at least one; else all."""
    if not evaluation.diverged:
        return len(evaluation.time)
    if evaluation.contour is not None:
        kept = np.isfinite(evaluation.contour.error)
    else:
        kept = np.logical_and.reduce([_in_hand(axis) for axis in evaluation.axes])
    return len(kept) if kept.all() else max(int(np.argmin(kept)), 1)


def _in_hand(axis: AxisMotion) -> Mask:
    """(steps,) whether an axis does not run away."""
    limit = RUNAWAY * np.abs(axis.reference).max() or RUNAWAY
    kept = np.isfinite(axis.motion.command)
    error: Floats = axis.motion.error
    for values in (error, axis.readings.get("deflection", error)):
        kept &= np.abs(values) < limit  # nan is not
    return kept
