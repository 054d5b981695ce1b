"""Pictures of a comparison: errors on all machines, ratios, motions for print, contours."""

from collections.abc import Sequence
from math import ceil, floor, isnan, log10
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.projections.polar import PolarAxes
from matplotlib.ticker import MaxNLocator, NullFormatter

from hfc_design.core.numbers import Floats, Indices
from hfc_design.motion.contour import Contour, nearest
from hfc_design.motion.trajectories import Circle
from hfc_design.pictures.figure import (
    above,
    beside,
    distinct,
    finish,
    framed,
    gridded,
    plain,
    round_above,
)
from hfc_design.report.comparison.tables import named
from hfc_design.report.comparison.traces import Panel, extremes
from hfc_design.report.plots import POINTS, SHARE, SMALLEST
from hfc_design.report.plots import beside as parallel
from hfc_design.report.searches import colour, stroke
from hfc_design.simulation.comparison import Bout, Comparison, Difference

#: Slices of time of a curve that is printed.
SLICES = 150
#: An axis whose ends are further apart than by this factor has powers of ten enough.
MANY = 100.0
#: Round steps for an axis of less than a decade.
ROUND = MaxNLocator(6, steps=[1, 2, 5, 10])
#: Deviations from a path are rough.
THIN = {"lw": 1.0}
#: Points of a circle, and slices of a deviation from a path.
AROUND = 360
#: Share of the radius that a division takes on the plot of a ball bar.
BAR = 0.14


def machines(comparison: Comparison) -> Figure:
    """Error of every design in every motion: from the 5 % to the 95 % machine, and the median.

    A line that ends in a triangle goes on to machines that are not stable; the share of those that
    are stands at its right.
    """
    bouts = [bout for bout in comparison.bouts if bout.scenario is not None]
    names, rows = list(comparison.designs), len(comparison.designs) + 1
    spans = [[side.span(bout.compared()[0]) for side in bout.sides.values()] for bout in bouts]
    known = [x for row in spans for span in row for x in span if x is not None and x > 0.0]
    label, factor = named(bouts[0], bouts[0].compared()[0], known)
    low, high = (factor * x for x in (min(known, default=1.0), max(known, default=1.0)))
    edge = high * (high / low) ** 0.1
    top = 0.15 + legend_room(len(names), 2)
    height = 0.85 + top + 0.15 * rows * len(bouts)
    heads = {bout.name.rpartition(".")[0] for bout in bouts}
    alone = [bout.name.rpartition(".")[2] if len(heads) == 1 else bout.name for bout in bouts]
    lines = [motion_label(x) for x in alone]
    left = beside(lines, 8.0)
    figure = framed(height, top=top, left=left, right=0.6, bottom=0.55)
    axes = figure.subplots()
    for k, (bout, row) in enumerate(zip(bouts, spans, strict=True)):
        for j, (span, side) in enumerate(zip(row, bout.sides.values(), strict=True)):
            where, ends = k * rows + j, [edge if x is None else factor * x for x in span]
            axes.plot([ends[0], ends[2]], [where] * 2, color=colour(j), lw=2)
            if span[1] is not None:
                axes.plot(ends[1], where, "o", ms=4.5, mew=0, color=colour(j))
            if span[2] is None:
                axes.plot(edge, where, ">", ms=4.5, mew=0, color=colour(j), clip_on=False)
            told: dict[str, Any] = {"fontsize": 7.5, "va": "center", "color": colour(j)}
            told |= {"xytext": (6, 0), "textcoords": "offset points"}  # a triangle stands there
            share, place = f"{100 * side.stable.mean():.3g} %", ("axes fraction", "data")
            axes.annotate(share, (1.0, where), xycoords=place, **told)
    middle = np.arange(len(bouts)) * rows + 0.5 * (len(names) - 1)
    over: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points"}
    axes.annotate("stable", (1.0, 1.0), xytext=(4, 3), fontsize=7.5, color="0.25", **over)
    axes.set_yticks(middle, lines, fontsize=8, parse_math=False)
    axes.set_ylim(rows * len(bouts) - 1.3, -0.7)
    axes.set_xscale("log")
    axes.set_xlim(low / 1.2, edge)
    _few_decades(axes)
    axes.tick_params(axis="y", length=0)
    gridded(axes, label)
    for j, label in enumerate(distinct(names, 30).values()):
        axes.plot([], [], "o-", ms=4.5, mew=0, lw=2, color=colour(j), label=label)
    above(figure, axes, 8)
    return figure


def motion_label(name: str) -> str:
    """The name of a motion beside an axis, in two lines at most."""
    return fill(plain(name, 26), 14)


def _few_decades(axes: Axes) -> None:
    """Ticks of a logarithmic x axis with plain numbers where powers of ten would be too few."""
    low, high = axes.get_xlim()
    if high > MANY * low:
        return
    decades = range(floor(log10(low)), ceil(log10(high)) + 1)
    ticks = [x for k in decades for step in (1, 2, 5) if low <= (x := step * 10.0**k) <= high]
    if len(ticks) < 3:
        ticks = [x for x in ROUND.tick_values(low, high) if low <= x <= high]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks], fontsize=8)
    axes.xaxis.set_minor_formatter(NullFormatter())


def motions(bout: Bout, shown: Sequence[Panel]) -> Figure:
    """The panels below each other."""
    time = next(iter(bout.found.values())).motion.time
    top = legend_room(len(bout.found) + 1, 3)
    figure = framed(1.3 * len(shown) + 0.5 + top, top=top)
    space = {"hspace": 0.12}
    grid = figure.subplots(len(shown), 1, sharex=True, squeeze=False, gridspec_kw=space)[:, 0]
    for axes, panel in zip(grid, shown, strict=True):
        labels = distinct(panel.curves, 24)
        for k, (name, values) in enumerate(panel.curves.items()):
            axes.plot(*_drawn(time, values), label=labels[name], **stroke(k))
        if panel.reference is not None:
            drawn = _drawn(time, panel.reference)
            axes.plot(*drawn, color="black", ls=":", lw=0.8, label="reference")
        finish(axes, panel.label)
        axes.margins(x=0)
    grid[-1].set_xlabel("time [s]")
    above(figure, grid[-1], 8, 3)
    return figure


def _drawn(time: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Two points of each slice of time, at its beginning and in its middle."""
    kept, size = extremes(values, SLICES)
    if size == 1:
        return time, kept
    return time[0] + 0.5 * size * (time[1] - time[0]) * np.arange(len(kept)), kept


def legend_room(names: int, columns: int) -> float:
    """Room for a legend of so many names [in]."""
    return 0.25 + 0.17 * ceil(names / columns)


def contours(bout: Bout) -> tuple[Figure, str] | None:
    """Every design's deviations from a path in X-Y, enlarged alike, and by how much; None: no such.

    They are drawn normal to the path; around a circle as a ball bar shows them, by angle. What has
    diverged is left out.
    """
    labels = distinct(bout.found, 24)
    each = enumerate((labels[name], one.motion.contour) for name, one in bout.found.items())
    known = {
        (k, label): found
        for k, (label, found) in each
        if found and not found.any_axes and np.isfinite(found.error).all()
    }
    if not known:
        return None
    first = next(iter(known.values()))
    largest = max(float(np.abs(found.error).max()) for found in known.values())
    division = round_above(max(largest / 2, SMALLEST))
    around = isinstance(first.trajectory, Circle)
    side = 0.45 if around else 0.9
    top = 0.4 + legend_room(len(known), 3)
    figure = framed(4.65 + top, top=top, left=side, right=min(side, 0.45), bottom=side / 2 + 0.1)
    axes, told = (_ball_bar if around else _across)(figure, known, division)
    above(figure, axes, 8, 3)
    length = f"{division:g} {first.unit} ({1e3 * division * first.millimetres:.3g} µm)"
    return figure, f"A division, from one grey line to the next, is {length}; {told}."


Known = dict[tuple[int, str], Contour]  # by number and label of the design


def _ball_bar(figure: Figure, known: Known, division: float) -> tuple[Axes, str]:
    """The radius against the angle."""
    axes = figure.add_subplot(projection="polar")
    assert isinstance(axes, PolarAxes)
    axes.plot(np.linspace(0.0, 2 * np.pi, AROUND), np.ones(AROUND), color="black", lw=0.9)
    for (k, label), found in known.items():
        points = _kept(found.error)
        x, y = found.actual[:, points]
        radius = 1.0 + BAR * found.error[points] / division
        axes.plot(np.unwrap(np.arctan2(y, x)), radius, **stroke(k) | THIN, label=label)
    axes.set_rticks([1.0 + BAR * k for k in (-2, -1, 1, 2)], [""] * 4)
    axes.set_rlim(0.0, 1.0 + 3.2 * BAR)
    axes.tick_params(labelsize=8)
    axes.grid(color="0.8")
    found = next(iter(known.values()))
    assert isinstance(found.trajectory, Circle)
    enlarged = BAR * found.trajectory.radius_mm / (division * found.millimetres)
    return axes, f"deviations from the black circle are {enlarged:.0f} times enlarged, outside is +"


def _across(figure: Figure, known: Known, division: float) -> tuple[Axes, str]:
    """The path with the deviations across it."""
    first = next(iter(known.values()))
    trajectory, length = first.planar, first.millimetres
    outline = trajectory.samples(np.linspace(0.0, trajectory.duration_s, POINTS))
    enlarged = SHARE * float(np.ptp(outline.position, axis=1).max()) / (division * length)
    axes = figure.subplots()
    axes.plot(*outline.position, color="black", lw=0.8, label="path")
    for offset in (-division, division):
        line = parallel(outline, enlarged * length * offset)
        axes.plot(*line, color="0.75", lw=0.8, zorder=1)
    for (k, label), found in known.items():
        base = nearest(trajectory, found.samples, found.actual).point
        drawn = base + enlarged * (found.actual - base)
        axes.plot(*drawn[:, _kept(found.error)], **stroke(k) | THIN, label=label)
    axes.set_aspect("equal", adjustable="datalim")
    gridded(axes, "X [mm]", "Y [mm]", color="0.95")
    return axes, f"deviations from the black path are {enlarged:.0f} times enlarged"


def _kept(error: Floats) -> Indices:
    """Samples that a picture needs, those with the largest errors among them."""
    size = max(len(error) // AROUND, 1)
    starts = np.arange(0, len(error), size)
    parts = np.split(np.abs(error), starts[1:])
    ends = [start + part.argmax() for start, part in zip(starts, parts, strict=True)]
    return np.unique(np.concatenate([starts, ends, [len(error) - 1]]))


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
