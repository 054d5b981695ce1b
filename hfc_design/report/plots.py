"""What a design does: its response, the contour of its path, or both; how much of it is drawn."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from hfc_design.core.numbers import Floats, Mask
from hfc_design.pictures.curves import thinned
from hfc_design.pictures.figure import OWN, above, finish, framed
from hfc_design.pictures.numbers import readable
from hfc_design.report.contours import contour
from hfc_design.simulation.evaluating import AxisMotion, Evaluation

Scale = tuple[float, str]  # factor and unit
Curve = tuple[str, Floats, Floats | None]  # label, values, the reference of a position
#: What a small picture leaves out.
SKIPPED = "deflection", "load"
#: How small panels are spaced.
SMALL: dict[str, Any] = {"hspace": 0.6, "wspace": 0.4}


def motion(evaluation: Evaluation, title: str) -> Figure:
    """What a design did: ``contour`` in X-Y, ``program`` in any axes, else ``response``."""
    path = evaluation.contour
    if path is None:
        return response(evaluation, title)
    if evaluation.diverged:
        title += " (diverged)"
    if path.any_axes:
        return program(evaluation, title)
    return contour(path, evaluation.time, title)


def response(evaluation: Evaluation, title: str) -> Figure:
    """Position, tracking error, spring deflection, command and load against time.

    The C-axis as LL fig. 6 and 7, c to f; of several axes one below the other. There is no panel
    of a deflection that the drive has not, or of a load where there is none. A diverged motion
    ends where it runs away.
    """
    drawn = slice(drawn_samples(evaluation))
    found = [curve for axis in evaluation.axes for curve in curves(evaluation, axis, drawn)]
    figure = framed(1.3 * len(found) + 1.0, top=0.4)
    panels = figure.subplots(len(found), 1, sharex=True, gridspec_kw={"hspace": 0.12})
    for axes, (label, values, reference) in zip(panels, found, strict=True):
        angular = label.endswith("[rad]")
        curve = thinned(evaluation.time[drawn], values)
        axes.plot(*curve, color=OWN, lw=1.2, label="spindle" if angular else "axis")
        finish(axes, label)
        if reference is not None:
            line = thinned(evaluation.time, reference)
            axes.plot(*line, color="black", lw=1, ls="--", label="reference")
            axes.legend(fontsize=9, frameon=False)
    panels[0].margins(x=0)
    panels[-1].set_xlabel("time [s]")
    if evaluation.diverged:
        title += f" (diverged at {evaluation.time[drawn][-1]:.3g} s)"
    panels[0].set_title(title, fontsize=11)
    return figure


def curves(
    evaluation: Evaluation,
    axis: AxisMotion,
    drawn: slice,
    of_error: tuple[float, str] | None = None,
) -> list[Curve]:
    """Label, values and, of the position, the reference of each panel of an axis.

    ``of_error`` is the factor and the unit of its error, else those in which it is easy to read.
    """
    units, drive = axis.drive.units, axis.drive
    name = f"{axis.name} " if len(evaluation.axes) > 1 else ""
    factor, unit = of_error or error_unit(evaluation, axis)
    error = axis.motion.error[drawn]
    called = "angle" if units["error"] == "rad" else "position"
    found: list[Curve] = [
        (f"{name}{called} [{units['error']}]", axis.reference[drawn] - error, axis.reference),
        (f"{name}error [{unit}]", factor * error, None),
    ]
    if "deflection" in axis.readings:
        found.append((f"{name}deflection [mrad]", 1e3 * axis.readings["deflection"][drawn], None))
    label = f"{name}{drive.command_name} [{units['command']}]"
    found.append((label, axis.motion.command[drawn], None))
    if np.any(axis.load):
        found.append((f"{name}load [{units['load']}]", axis.load[drawn], None))
    return found


def skipped(label: str) -> bool:
    """Whether there is no room for a curve."""
    return any(word in SKIPPED for word in label.split())


def program(evaluation: Evaluation, title: str) -> Figure:
    """How far a machine is off the path; then of every axis position, error and command, small."""
    errors, each = path_errors(evaluation), evaluation.axes
    drawn = slice(drawn_samples(evaluation))
    figure = framed(1.4 * (len(errors) + len(each)) + 1.1, top=0.75)
    grid = figure.add_gridspec(len(errors) + len(each), 3, **SMALL)
    for k, (name, factor, unit, error) in enumerate(errors):
        curve: Curve = (f"{name} error [{unit}]", factor * error[drawn], None)
        _draw_small(figure.add_subplot(grid[k, :]), evaluation.time, curve, False)
    for k, axis in enumerate(each):
        found = [c for c in curves(evaluation, axis, drawn) if not skipped(c[0])]
        for column, own in enumerate(found):
            axes = figure.add_subplot(grid[len(errors) + k, column])
            _draw_small(axes, evaluation.time, own, axis is each[-1])
    figure.suptitle(title, fontsize=11, y=1.0 - 0.28 / figure.get_figheight())
    above(figure, figure.axes[len(errors)])  # a position has both curves
    return figure


def _draw_small(axes: Axes, time: Floats, curve: Curve, last: bool) -> None:
    """One of many panels; the ``last`` ones have the time below."""
    label, values, reference = curve
    axes.plot(*thinned(time[: len(values)], values), color=OWN, lw=1, label="axis")
    if reference is not None:
        line = thinned(time, reference)
        axes.plot(*line, color="black", lw=0.8, ls="--", label="reference")
    finish(axes, "", "time [s]" if last else "")
    axes.set_title(label, fontsize=9, loc="right")
    axes.tick_params(labelsize=8)
    axes.yaxis.set_major_locator(MaxNLocator(nbins=4))
    axes.margins(x=0)


#: A diverged motion is not drawn once its error is this many times the largest reference.
RUNAWAY = 10.0


def path_errors(evaluation: Evaluation) -> list[tuple[str, float, str, Floats]]:
    """Of each error off the path of a program of any axes: of what, factor, unit then, values."""
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
