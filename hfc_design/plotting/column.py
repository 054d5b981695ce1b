"""Layout of a page's figure for the column of a paper: narrower, with its text still legible.

Letters, lines, margins and heights are scaled by ``SMALLER``; widths are fitted to the column; then
room is made for legends, and for adjacent texts and numbers. Nothing is drawn again, so that this
works on the figures of a user's own kind too.
"""

from collections.abc import Iterable
from itertools import pairwise
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis, Tick
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.offsetbox import PackerBase
from matplotlib.patches import Patch
from matplotlib.text import Annotation, Text
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox

#: Scale factor of letters, lines and margins of a page.
SMALLER = 0.8
#: Scale factor of gaps between columns, which contain numbers with possibly the smallest letters.
GAPS = 0.9
#: Smallest and largest letters of a paper's figure [pt].
LEAST, MOST = 7.0, 9.0
#: Adjacent texts that would touch, such as numbers in cells: their smallest size [pt], and the
#: share of the available width that they then take.
CELL, FILLED = 5.0, 0.85
#: Least distance of a legend from the axes below it, and between numbers of an axis [in / 100].
ROOM, APART = 3.0, 5.0


def in_column(figure: Figure, width: float) -> None:
    """Change a ``figure`` into one that is ``width`` [in] wide."""
    before, height = (float(x) for x in figure.get_size_inches())
    ends = {axes: _ends(figure, axes, width) for axes in figure.axes}
    labels = {axes: _label_place(axes) for axes in figure.axes}
    figure.set_size_inches(width, SMALLER * height)
    for axes, (left, right) in ends.items():
        box = axes.get_position(original=True)
        axes.set_position((left, box.y0, right - left, box.height))
        if labels[axes]:
            axes.yaxis.set_label_coords(SMALLER * labels[axes] / ((right - left) * width), 0.5)
    ticks = {part for tick in figure.findobj(Tick) for part in tick.findobj()}
    for artist in figure.findobj(lambda artist: artist not in ticks):
        _shrink(artist)
    for axis in figure.findobj(Axis):
        _shrink_ticks(axis)
    _lower(figure, width / (SMALLER * before))
    for axes in figure.axes:
        _part_texts(axes)
        _thin_ticks(axes)
    for legend in [*figure.legends]:
        _fit(figure, legend)


def _ends(figure: Figure, axes: Axes, width: float) -> tuple[float, float]:
    """Return the left and right end of axes in the new figure, as shares of the ``width``.

    Margins are scaled by ``SMALLER``, and the axes fill the rest; in a grid the columns share the
    width without the gaps.
    """
    before, margins = figure.get_figwidth(), figure.subplotpars
    share = SMALLER * before / width
    places = [0.0, margins.left, margins.right, 1.0]
    moved = [0.0, share * margins.left, 1.0 - share * (1.0 - margins.right), 1.0]
    box, spec = axes.get_position(original=True), axes.get_subplotspec()
    if spec is None:
        left, right = np.interp([box.x0, box.x1], places, moved)
        return float(left), float(right)
    *_, lefts, rights = spec.get_gridspec().get_grid_positions(figure)
    gaps = GAPS * before / width * (lefts[1:] - rights[:-1])
    start, end = np.interp([lefts[0], rights[-1]], places, moved)
    widths = (rights - lefts) * (end - start - gaps.sum()) / (rights - lefts).sum()
    begins = start + np.concatenate([[0.0], (widths[:-1] + gaps).cumsum()])
    first, last = spec.colspan.start, spec.colspan.stop - 1
    return float(begins[first]), float(begins[last] + widths[last])


def _label_place(axes: Axes) -> float:
    """Return the position of the y axis' label from the axis [in], negative; 0 if automatic."""
    x, _ = axes.yaxis.label.get_position()
    box = axes.get_position(original=True)
    return x * box.width * cast(Figure, axes.get_figure()).get_figwidth() if -1.0 < x < 0.0 else 0.0


def _shrink_ticks(axis: Axis) -> None:
    """Shrink ticks and their numbers, including those that are created later."""
    each: Any = {"major": axis.get_major_ticks(1)[0], "minor": axis.get_minor_ticks(1)[0]}
    for which, tick in each.items():
        axis.set_tick_params(
            which=which,
            labelsize=_size(tick.label1),
            length=SMALLER * tick.tick1line.get_markersize(),
            width=SMALLER * tick.tick1line.get_markeredgewidth(),
            pad=SMALLER * tick.get_pad(),
        )


def _shrink(artist: Any) -> None:
    """Shrink letters and lines of an artist that is not a tick."""
    if isinstance(artist, Text):
        artist.set_fontsize(_size(artist))
        if isinstance(artist, Annotation) and artist.anncoords == "offset points":
            artist.xyann = (SMALLER * artist.xyann[0], SMALLER * artist.xyann[1])
    elif isinstance(artist, Line2D | Patch):
        artist.set_linewidth(SMALLER * artist.get_linewidth())
    elif isinstance(artist, PackerBase):  # of a legend
        artist.pad = artist.pad and SMALLER * artist.pad
        artist.sep = artist.sep and SMALLER * artist.sep
    if isinstance(artist, Line2D):
        artist.set_markersize(SMALLER * artist.get_markersize())


def _size(text: Text) -> float:
    return min(max(SMALLER * float(text.get_fontsize()), LEAST), MOST)


def _lower(figure: Figure, share: float) -> None:
    """Reduce the height of axes with equal scales by the ``share`` lost from their width."""
    height = figure.get_figheight()
    for axes in figure.axes:
        if axes.get_aspect() != "auto" and share < 1.0:
            box = axes.get_position(original=True)
            less = (1.0 - share) * box.height * height
            _stretch(figure, [0.0, box.y0, box.y1, 1.0], [0.0, 0.0, -less, -less])


def _stretch(figure: Figure, places: list[float], more: list[float]) -> None:
    """Move axes, and increase the height of the figure by the last of ``more`` [in].

    Args:
        figure: the whole figure.
        places: heights in it, from 0 to 1.
        more: upward shift of each of them [in]; interpolated between them.
    """
    before = figure.get_figheight()
    after = before + more[-1]
    ends = [(before * place + up) / after for place, up in zip(places, more, strict=True)]
    for axes in figure.axes:
        box = axes.get_position(original=True)
        low, high = np.interp([box.y0, box.y1], places, ends)
        axes.set_position((box.x0, low, box.width, high - low))
    figure.set_figheight(after)


def _extents(figure: Figure, artists: Iterable[Text | Legend]) -> list[Bbox]:
    """Return the bounding boxes of artists in a figure, in dots."""
    renderer: Any = FigureCanvasAgg(figure).get_renderer()
    return [artist.get_window_extent(renderer) for artist in artists]


def _part_texts(axes: Axes) -> None:
    """Reduce the size of texts in the axes that would touch side by side."""
    texts = [text for text in axes.texts if text.get_horizontalalignment() == "center"]
    boxes = _extents(cast(Figure, axes.get_figure()), texts)
    shares = [1.0]
    for a, b in pairwise(sorted(boxes, key=lambda box: (round(box.y0), box.x0))):
        place = (b.x0 + b.x1 - a.x0 - a.x1) / 2
        if round(a.y0) == round(b.y0) and place > 0.0:
            shares.append(FILLED * 2 * place / (a.width + b.width))
    for text in texts if min(shares) < FILLED else ():
        text.set_fontsize(max(min(shares) * float(text.get_fontsize()), CELL))


def _thin_ticks(axes: Axes) -> None:
    """Show fewer numbers below the axes if they would touch, unless the figure fixes them."""
    locator = axes.xaxis.get_major_locator()
    if isinstance(locator, MaxNLocator):
        for count in range(len(axes.get_xticks()) - 1, 0, -1):
            if not _touching(axes):
                return
            locator.set_params(nbins=count)


def _touching(axes: Axes) -> bool:
    """Return True if numbers below the axes are closer than ``APART``."""
    low, high = sorted(axes.get_xlim())
    labels = [x for x in axes.get_xticklabels() if low <= x.get_position()[0] <= high]
    boxes = _extents(cast(Figure, axes.get_figure()), (x for x in labels if x.get_text()))
    ends = sorted((box.x0, box.x1) for box in boxes)
    return any(b - a < APART for (_, a), (b, _) in pairwise(ends))


def _fit(figure: Figure, legend: Legend) -> None:
    """Make room for a legend, in one column if its columns are wider than the figure."""
    (box,) = _extents(figure, [legend])
    if box.width > figure.bbox.width:
        (box,) = _extents(figure, [_listed(figure, legend)])
    if box.y0 < figure.bbox.height / 2:  # it stands below everything
        return
    renderer: Any = FigureCanvasAgg(figure).get_renderer()
    boxes = [axes.get_tightbbox(renderer) for axes in figure.axes if axes.get_visible()]
    more = (max(x.y1 for x in boxes if x) + ROOM - box.y0) / figure.dpi
    if more > 0.0:
        top = max(axes.get_position(original=True).y1 for axes in figure.axes)
        _stretch(figure, [0.0, top, 1.0], [0.0, 0.0, more])


def _listed(figure: Figure, legend: Legend) -> Legend:
    """Replace a legend by the same one in a single column, and return that."""
    texts = legend.get_texts()
    names, handles = [text.get_text() for text in texts], cast(Any, legend.legend_handles)
    look: dict[str, Any] = {"fontsize": float(texts[0].get_fontsize()), "loc": "upper center"}
    drawn = figure.legend(handles, names, frameon=False, **look)
    for text in drawn.get_texts():
        text.set_parse_math(False)
    legend.remove()
    return drawn
