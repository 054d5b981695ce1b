"""Room in a figure that has become narrow: for its legend, for texts and numbers side by side."""

from itertools import pairwise
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.ticker import MaxNLocator

#: Of texts side by side that would touch, as numbers in cells: the least size [pt],
#: and the share of their place that they then have.
CELL, FILLED = 5.0, 0.85
#: Between a legend and what is below it, and between numbers of an axis, in dots of 1/100 in.
ROOM, APART = 3.0, 5.0


def lower(figure: Figure, share: float) -> None:
    """What has one scale for both directions becomes lower by the ``share`` that its width did."""
    height = figure.get_figheight()
    for axes in figure.axes:
        if axes.get_aspect() == "auto" or share >= 1.0:
            continue
        box = axes.get_position(original=True)
        less = (1.0 - share) * box.height * height
        _stretch(figure, [0.0, box.y0, box.y1, 1.0], [0.0, 0.0, -less, -less])


def _stretch(figure: Figure, places: list[float], more: list[float]) -> None:
    """Move axes, and make the figure higher by the last of ``more`` [in].

    Args:
        figure: it all.
        places: heights in it, from 0 to 1.
        more: how far up each goes [in]; between them in proportion.
    """
    before = figure.get_figheight()
    after = before + more[-1]
    ends = [(before * place + up) / after for place, up in zip(places, more, strict=True)]
    for axes in figure.axes:
        box = axes.get_position(original=True)
        low, high = np.interp([box.y0, box.y1], places, ends)
        axes.set_position((box.x0, low, box.width, high - low))
    figure.set_figheight(after)


def apart(axes: Axes) -> None:
    """Make texts in the axes smaller that would touch where they stand side by side."""
    figure = cast(Figure, axes.get_figure())
    renderer: Any = FigureCanvasAgg(figure).get_renderer()
    texts = [text for text in axes.texts if text.get_horizontalalignment() == "center"]
    boxes = {text: text.get_window_extent(renderer) for text in texts}
    rows = sorted(texts, key=lambda text: (round(boxes[text].y0), boxes[text].x0))
    shares = [1.0]
    for a, b in pairwise(boxes[text] for text in rows):
        place = (b.x0 + b.x1 - a.x0 - a.x1) / 2
        if round(a.y0) == round(b.y0) and place > 0.0:
            shares.append(FILLED * 2 * place / (a.width + b.width))
    for text in texts if min(shares) < FILLED else ():
        text.set_fontsize(max(min(shares) * float(text.get_fontsize()), CELL))


def thin(axes: Axes) -> None:
    """Fewer numbers below the axes where they would touch, unless a figure has chosen each."""
    locator = axes.xaxis.get_major_locator()
    if not isinstance(locator, MaxNLocator):
        return
    figure = cast(Figure, axes.get_figure())
    renderer: Any = FigureCanvasAgg(figure).get_renderer()
    for count in range(len(axes.get_xticks()) - 1, 0, -1):
        if not _touching(axes, renderer):
            return
        locator.set_params(nbins=count)


def _touching(axes: Axes, renderer: Any) -> bool:
    """Whether numbers below the axes are closer than ``APART``."""
    low, high = sorted(axes.get_xlim())
    shown = [
        x for x in axes.get_xticklabels() if x.get_text() and low <= x.get_position()[0] <= high
    ]
    boxes = [label.get_window_extent(renderer) for label in shown]
    ends = sorted((box.x0, box.x1) for box in boxes)
    return any(b - a < APART for (_, a), (b, _) in pairwise(ends))


def fit(figure: Figure, legend: Legend) -> None:
    """Names below each other where side by side they are wider than the figure; room for them."""
    renderer: Any = FigureCanvasAgg(figure).get_renderer()
    if legend.get_window_extent(renderer).width > figure.bbox.width:
        legend = _listed(figure, legend)
    box = legend.get_window_extent(renderer)
    if box.y0 < figure.bbox.height / 2:  # it stands below everything
        return
    boxes = [axes.get_tightbbox(renderer) for axes in figure.axes if axes.get_visible()]
    more = (max(own.y1 for own in boxes if own) + ROOM - box.y0) / figure.dpi
    if more > 0.0:
        top = max(axes.get_position(original=True).y1 for axes in figure.axes)
        _stretch(figure, [0.0, top, 1.0], [0.0, 0.0, more])


def _listed(figure: Figure, legend: Legend) -> Legend:
    """The same legend in one column."""
    texts, handles = legend.get_texts(), cast(Any, legend.legend_handles)
    size = float(texts[0].get_fontsize())
    names = [text.get_text() for text in texts]
    found = figure.legend(handles, names, fontsize=size, frameon=False, loc="upper center")
    for text in found.get_texts():
        text.set_parse_math(False)
    legend.remove()
    return found
