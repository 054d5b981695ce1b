"""Motions as panels of curves against time: quantities, units and layout."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from hfc_design.core.numbers import Floats, Mask
from hfc_design.plotting.curves import thinned
from hfc_design.plotting.figure import finish, framed
from hfc_design.plotting.numbers import readable
from hfc_design.simulation.evaluating import AxisMotion, Evaluation

Evaluations = Mapping[str, Evaluation]  # by the names of the designs, all of the same motion
#: Name of an error, factor and unit for drawing, and values (steps,).
PathError = tuple[str, float, str, Floats]
#: A diverged motion is drawn until its error is this many times the largest reference.
RUNAWAY = 10.0


class Panel(NamedTuple):
    """Curves of one quantity over a motion."""

    label: str  # with the unit
    curves: dict[str, Floats]  # name of a design -> values; after divergence left out or nan
    reference: Floats | None = None  # (steps,) of a position


def axis_panels(evaluations: Evaluations, k: int, spring: bool = True) -> list[Panel]:
    """Return position (with reference), error and command of axis ``k``, up to divergence.

    With ``spring``, also the deflection of the spring, if the drive has one.
    """
    first = next(iter(evaluations.values()))
    axis, units = first.axes[k], first.axes[k].drive.units
    factor, unit = error_scale(evaluations.values(), units["error"])
    head = f"{axis.name} " if len(first.axes) > 1 else ""
    position = f"{'angle' if units['error'] == 'rad' else 'position'} [{units['error']}]"
    drawn: dict[str, Callable[[AxisMotion], Floats]] = {
        position: lambda axis_motion: axis_motion.reference - axis_motion.motion.error,
        f"error [{unit}]": lambda axis_motion: factor * axis_motion.motion.error,
    }
    if spring and "deflection" in axis.readings:
        drawn["deflection [mrad]"] = lambda axis_motion: 1e3 * axis_motion.readings["deflection"]
    drawn[f"{axis.drive.command_name} [{units['command']}]"] = lambda axis_motion: (
        axis_motion.motion.command
    )
    return [
        Panel(
            head + label,
            {name: values(x.axes[k])[: drawn_samples(x)] for name, x in evaluations.items()},
            axis.reference if label == position else None,
        )
        for label, values in drawn.items()
    ]


def path_panels(evaluations: Evaluations) -> list[Panel]:
    """Return a panel for each of the ``path_errors``, with all designs; none without a path."""
    each = [path_errors(one, evaluations.values()) for one in evaluations.values()]
    ends = [drawn_samples(one) for one in evaluations.values()]
    panels = []
    for errors in zip(*each, strict=True):
        curves = (x * values[:end] for (_, x, _, values), end in zip(errors, ends, strict=True))
        what, _, unit, _ = errors[0]
        panels.append(Panel(f"{what} error [{unit}]", dict(zip(evaluations, curves, strict=True))))
    return panels


def path_errors(evaluation: Evaluation, scaled: Iterable[Evaluation] = ()) -> list[PathError]:
    """Return the contour error and, if the machine turns the tool, the error of its direction.

    Contour errors of an X-Y machine are in the unit of the path, others in a unit that suits all
    evaluations ``scaled`` (default: only the ``evaluation``). The list is empty without a path.
    """
    path = evaluation.contour
    if path is None:
        return []
    if not path.any_axes:
        return [("contour", 1.0, path.unit, path.error)]
    errors = [("contour", *error_scale([*scaled] or [evaluation], path.unit), path.error)]
    return errors if path.turned is None else [*errors, ("orientation", 1.0, "deg", path.turned)]


def error_scale(evaluations: Iterable[Evaluation], unit: str) -> tuple[float, str]:
    """Return factor and unit in which all errors of axes and contours in a ``unit`` are legible.

    They are the same for all, so that there is no error in mm beside others in µm.
    """
    largest = 0.0
    for one in evaluations:
        alike = [axis.motion.error for axis in one.axes if axis.drive.units["error"] == unit]
        if one.contour is not None and one.contour.unit == unit:
            alike.append(one.contour.error)
        drawn = slice(drawn_samples(one))
        largest = max([largest, *(float(np.abs(error[drawn]).max()) for error in alike)])
    return readable(unit, largest)


def drawn_samples(evaluation: Evaluation) -> int:
    """Return the number of samples to draw: all, or those before a diverged motion runs away."""
    if not evaluation.diverged:
        return len(evaluation.time)
    if evaluation.contour is not None:
        drawn = np.isfinite(evaluation.contour.error)
    else:
        drawn = np.logical_and.reduce([_within(axis) for axis in evaluation.axes])
    return len(drawn) if drawn.all() else max(int(np.argmin(drawn)), 1)


def _within(axis: AxisMotion) -> Mask:
    """Return (steps,): True where the numbers of an axis are finite and below a limit."""
    limit = RUNAWAY * np.abs(axis.reference).max() or RUNAWAY
    error: Floats = axis.motion.error
    within = np.isfinite(axis.motion.command)
    for values in (error, axis.readings.get("deflection", error)):
        within &= np.abs(values) < limit  # False for nan
    return within


def stacked(panels: Sequence[Panel], top: float, room: float = 0.5) -> tuple[Figure, list[Axes]]:
    """Return a figure and its empty axes one below the other, with margins [in] around them."""
    figure = framed(1.3 * len(panels) + top + room, top=top)
    shape: Any = {"sharex": True, "squeeze": False, "gridspec_kw": {"hspace": 0.12}}
    return figure, [*figure.subplots(len(panels), 1, **shape)[:, 0]]


def small(
    wide: Sequence[Panel], rows: Sequence[Sequence[Panel]], height: float, top: float
) -> tuple[Figure, list[Axes]]:
    """Return a figure and empty axes: a row per ``wide`` panel, then ``rows`` of small panels."""
    count = len(wide) + len(rows)
    figure = framed(1.4 * count + height, top=top)
    grid = figure.add_gridspec(count, 3, hspace=0.6, wspace=0.4)
    places = [grid[k, :] for k in range(len(wide))]
    places += [grid[len(wide) + k, n] for k, row in enumerate(rows) for n in range(len(row))]
    return figure, [figure.add_subplot(place) for place in places]


def draw(
    axes: Axes,
    time: Floats,
    panel: Panel,
    styles: Iterable[dict[str, Any]],
    shape: Callable[[Floats, Floats], tuple[Floats, Floats]] = thinned,
    ls: str = ":",
) -> None:
    """Draw each curve in its style, and the reference in black with dashes ``ls``.

    ``shape`` reduces the samples of a curve to few points.
    """
    for values, style in zip(panel.curves.values(), styles, strict=True):
        axes.plot(*shape(time[: len(values)], values), **style)
    if panel.reference is not None:
        axes.plot(*shape(time, panel.reference), color="black", lw=0.8, ls=ls, label="reference")
    axes.margins(x=0)


def titled(axes: Axes, label: str) -> None:
    """Give a small panel a label above it, and few small numbers."""
    spec = axes.get_subplotspec()
    finish(axes, "", "time [s]" if spec and spec.is_last_row() else "")
    axes.set_title(label, fontsize=9, loc="right")
    axes.tick_params(labelsize=8)
    axes.yaxis.set_major_locator(MaxNLocator(nbins=4))
