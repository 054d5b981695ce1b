"""A two-input fuzzy unit drawn as its output over both inputs."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from hfc_design.core.numbers import Floats
from hfc_design.plotting.figure import STRIP, WIDTH, colour_strip, framed, round_above
from hfc_design.plotting.files import Displayed

#: Points per side of a computed surface, and points of curved terms.
POINTS = 81
#: Approximate number of colours for outputs of one sign.
BANDS = 12
#: Number of these points in one step of a surface in space.
EVERY = 2
#: Order of drawing below which shades of a surface lie; a report makes these pixels.
BELOW = 0.0


def surface(
    column: Floats, row: Floats, values: Floats, labels: tuple[str, str], title: str, meaning: str
) -> Figure:
    """Draw the output of a unit as colours.

    Args:
        column: (columns,) values of the column's input, in the unit of its label.
        row: (rows,) values of the row's input, in the unit of its label.
        values: (rows, columns) output.
        labels: labels of the column's axis and of the row's.
        title: title above the figure.
        meaning: meaning of the colours, with its unit.
    """
    figure = framed(4.0, top=0.35, right=STRIP)
    axes = figure.subplots()
    low, high = float(values.min()), float(values.max())
    if low * high > 0.0:  # of one sign: all colours for the differences
        filled = axes.contourf(column, row, values, BANDS, cmap="viridis", zorder=-1)
        ticks = MaxNLocator(7)
    else:
        limit = max(-low, high) or 1.0
        division = round_above(limit / BANDS)
        count = int(np.ceil(limit / division + 0.5))
        levels = division * (np.arange(-count, count) + 0.5)  # no line at 0, due to rounding errors
        filled = axes.contourf(column, row, values, levels, cmap="RdBu_r", zorder=-1)
        ticks = MaxNLocator(7, symmetric=True)
    filled.set_edgecolor("face")  # else white hairlines show between the bands
    axes.axhline(0.0, color="0.3", lw=0.6)
    axes.axvline(0.0, color="0.3", lw=0.6)
    axes.set(xlabel=labels[0], ylabel=labels[1])
    axes.set_title(title, fontsize=11)
    colour_strip(figure, axes, filled, meaning, ticks=ticks)
    return figure


def solid(
    column: Floats, row: Floats, values: Floats, labels: tuple[str, str], title: str, meaning: str
) -> Figure:
    """Draw the output of a unit as a surface in space, with the output as the height."""
    figure = Displayed(figsize=(WIDTH, 4.6))
    axes: Any = figure.add_axes((0.0, 0.0, 0.9, 1.0), projection="3d")
    limit = float(np.abs(values).max()) or 1.0
    cut = slice(None, None, EVERY)
    x, y = np.meshgrid(column[cut], row[cut])
    shades = (
        {"cmap": "viridis"}
        if values.min() * values.max() > 0.0
        else {"cmap": "RdBu_r", "vmin": -limit, "vmax": limit}
    )
    axes.plot_surface(
        x, y, values[cut, cut], rstride=1, cstride=1, edgecolor="0.35", linewidth=0.2, **shades
    )
    for axis, label in ((axes.xaxis, labels[0]), (axes.yaxis, labels[1]), (axes.zaxis, meaning)):
        axis.set_label_text(label, fontsize=9)
        axis.set_tick_params(labelsize=8, pad=0)
        axis.set_major_locator(MaxNLocator(5))
    axes.set_box_aspect(None, zoom=0.85)  # else the labels are cut off
    axes.view_init(elev=28.0, azim=-125.0)
    axes.set_title(title, fontsize=11, y=0.93)
    return figure
