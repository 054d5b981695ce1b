"""The ratios of a comparison with their intervals, a row each motion."""

from collections.abc import Sequence
from math import floor, isnan, log10

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from hfc_design.pictures.figure import above, beside, distinct, framed, gridded, plain
from hfc_design.report.comparison.plots import legend_room, motion_label
from hfc_design.report.searches import colour
from hfc_design.simulation.comparison import Comparison, Difference

#: A ratio that is further from 1 stands at the edge.
FURTHEST = 1000.0
#: Letters [pt].
SIZE = 8.0


def ratios(comparison: Comparison) -> Figure:
    """Median ratio and its interval, of the first design over every other, a row each motion.

    A column for the first metric of each motion, and one for the change of the command.
    """
    first, *others = comparison.designs
    bouts = comparison.bouts
    each = {
        "error, rms": [bout.compared()[:1] for bout in bouts],
        "change of the\ncommand, rms": [
            [key for key in bout.compared() if "_change" in key] for bout in bouts
        ],
    }
    drawn = {title: keys for title, keys in each.items() if any(keys)}
    rows = len(bouts) * (len(others) + 1) - 1
    top = 0.28 + legend_room(len(others), 2)
    labels = [motion_label(bout.name) for bout in bouts]
    figure = framed(0.55 + top + 0.2 * rows, top=top, left=beside(labels, SIZE))
    space = {"wspace": 0.1}
    columns = figure.subplots(1, len(drawn), sharey=True, squeeze=False, gridspec_kw=space)[0]
    for axes, (title, keys) in zip(columns, drawn.items(), strict=True):
        points = [
            (k * (len(others) + 1) + j, j + 1, one)
            for k, (bout, own) in enumerate(zip(bouts, keys, strict=True))
            for key in own
            for j, other in enumerate(others)
            for one in comparison.of(bout.name, key)
            if (one.first, one.second) == (first, other) and not isnan(one.ratio)
        ]
        _forest(axes, points)
        axes.set_title(title, fontsize=9)
    middle = np.arange(len(bouts)) * (len(others) + 1) + 0.5 * (len(others) - 1)
    columns[0].set_yticks(middle, labels, fontsize=SIZE, parse_math=False)
    columns[0].set_ylim(rows - 0.3, -0.7)
    over = "the other design" if others[1:] else plain(others[0], 24)
    told = f"{plain(first, 24)} / {over} [1]"
    figure.supxlabel(told, fontsize=SIZE, parse_math=False)
    for j, label in enumerate(distinct(others, 30).values(), 1):
        columns[0].plot([], [], "o-", ms=5, mew=0, lw=2, color=colour(j), label=label)
    above(figure, columns[0], SIZE)
    return figure


def _forest(axes: Axes, drawn: Sequence[tuple[int, int, Difference]]) -> None:
    values = [x for *_, one in drawn for x in (one.ratio, *(one.ratio_interval or ()))]
    known = [abs(log10(x)) for x in values if 0.0 < x < np.inf]
    most = min(max(2.0, 1.3 * 10 ** max(known, default=0.0)), FURTHEST)
    if any(x in (0.0, np.inf) for x in values):
        most = min(3.0 * most, FURTHEST)

    def inside(x: float) -> float:
        return float(np.clip(x, 1 / most, most))

    axes.axvline(1.0, color="0.25", lw=1)
    for where, k, one in drawn:
        if one.ratio_interval:
            axes.plot([inside(x) for x in one.ratio_interval], [where] * 2, color=colour(k), lw=2)
        marker = "o" if 1 / most < one.ratio < most else "<" if one.ratio < 1.0 else ">"
        axes.plot(inside(one.ratio), where, marker, ms=5, color=colour(k), mew=0, clip_on=False)
    axes.set_xscale("log")
    axes.set_xlim(1 / most, most)
    last = floor(log10(most)) if most >= 10.0 else 0
    # Three numbers, which stand apart in a narrow column too.
    step = 10.0**last if last else 5.0 if most >= 5.0 else 2.0
    axes.set_xticks([1 / step, 1.0, step], [f"{x:g}" for x in (1 / step, 1.0, step)], fontsize=SIZE)
    axes.set_xticks([10.0**k for k in range(-last, last + 1)], minor=True)
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(axis="y", length=0)
    gridded(axes)
