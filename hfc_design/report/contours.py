"""A path with the contour error enlarged across it."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import blended_transform_factory
from numpy.typing import NDArray

from hfc_design.core.numbers import Floats
from hfc_design.motion.contour import Contour, nearest
from hfc_design.motion.reversals import glitches
from hfc_design.motion.samples import PathSamples
from hfc_design.pictures.figure import OTHER, OWN, drawable, framed, gridded, round_above

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
