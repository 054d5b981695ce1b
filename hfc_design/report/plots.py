"""What a design does: its response, the contour of its path, or both; how much of it is drawn."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import blended_transform_factory
from numpy.typing import NDArray

from hfc_design.core.numbers import Floats, Mask
from hfc_design.motion.contour import Contour, nearest
from hfc_design.motion.reversals import glitches
from hfc_design.motion.samples import PathSamples
from hfc_design.pictures.curves import thinned
from hfc_design.pictures.figure import (
    OTHER,
    OWN,
    above,
    drawable,
    finish,
    framed,
    gridded,
    round_above,
)
from hfc_design.pictures.numbers import readable
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


Places = NDArray[np.intp]  # of samples
#: Share of the path's size that a division of the contour error takes.
SHARE = 0.08
#: The smallest division, in units of the positions; rounding is not worth a picture.
SMALLEST = 0.1
#: Points that an outline of the path is drawn with, at least.
POINTS = 2000


def contour(found: Contour, time: Floats, title: str) -> Figure:
    """The path with the contour error enlarged across it, and the error against time.

    As on the chart of a ballbar test: grey lines run one division on both sides of the path.
    Dots mark what follows where an axis reverses. A diverged motion ends where it is no number.

    Args:
        found: what was commanded, and the positions of the machine.
        time: (steps,) [s].
        title: stands above.
    """
    trajectory, actual = found.planar, found.actual
    drawn = int(np.isfinite(actual).all(axis=0).cumprod().sum())
    time, actual = time[:drawn], drawable(actual[:, :drawn])
    samples = trajectory.samples(time)
    base, error = nearest(trajectory, samples, actual)
    marks = glitches(time, samples, error)
    figure = framed(8.0, top=0.85)
    upper, lower = figure.subplots(2, 1, gridspec_kw={"height_ratios": (2.4, 1), "hspace": 0.3})
    worst = np.searchsorted(time, [mark.worst_s for mark in marks])
    _draw_path(figure, upper, found, base, actual - base, worst)
    shown = error / found.millimetres
    lower.plot(time, shown, color=OWN, lw=1)
    lower.plot(time[worst], shown[worst], "o", color=OTHER, ms=4)
    gridded(lower, "time [s]", f"contour error [{found.unit}]")
    lower.margins(x=0)
    upper.set_title(title, fontsize=11, pad=38)
    return figure


def _draw_path(
    figure: Figure, axes: Axes, found: Contour, base: Floats, away: Floats, worst: Places
) -> None:
    trajectory, length = found.planar, found.millimetres
    outline = trajectory.samples(np.linspace(0.0, trajectory.duration_s, POINTS))
    size = np.ptp(outline.position, axis=1).max()
    furthest = np.nan_to_num(np.hypot(*away)).max()  # at the centre of a circle nobody knows
    division = round_above(max(furthest / 2, SMALLEST * length))
    enlarged = SHARE * size / division
    axes.plot(*outline.position, color="black", lw=0.8, label="path")
    drawn = base + enlarged * away
    axes.plot(*drawn, color=OWN, lw=1.2, label=f"error, {enlarged:.0f} times enlarged")
    for offset, label in ((-division, f"{division / length:g} {found.unit} off"), (division, None)):
        line = beside(outline, enlarged * offset)
        axes.plot(*line, color="0.75", lw=0.8, zorder=1, label=label)
    if len(worst):
        axes.plot(*drawn[:, worst], "o", color=OTHER, ms=4, label="worst after a reversal")
    axes.set_aspect("equal", adjustable="datalim")
    gridded(axes, "X [mm]", "Y [mm]", color="0.95")
    # In the middle of the figure, which is wider than the axes.
    place = blended_transform_factory(figure.transFigure, axes.transAxes)
    where: dict[str, Any] = {"bbox_to_anchor": (0.5, 0.99), "bbox_transform": place}
    axes.legend(fontsize=9, frameon=False, ncols=2, loc="lower center", **where)


def beside(samples: PathSamples, left: float) -> Floats:
    """(2, steps) the positions moved to the left of the motion [mm], torn at corners."""
    tangent = samples.tangent
    moved = samples.position + left * np.stack([-tangent[1], tangent[0]])
    ahead = (tangent[:, :-1] * tangent[:, 1:]).sum(axis=0)
    moved[:, :-1][:, ahead < 0.9] = np.nan
    return moved
