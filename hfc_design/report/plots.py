"""What a design does: its response or contour, and its errors beside those of others."""

from collections.abc import Mapping
from itertools import chain, cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
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
    logarithmic,
    plain,
    round_above,
)
from hfc_design.simulation.evaluation import AxisMotion, Evaluation

Places = NDArray[np.intp]  # of samples
Curve = tuple[str, Floats, Floats | None]  # label, values, the reference of a position
RIVALS: tuple[dict[str, Any], ...] = tuple(
    {"color": color, "lw": 1.2, "ls": style}
    for color, style in (
        *(("#D55E00", "-"), ("#009E73", "--"), ("#CC79A7", "-."), ("#E69F00", ":")),
        *(("#56B4E9", "-"), ("#000000", "--")),
    )
)
#: Share of the path's size that a division of the contour error takes.
SHARE = 0.08
#: The smallest division, in units of the positions; rounding is not worth a picture.
SMALLEST = 0.1
#: Points that an outline of the path is drawn with, at least.
POINTS = 2000
#: What a small picture leaves out.
SKIPPED = "deflection", "load"
#: How small panels are spaced.
SMALL: dict[str, Any] = {"hspace": 0.6, "wspace": 0.4}
#: A diverged motion is not drawn once its error is this many times the largest reference.
RUNAWAY = 10.0


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
    curves = [curve for axis in evaluation.axes for curve in _curves(evaluation, axis, drawn)]
    figure = framed(1.3 * len(curves) + 1.0, top=0.4)
    panels = figure.subplots(len(curves), 1, sharex=True, gridspec_kw={"hspace": 0.12})
    for axes, (label, values, reference) in zip(panels, curves, strict=True):
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


def _curves(evaluation: Evaluation, axis: AxisMotion, drawn: slice) -> list[Curve]:
    """Label, values and, of the position, the reference of each panel of an axis."""
    units, drive = axis.drive.units, axis.drive
    name = f"{axis.name} " if len(evaluation.axes) > 1 else ""
    factor, unit = _error_unit(evaluation, axis)
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


def _skipped(label: str) -> bool:
    """Whether there is no room for a curve."""
    return any(word in SKIPPED for word in label.split())


def program(evaluation: Evaluation, title: str) -> Figure:
    """How far a machine is off the path; then of every axis position, error and command, small."""
    errors, each = _path_errors(evaluation), evaluation.axes
    drawn = slice(drawn_samples(evaluation))
    figure = framed(1.4 * (len(errors) + len(each)) + 1.1, top=0.75)
    grid = figure.add_gridspec(len(errors) + len(each), 3, **SMALL)
    for k, (name, factor, unit, error) in enumerate(errors):
        curve: Curve = (f"{name} error [{unit}]", factor * error[drawn], None)
        _draw_small(figure.add_subplot(grid[k, :]), evaluation.time, curve, False)
    for k, axis in enumerate(each):
        curves = [c for c in _curves(evaluation, axis, drawn) if not _skipped(c[0])]
        for column, own in enumerate(curves):
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
    _draw_path(upper, found, base, actual - base, worst)
    shown = error / found.millimetres
    lower.plot(time, shown, color=OWN, lw=1)
    lower.plot(time[worst], shown[worst], "o", color=OTHER, ms=4)
    gridded(lower, "time [s]", f"contour error [{found.unit}]")
    lower.margins(x=0)
    upper.set_title(title, fontsize=11, pad=38)
    return figure


def _draw_path(axes: Axes, found: Contour, base: Floats, away: Floats, worst: Places) -> None:
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
    axes.legend(fontsize=9, frameon=False, ncols=2, loc="lower center", bbox_to_anchor=(0.5, 0.99))


def beside(samples: PathSamples, left: float) -> Floats:
    """(2, steps) the positions moved to the left of the motion [mm], torn at corners."""
    tangent = samples.tangent
    moved = samples.position + left * np.stack([-tangent[1], tangent[0]])
    ahead = (tangent[:, :-1] * tangent[:, 1:]).sum(axis=0)
    moved[:, :-1][:, ahead < 0.9] = np.nan
    return moved


def motion_errors(evaluations: Mapping[str, Evaluation]) -> Figure:
    """As ``errors``, a small panel for each axis in each motion, two in a row."""
    first = next(iter(evaluations.values()))
    pairs = [(name, k) for name, own in first.motions.items() for k in range(len(_errors(own)))]
    rows = -(-len(pairs) // 2)
    top = 0.45 + 0.2 * -(-len(evaluations) // 2)  # the legend
    figure = framed(1.7 * rows + 0.4 + top, top=top, left=0.6)
    shape = {"hspace": 0.6, "wspace": 0.28}
    panels = figure.subplots(rows, 2, squeeze=False, gridspec_kw=shape).ravel()
    for place, (panel, (name, k)) in enumerate(zip(panels, pairs, strict=False)):
        each = {label: one.motions[name] for label, one in evaluations.items()}
        what, unit = _draw_errors(panel, each, k)
        gridded(panel, "time [s]" if place + 2 >= len(pairs) else "")
        panel.set_title(plain(f"{name} {what}".strip(), 16), fontsize=9, loc="left")
        panel.set_title(f"error [{unit}]", fontsize=9, loc="right")
        panel.tick_params(labelsize=8)
        panel.xaxis.set_major_locator(MaxNLocator(nbins=4))
        logarithmic(panel)
        panel.margins(x=0)
    for panel in panels[len(pairs) :]:
        panel.set_visible(False)
    above(figure, panels[0])
    return figure


def errors(evaluations: Mapping[str, Evaluation]) -> Figure:
    """Largest error in each hundredth of the time, logarithmic; the first stands out.

    The contour error of an X-Y machine, else the tracking error, a panel for each axis; of a
    program of any axes both.

    Errors that differ by orders of magnitude and change their sign cannot be compared otherwise.
    """
    first = next(iter(evaluations.values()))
    count = len(_errors(first))
    top = max(0.65, 0.25 + 0.2 * -(-len(evaluations) // 2))  # the legend
    figure = framed(2.65 * count + 0.5 + top, top=top)
    panels = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    for k, axes in enumerate(panels):
        what, unit = _draw_errors(axes, evaluations, k)
        label = f"largest {what} error".replace("  ", " ")
        finish(axes, f"{label} [{unit}]", "time [s]" if k + 1 == count else "")
        logarithmic(axes)
        axes.margins(x=0)
    above(figure, panels[0])
    return figure


def _errors(evaluation: Evaluation) -> list[tuple[str, float, str, Floats]]:
    """Of each error that a motion is judged by: of what, factor, unit then, values."""
    path = evaluation.contour
    if path is not None and not path.any_axes:
        return [("", 1.0, path.unit, path.error)]
    found = _path_errors(evaluation)
    for axis in evaluation.axes:
        name = axis.name if len(evaluation.axes) > 1 else ""
        found.append((name, *_error_unit(evaluation, axis), axis.motion.error))
    return found


def _path_errors(evaluation: Evaluation) -> list[tuple[str, float, str, Floats]]:
    """The same of the path of a program of any axes."""
    path = evaluation.contour
    if path is None or not path.any_axes:
        return []
    found = [("contour", 1.0, path.unit, path.error)]
    return found if path.turned is None else [*found, ("orientation", 1.0, "deg", path.turned)]


def _draw_errors(axes: Axes, evaluations: Mapping[str, Evaluation], k: int) -> tuple[str, str]:
    """A curve for each design of error ``k`` of ``_errors``; of what it is, and its unit."""
    what, factor, unit, _ = _errors(next(iter(evaluations.values())))[k]
    styles = chain([{"color": OWN, "lw": 2.5, "zorder": 3}], cycle(RIVALS))
    for (name, evaluation), style in zip(evaluations.items(), styles, strict=False):
        drawn = drawn_samples(evaluation)
        starts = np.arange(0, drawn, -(-len(evaluation.time) // 100))
        error = _errors(evaluation)[k][3][:drawn]
        largest = drawable(np.maximum.reduceat(factor * np.abs(error), starts))
        label = f"{name} (diverged)" if evaluation.diverged else name
        axes.plot(evaluation.time[starts], largest, label=plain(label), **style)
    return what, unit


def _error_unit(evaluation: Evaluation, axis: AxisMotion) -> tuple[float, str]:
    """Factor and unit in which the errors of an axis are easy to read."""
    unit = axis.drive.units["error"]
    if unit != "rad":
        return 1.0, unit
    largest = np.abs(axis.motion.error[: drawn_samples(evaluation)]).max()
    return (1e6, "µrad") if largest < 1e-3 else (1e3, "mrad")


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
