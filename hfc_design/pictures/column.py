"""A figure of a page laid out anew for the column of a paper: narrower, its letters still read.

Letters, lines and margins become ``SMALLER``, heights with them; widths become what the column
leaves. Nothing is drawn again, so that this works on the figures of a user's own kind too.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis, Tick
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.offsetbox import PackerBase
from matplotlib.patches import Patch
from matplotlib.text import Annotation, Text

from hfc_design.pictures.room import apart, fit, lower, thin

#: What letters, lines and margins of a page become.
SMALLER = 0.8
#: What gaps between columns become; numbers stand there, whose letters may be the least already.
GAPS = 0.9
#: Of the letters of a paper's figure [pt].
LEAST, MOST = 7.0, 9.0

Place = Callable[[float], float]  # of the page's figure -> of the paper's, as shares of the width


def in_column(figure: Figure, width: float) -> None:
    """Change a ``figure`` into one that is ``width`` [in] wide."""
    before, height = (float(x) for x in figure.get_size_inches())
    place = _places(figure, before, width)
    boxes = {axes: _box(figure, axes, place, width) for axes in figure.axes}
    labels = {axes: _label_place(axes, before) for axes in figure.axes}
    figure.set_size_inches(width, SMALLER * height)
    for axes, (left, right) in boxes.items():
        box = axes.get_position(original=True)
        axes.set_position((left, box.y0, right - left, box.height))
        if labels[axes]:
            axes.yaxis.set_label_coords(SMALLER * labels[axes] / ((right - left) * width), 0.5)
    ticks = {part for tick in figure.findobj(Tick) for part in tick.findobj()}
    for artist in figure.findobj(lambda artist: artist not in ticks):
        _smaller(artist)
    for axis in figure.findobj(Axis):
        _smaller_ticks(axis)
    lower(figure, width / (SMALLER * before))
    for axes in figure.axes:
        apart(axes)
        thin(axes)
    for legend in [*figure.legends]:
        fit(figure, legend)


def _places(figure: Figure, before: float, width: float) -> Place:
    """Where a place goes: margins become ``SMALLER``, what is between has the rest."""
    left, right = figure.subplotpars.left, figure.subplotpars.right
    share = SMALLER * before / width
    ends = [0.0, share * left, 1.0 - share * (1.0 - right), 1.0]
    return lambda x: float(np.interp(x, [0.0, left, right, 1.0], ends))


def _box(figure: Figure, axes: Axes, place: Place, width: float) -> tuple[float, float]:
    """Left and right end of axes; in a grid the columns share what the gaps leave."""
    before = figure.get_figwidth()
    box, spec = axes.get_position(original=True), axes.get_subplotspec()
    if spec is None:
        return place(box.x0), place(box.x1)
    *_, lefts, rights = spec.get_gridspec().get_grid_positions(figure)
    gaps = GAPS * before / width * (lefts[1:] - rights[:-1])
    start, end = place(lefts[0]), place(rights[-1])
    widths = (rights - lefts) * (end - start - gaps.sum()) / (rights - lefts).sum()
    begins = start + np.concatenate([[0.0], (widths[:-1] + gaps).cumsum()])
    first, last = spec.colspan.start, spec.colspan.stop - 1
    return float(begins[first]), float(begins[last] + widths[last])


def _label_place(axes: Axes, before: float) -> float:
    """How far the label of the y axis was put to the left of it [in]; 0 where it places itself."""
    x, _ = axes.yaxis.label.get_position()
    box = axes.get_position(original=True)
    return x * box.width * before if -1.0 < x < 0.0 else 0.0


def _smaller_ticks(axis: Axis) -> None:
    """Ticks and their numbers; more of them may be made later."""
    each: Any = {"major": axis.get_major_ticks(1)[0], "minor": axis.get_minor_ticks(1)[0]}
    for which, tick in each.items():
        axis.set_tick_params(
            which=which,
            labelsize=_size(tick.label1.get_fontsize()),
            length=SMALLER * tick.tick1line.get_markersize(),
            width=SMALLER * tick.tick1line.get_markeredgewidth(),
            pad=SMALLER * tick.get_pad(),
        )


def _smaller(artist: Any) -> None:
    """Letters and lines of what is no tick."""
    if isinstance(artist, Text):
        artist.set_fontsize(_size(float(artist.get_fontsize())))
        if isinstance(artist, Annotation) and artist.anncoords == "offset points":
            artist.xyann = (SMALLER * artist.xyann[0], SMALLER * artist.xyann[1])
    elif isinstance(artist, Line2D | Patch):
        artist.set_linewidth(SMALLER * artist.get_linewidth())
    elif isinstance(artist, PackerBase):  # of a legend
        artist.pad = artist.pad and SMALLER * artist.pad
        artist.sep = artist.sep and SMALLER * artist.sep
    if isinstance(artist, Line2D):
        artist.set_markersize(SMALLER * artist.get_markersize())


def _size(size: float) -> float:
    return min(max(SMALLER * size, LEAST), MOST)
