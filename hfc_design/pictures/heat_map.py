"""A rule table as a heat map with its numbers."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from hfc_design.core.shapes import Floats
from hfc_design.pictures.figure import WIDTH, framed


def heat_map(
    values: Floats,
    labels: Sequence[str],
    row: str,
    column: str,
    title: str,
    meaning: str,
    shades: Floats | None = None,
) -> Figure:
    """A table (7, 7) with a number in every cell, its first row on top as the papers print it.

    Args:
        values: what is written.
        labels: names of the terms of both inputs.
        row: name of the input of the rows.
        column: name of the input of the columns.
        title: stands above.
        meaning: what the colours stand for, with its unit.
        shades: what is coloured; without it the values.
    """
    figure = framed(4.0, top=0.35)
    figure.subplots_adjust(right=1 - 0.95 / WIDTH)
    axes = figure.subplots()
    shades = values if shades is None else shades
    limit = float(np.abs(shades).max()) or 1.0
    largest = np.abs(values).max()
    decimals = 2 if largest < 10 else 1 if largest < 100 else 0
    edges = np.arange(len(labels) + 1) - 0.5
    mesh = axes.pcolormesh(edges, edges, shades, cmap="RdBu_r", vmin=-limit, vmax=limit)
    for (i, j), value in np.ndenumerate(values):
        color = "white" if abs(shades[i, j]) > 0.6 * limit else "black"
        text = f"{value:z.{decimals}f}".replace("-", "\u2212")
        axes.text(j, i, text, ha="center", va="center", fontsize=9, color=color)
    axes.set_xticks(range(len(labels)), labels)
    axes.set_yticks(range(len(labels)), labels)
    axes.tick_params(length=0)
    axes.invert_yaxis()
    axes.set_xlabel(column)
    axes.set_ylabel(row)
    axes.set_title(title, fontsize=11)
    place = axes.get_position()
    strip = figure.add_axes((place.x1 + 0.02, place.y0, 0.03, place.height))
    bar = figure.colorbar(mesh, cax=strip)
    bar.set_label(meaning)
    bar.outline.set_visible(False)
    return figure
