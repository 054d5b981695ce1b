"""Motions of a design: its response, the contour of its path, or both."""

from itertools import chain
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import blended_transform_factory

from hfc_design.core.numbers import Floats
from hfc_design.motion.contour import Contour, nearest
from hfc_design.motion.reversals import glitches
from hfc_design.motion.samples import PathSamples
from hfc_design.motion.trajectories import Trajectory
from hfc_design.plotting.curves import thinned
from hfc_design.plotting.figure import (
    OTHER,
    OWN,
    above,
    drawable,
    finish,
    framed,
    gridded,
    round_above,
)
from hfc_design.report import panels
from hfc_design.report.panels import Panel, axis_panels, drawn_samples
from hfc_design.simulation.evaluating import Evaluation


def motion(evaluation: Evaluation, title: str) -> Figure:
    """Draw a motion: ``contour`` in X-Y, ``program`` in any axes, otherwise ``response``."""
    path = evaluation.contour
    if path is None:
        return response(evaluation, title)
    if evaluation.diverged:
        title += " (diverged)"
    if path.any_axes:
        return program(evaluation, title)
    return contour(path, evaluation.time, title)


def response(evaluation: Evaluation, title: str) -> Figure:
    """Draw position, tracking error, spring deflection, command and load against time.

    The C-axis is drawn as in LL fig. 6 and 7, c to f; several axes are one below the other. A drive
    without a spring has no panel for a deflection, a motion without a load none for a load. The
    curves of a diverged motion end where it runs away.
    """
    shown = []
    for k, axis in enumerate(evaluation.axes):
        shown += axis_panels({"": evaluation}, k)
        if np.any(axis.load):
            head = f"{axis.name} " if len(evaluation.axes) > 1 else ""
            load = axis.load[: drawn_samples(evaluation)]
            shown.append(Panel(f"{head}load [{axis.drive.units['load']}]", {"": load}))
    figure, places = panels.stacked(shown, top=0.4, room=0.6)
    for axes, panel in zip(places, shown, strict=True):
        label = "spindle" if panel.label.endswith("[rad]") else "axis"
        style = {"color": OWN, "lw": 1.2, "label": label}
        panels.draw(axes, evaluation.time, panel._replace(reference=None), [style])
        finish(axes, panel.label)
        if panel.reference is not None:
            line = thinned(evaluation.time, panel.reference)
            axes.plot(*line, color="black", lw=1.0, ls="--", label="reference")
            axes.legend(fontsize=9, frameon=False)
    places[-1].set_xlabel("time [s]")
    if evaluation.diverged:
        title += f" (diverged at {evaluation.time[drawn_samples(evaluation) - 1]:.3g} s)"
    places[0].set_title(title, fontsize=11)
    return figure


def program(evaluation: Evaluation, title: str) -> Figure:
    """Draw contour errors, then small panels of position, error and command of each axis."""
    wide = panels.path_panels({"": evaluation})
    rows = [axis_panels({"": evaluation}, k, spring=False) for k in range(len(evaluation.axes))]
    figure, places = panels.small(wide, rows, height=1.1, top=0.75)
    for axes, panel in zip(places, chain(wide, *rows), strict=True):
        style = {"color": OWN, "lw": 1.0, "label": "axis"}
        panels.draw(axes, evaluation.time, panel, [style], ls="--")
        panels.titled(axes, panel.label)
    figure.suptitle(title, fontsize=11, y=1.0 - 0.28 / figure.get_figheight())
    above(figure, places[len(wide)])  # has both curves
    return figure


#: Share of the path's size that a division of the contour error takes.
SHARE = 0.08
#: The smallest division, in units of the positions, so that rounding errors are not enlarged.
SMALLEST = 0.1
#: Least number of points of an outline of the path.
POINTS = 2000


def contour(measured: Contour, time: Floats, title: str) -> Figure:
    """Draw the path with the contour error enlarged across it, and the error against time.

    As on the chart of a ballbar test: grey lines run one division on both sides of the path.
    Dots mark the motion after reversals of an axis. A diverged motion ends at its first NaN.

    Args:
        measured: commanded motion, and positions of the machine.
        time: (steps,) [s].
        title: title above the figure.
    """
    trajectory, actual = measured.planar, measured.actual
    drawn = int(np.isfinite(actual).all(axis=0).cumprod().sum())
    time, actual = time[:drawn], drawable(actual[:, :drawn])
    samples = trajectory.samples(time)
    base, error = nearest(trajectory, samples, actual)
    figure = framed(8.0, top=0.85)
    upper, lower = figure.subplots(2, 1, gridspec_kw={"height_ratios": (2.4, 1), "hspace": 0.3})
    furthest = np.nan_to_num(np.hypot(*(actual - base))).max()  # nan: at the centre of a circle
    division = round_above(max(furthest / 2, SMALLEST * measured.millimetres))
    off = f"{division / measured.millimetres:g} {measured.unit} off"
    enlarged = draw_path(upper, trajectory, division, off)
    moved = base + enlarged * (actual - base)
    upper.plot(*moved, color=OWN, lw=1.2, label=f"error, {enlarged:.0f} times enlarged")
    shown = error / measured.millimetres
    lower.plot(time, shown, color=OWN, lw=1)
    worst = np.searchsorted(time, [mark.worst_s for mark in glitches(time, samples, error)])
    if len(worst):
        upper.plot(*moved[:, worst], "o", color=OTHER, ms=4, label="largest after a reversal")
    lower.plot(time[worst], shown[worst], "o", color=OTHER, ms=4)
    gridded(lower, "time [s]", f"contour error [{measured.unit}]")
    lower.margins(x=0)
    # In the middle of the figure, which is wider than the axes.
    place = blended_transform_factory(figure.transFigure, upper.transAxes)
    where: dict[str, Any] = {"bbox_to_anchor": (0.5, 0.99), "bbox_transform": place}
    path, grey, curve, *dots = upper.get_legend_handles_labels()[0]
    handles = [path, curve, grey, *dots]
    upper.legend(handles=handles, fontsize=9, frameon=False, ncols=2, loc="lower center", **where)
    upper.set_title(title, fontsize=11, pad=38)
    return figure


def draw_path(axes: Axes, trajectory: Trajectory, division: float, label: str = "") -> float:
    """Draw a path and grey lines one ``division`` [mm] off on both sides; return the scale."""
    outline = trajectory.samples(np.linspace(0.0, trajectory.duration_s, POINTS))
    enlarged = SHARE * float(np.ptp(outline.position, axis=1).max()) / division
    axes.plot(*outline.position, color="black", lw=0.8, label="path")
    for offset, named in ((-division, label), (division, "")):
        line = _parallel(outline, enlarged * offset)
        axes.plot(*line, color="0.75", lw=0.8, zorder=1, label=named or None)
    axes.set_aspect("equal", adjustable="datalim")
    gridded(axes, "X [mm]", "Y [mm]", color="0.95")
    return enlarged


def _parallel(samples: PathSamples, left: float) -> Floats:
    """Return the positions shifted to the left of the motion [mm], (2, steps); nan at corners."""
    tangent = samples.tangent
    moved = samples.position + left * np.stack([-tangent[1], tangent[0]])
    ahead = (tangent[:, :-1] * tangent[:, 1:]).sum(axis=0)
    moved[:, :-1][:, ahead < 0.9] = np.nan
    return moved
