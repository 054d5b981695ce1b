"""The picture of a contour: the path with its error enlarged, and the error against time."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hfc_design.contour import Glitch, contour_error, glitches
from hfc_design.paths import Floats
from hfc_design.plots import OTHER, OWN, framed
from hfc_design.trajectories import BLU, Circle, PathSamples, Trajectory

#: Share of the path's size that a division of the error takes.
SHARE = 0.08
#: Points that an outline of the path is drawn with, at least.
POINTS = 2000


def contour(trajectory: Trajectory, time: Floats, actual: Floats, title: str) -> Figure:
    """The path with the contour error enlarged across it, and the error against time.

    As on the chart of a ballbar test: grey lines run one division on both sides of the path.
    Dots mark what follows where an axis reverses.

    Args:
        trajectory: what was commanded.
        time: (steps,) [s].
        actual: (2, steps) positions of the machine [mm].
        title: stands above.
    """
    samples = trajectory.samples(time)
    error = contour_error(trajectory, samples, actual)
    marks = glitches(time, samples, error)
    figure = framed(8.4, top=0.4)
    upper, lower = figure.subplots(2, 1, gridspec_kw={"height_ratios": (2.4, 1), "hspace": 0.42})
    _draw_path(upper, trajectory, time, error, marks)
    _draw_error(lower, time, error / BLU, marks)
    upper.set_title(title, fontsize=11)
    return figure


def _draw_path(
    axes: Axes, trajectory: Trajectory, time: Floats, error: Floats, marks: list[Glitch]
) -> None:
    samples = trajectory.samples(time)
    outline = trajectory.samples(np.linspace(0.0, trajectory.duration_s, POINTS))
    size = np.ptp(outline.position, axis=1).max()
    division = _round_above(np.abs(error).max(initial=0.0) / 2 or BLU)
    enlarged = SHARE * size / division
    left = -trajectory.side if isinstance(trajectory, Circle) else 1
    for offset in (-division, division):
        axes.plot(*_beside(outline, left * enlarged * offset), color="0.8", lw=0.8)
    axes.plot(*outline.position, color="black", lw=1, ls="--", label="path")
    label = f"error, {enlarged:.0f} times enlarged"
    drawn = _beside(samples, left * enlarged * error)
    axes.plot(*drawn, color=OWN, lw=1.2, label=label)
    if marks:
        at = [int(np.searchsorted(time, mark.worst_s)) for mark in marks]
        axes.plot(*drawn[:, at], "o", color=OTHER, ms=4, label="after a reversal")
    axes.set_aspect("equal", adjustable="datalim")
    axes.grid(color="0.95")
    axes.set_axisbelow(True)
    axes.set_xlabel(f"X [mm]; a grey line is {division / BLU:g} BLU off the path")
    axes.set_ylabel("Y [mm]")
    axes.legend(fontsize=9, frameon=False, loc="best")


def _draw_error(axes: Axes, time: Floats, error: Floats, marks: list[Glitch]) -> None:
    axes.plot(time, error, color=OWN, lw=1)
    axes.plot(
        [mark.worst_s for mark in marks],
        [mark.error / BLU for mark in marks],
        "o",
        color=OTHER,
        ms=4,
    )
    axes.grid(color="0.9")
    axes.set_axisbelow(True)
    axes.margins(x=0)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("contour error [BLU]")


def _beside(samples: PathSamples, left: Floats | float) -> Floats:
    """(2, steps) the positions moved to the left of the motion [mm]."""
    normal = np.stack([-samples.tangent[1], samples.tangent[0]])
    return samples.position + left * normal


def _round_above(value: float) -> float:
    """The smallest of 1, 2, 5 times a power of ten that is not below a positive value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * next(step for step in (1, 2, 5, 10) if step * power >= value))
