"""Curves of a design and of its search."""

from collections.abc import Mapping
from itertools import chain, cycle
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from hfc_design.core.shapes import Floats, Mask
from hfc_design.pictures.figure import OTHER, OWN, finish, framed, logarithmic
from hfc_design.search.loop import History
from hfc_design.simulation.evaluation import AxisMotion, Evaluation

RIVALS: tuple[dict[str, Any], ...] = tuple(
    {"color": color, "lw": 1.2, "ls": style}
    for color, style in (("#D55E00", "-"), ("#009E73", "--"), ("#CC79A7", "-."), ("#E69F00", ":"))
)
#: A curve is drawn with at most two points in each of this many slices of time.
SLICES = 500
#: A diverged motion is not drawn once its error is this many times the largest reference.
RUNAWAY = 10.0


def response(evaluation: Evaluation, title: str) -> Figure:
    """Position, tracking error, spring deflection, command and load against time.

    The C-axis as LL fig. 6 and 7, c to f; of several axes one below the other. There is no panel
    of a deflection that the drive has not, or of a load where there is none. A diverged motion
    ends where it runs away.
    """
    drawn = slice(_drawn(evaluation))
    curves = [curve for axis in evaluation.axes for curve in _curves(evaluation, axis, drawn)]
    figure = framed(1.45 * len(curves) + 1.0, top=0.4)
    panels = figure.subplots(len(curves), 1, sharex=True, gridspec_kw={"hspace": 0.12})
    for axes, (label, values, reference) in zip(panels, curves, strict=True):
        angular = label.endswith("[rad]")
        curve = _thinned(evaluation.time[drawn], values)
        axes.plot(*curve, color=OWN, lw=1.2, label="spindle" if angular else "axis")
        finish(axes, label)
        if reference is not None:
            line = _thinned(evaluation.time, reference)
            axes.plot(*line, color="black", lw=1, ls="--", label="reference")
            axes.legend(fontsize=9, frameon=False)
    panels[0].margins(x=0)
    panels[-1].set_xlabel("time [s]")
    if evaluation.diverged:
        title += f" (diverged at {evaluation.time[drawn][-1]:.3g} s)"
    panels[0].set_title(title, fontsize=11)
    return figure


def _curves(
    evaluation: Evaluation, axis: AxisMotion, drawn: slice
) -> list[tuple[str, Floats, Floats | None]]:
    """Label, values and, of the position, the reference of each panel of an axis."""
    units, drive = axis.drive.units, axis.drive
    name = f"{axis.name} " if len(evaluation.axes) > 1 else ""
    factor, unit = _error_unit(evaluation, axis)
    error = axis.motion.error[drawn]
    called = "angle" if units["error"] == "rad" else "position"
    found: list[tuple[str, Floats, Floats | None]] = [
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


def errors(evaluations: Mapping[str, Evaluation]) -> Figure:
    """Largest error in each hundredth of the time, logarithmic; the first stands out.

    The contour error of an X-Y machine, else the tracking error.

    Errors that differ by orders of magnitude and change their sign cannot be compared otherwise.
    """
    figure = framed(3.8, top=0.65)
    axes = figure.subplots()
    first = next(iter(evaluations.values()))
    factor, unit = _error_unit(first, first.axes[0])
    styles = chain([{"color": OWN, "lw": 2.5, "zorder": 3}], cycle(RIVALS))
    for (name, evaluation), style in zip(evaluations.items(), styles, strict=False):
        count = _drawn(evaluation)
        starts = np.arange(0, count, -(-len(evaluation.time) // 100))
        largest = np.maximum.reduceat(factor * np.abs(_error(evaluation)[:count]), starts)
        label = f"{name} (diverged)" if evaluation.diverged else name
        axes.plot(evaluation.time[starts], largest, label=label, **style)
    finish(axes, f"largest error [{unit}]", "time [s]")
    logarithmic(axes)
    axes.margins(x=0)
    figure.legend(fontsize=9, frameon=False, ncols=2, loc="upper center")
    return figure


def history(history: History, title: str) -> Figure:
    """Best and median merit, by its ``title``, and how many individuals diverged."""
    figure = framed(4.15, top=0.4)
    ratios = {"height_ratios": (3, 1), "hspace": 0.12}
    scores, diverged = figure.subplots(2, 1, sharex=True, gridspec_kw=ratios)
    count = len(history.best)
    generation = np.arange(1.0, count + 1)
    style: dict[str, Any] = {"marker": "." if count < 30 else None}
    scores.plot(*_thinned(generation, history.best), color=OWN, label="best so far", **style)
    scores.plot(*_thinned(generation, history.median), color=OTHER, label="median", **style)
    scores.legend(fontsize=9, frameon=False)
    scores.set_title(title, fontsize=11, parse_math=False)
    finish(scores, "merit")
    logarithmic(scores)
    place, bars = _thinned(generation, history.diverged)
    place = np.concatenate([[0.5], place, [count + 0.5]])
    diverged.fill_between(place, np.pad(bars, 1, mode="edge"), step="mid", color="0.6")
    finish(diverged, "diverged [1]", "generation")
    diverged.set(xlim=(0.5, count + 0.5), ylim=(0, 1.05 * max(int(history.diverged.max()), 1)))
    diverged.xaxis.set_major_locator(MaxNLocator(integer=True))
    diverged.yaxis.set_major_locator(MaxNLocator(nbins=3, integer=True))
    return figure


def _error(evaluation: Evaluation) -> Floats:
    """(steps,) what the controller is to make small; of several axes that of the worst."""
    path = evaluation.contour
    if path is not None:
        return path.error
    return np.abs([axis.motion.error for axis in evaluation.axes]).max(axis=0)


def _error_unit(evaluation: Evaluation, axis: AxisMotion) -> tuple[float, str]:
    """Factor and unit in which the errors of an axis are easy to read."""
    unit = axis.drive.units["error"]
    if unit != "rad":
        return 1.0, unit
    largest = np.abs(axis.motion.error[: _drawn(evaluation)]).max()
    return (1e6, "µrad") if largest < 1e-3 else (1e3, "mrad")


def _drawn(evaluation: Evaluation) -> int:
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


def _thinned(time: Floats, values: NDArray[Any]) -> tuple[Floats, NDArray[Any]]:
    """The curve with the lowest and the highest point of each slice of time, in order."""
    size = -(-len(values) // SLICES)
    if size <= 2:
        return time, values
    slices = np.pad(values, (0, -len(values) % size), mode="edge").reshape(-1, size)
    first = size * np.arange(len(slices))
    ends = [[0, len(values) - 1], first + slices.argmin(axis=1), first + slices.argmax(axis=1)]
    keep = np.unique(np.minimum(np.concatenate(ends), len(values) - 1))
    return time[keep], values[keep]
