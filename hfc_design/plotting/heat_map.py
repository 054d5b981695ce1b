"""A table as colours, with a number in every cell."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from hfc_design.core.numbers import Floats
from hfc_design.core.records import TERMS
from hfc_design.plotting.figure import STRIP, colour_strip, framed


def heat_map(
    values: Floats,
    labels: tuple[Sequence[str], Sequence[str]],
    row: str,
    column: str,
    title: str,
    meaning: str,
    shades: Floats | None = None,
) -> Figure:
    """Draw a table with a number in every cell, its first row on top as in the papers.

    Args:
        values: numbers in the cells.
        labels: names of the terms of the rows' input, and of the columns'.
        row: name of the input of the rows.
        column: name of the input of the columns.
        title: title above the table.
        meaning: meaning of the colours, with its unit.
        shades: values of the colours; default: the numbers in the cells.
    """
    longest = max(map(len, labels[0]), default=0)
    figure = framed(4.0, top=0.35, left=0.48 + 0.08 * longest, right=STRIP)
    axes = figure.subplots()
    shades = values if shades is None else shades
    limit = float(np.abs(shades).max()) or 1.0
    largest = np.abs(values).max()
    decimals = 2 if largest < 10 else 1 if largest < 100 else 0
    if largest >= 10 and np.array_equal(values, np.round(values)):  # large numbers need the room
        decimals = 0
    rows, columns = (np.arange(len(of) + 1) - 0.5 for of in labels)
    mesh = axes.pcolormesh(columns, rows, shades, cmap="RdBu_r", vmin=-limit, vmax=limit)
    size = 9 if len(labels[1]) <= TERMS else 7
    for (i, j), value in np.ndenumerate(values):
        color = "white" if abs(shades[i, j]) > 0.6 * limit else "black"
        text = f"{value:z.{decimals}f}".replace("-", "\u2212")
        axes.text(j, i, text, ha="center", va="center", fontsize=size, color=color)
    axes.set_xticks(range(len(labels[1])), labels[1])
    axes.set_yticks(range(len(labels[0])), labels[0])
    axes.tick_params(length=0)
    axes.invert_yaxis()
    axes.set(xlabel=column, ylabel=row)
    axes.set_title(title, fontsize=11)
    colour_strip(figure, axes, mesh, meaning).outline.set_visible(False)
    return figure
