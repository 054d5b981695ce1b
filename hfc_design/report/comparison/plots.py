"""Pictures of a comparison: errors on all machines, ratios, motions for print, contours."""

from collections.abc import Sequence
from math import ceil, floor, isnan, log10
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullFormatter

from hfc_design.core.numbers import Floats, Indices
from hfc_design.motion.contour import Contour, nearest
from hfc_design.motion.trajectories import Circle
from hfc_design.plotting.figure import (
    above,
    colour,
    distinct,
    finish,
    framed,
    gridded,
    label_margin,
    plain,
    round_above,
    stroke,
)
from hfc_design.report.circle import BAR, ball_bar
from hfc_design.report.comparison.tables import titled
from hfc_design.report.comparison.traces import extremes
from hfc_design.report.panels import Panel, draw, stacked
from hfc_design.report.plots import SMALLEST, draw_path
from hfc_design.simulation.comparison import Comparison, Difference, MotionComparison

#: Slices of time of a printed curve.
SLICES = 150
#: Ratio of the ends of an axis above which powers of ten are enough as ticks.
MANY = 100.0
#: Round steps for an axis of less than a decade.
ROUND = MaxNLocator(6, steps=[1, 2, 5, 10])
#: Line width of deviations from a path, which are rough curves.
THIN = {"lw": 1.0}
#: Slices of a deviation from a path.
AROUND = 360
#: Ratios that are further from 1 are drawn at the edge.
FURTHEST = 1000.0
#: Size of letters [pt].
SIZE = 8.0


def machines(comparison: Comparison) -> Figure:
    """Draw the error of every design in every motion: from the 5 % to the 95 % machine, the median.

    A line that ends in a triangle continues to machines that are not stable; the share of stable
    machines is to the right of the line.
    """
    bouts = [bout for bout in comparison.bouts if bout.scenario is not None]
    names = list(comparison.designs)
    spans = [[side.span(bout.compared()[0]) for side in bout.sides.values()] for bout in bouts]
    known = [x for row in spans for span in row for x in span if x is not None and x > 0.0]
    main = bouts[0].compared()[0]
    label, factor = titled(main, bouts[0].meanings[main], known)
    low, high = (factor * x for x in (min(known, default=1.0), max(known, default=1.0)))
    edge = high * (high / low) ** 0.1
    heads = {bout.name.rpartition(".")[0] for bout in bouts}
    alone = [bout.name.rpartition(".")[2] if len(heads) == 1 else bout.name for bout in bouts]
    labels = [motion_label(x) for x in alone]
    top = 0.15 + legend_room(len(names), 2)
    height = 0.85 + top + 0.15 * (len(names) + 1) * len(bouts)
    figure = framed(height, top=top, left=label_margin(labels, SIZE), right=0.6, bottom=0.55)
    axes = figure.subplots()
    for k, (bout, row) in enumerate(zip(bouts, spans, strict=True)):
        for j, (span, side) in enumerate(zip(row, bout.sides.values(), strict=True)):
            where = k * (len(names) + 1) + j
            least, median, most = (edge if x is None else factor * x for x in span)
            axes.plot([least, most], [where] * 2, color=colour(j), lw=2)
            if span[1] is not None:
                axes.plot(median, where, "o", ms=4.5, mew=0, color=colour(j))
            if span[2] is None:
                axes.plot(edge, where, ">", ms=4.5, mew=0, color=colour(j), clip_on=False)
            share = f"{100 * side.stable.mean():.3g} %"
            _right_of(axes, share, (1.0, where), (6, 0), "data", color=colour(j), va="center")
    _right_of(axes, "stable", (1.0, 1.0), (4, 3), "axes fraction", color="0.25")
    axes.set_xscale("log")
    axes.set_xlim(low / 1.2, edge)
    _few_decades(axes)
    gridded(axes, label)
    _rows(axes, labels, dict(enumerate(names)), 4.5)
    above(figure, axes, 8)
    return figure


def _right_of(
    axes: Axes, text: str, at: tuple[float, float], off: tuple[int, int], y: str, **look: Any
) -> None:
    """Write a text right of the axes, shifted by ``off`` [pt]; ``y``: the vertical coordinates."""
    places: Any = {"xycoords": ("axes fraction", y), "textcoords": "offset points"}
    axes.annotate(text, at, xytext=off, fontsize=7.5, **places, **look)


def _rows(axes: Axes, motions: Sequence[str], designs: dict[int, str], size: float) -> None:
    """Label the rows: for each motion one per design (number of the colour -> name), and a gap."""
    count = len(designs)
    middle = np.arange(len(motions)) * (count + 1) + 0.5 * (count - 1)
    axes.set_yticks(middle, motions, fontsize=SIZE, parse_math=False)
    axes.set_ylim(len(motions) * (count + 1) - 1.3, -0.7)
    axes.tick_params(axis="y", length=0)
    for k, label in zip(designs, distinct(designs.values(), 30).values(), strict=True):
        axes.plot([], [], "o-", ms=size, mew=0, lw=2, color=colour(k), label=label)


def motion_label(name: str) -> str:
    """Return the label of a motion beside an axis, in two lines at most."""
    return fill(plain(name, 26), 14)


def _few_decades(axes: Axes) -> None:
    """Give a logarithmic x axis ticks with plain numbers if powers of ten would be too few."""
    low, high = axes.get_xlim()
    if high > MANY * low:
        return
    decades = range(floor(log10(low)), ceil(log10(high)) + 1)
    ticks = [x for k in decades for step in (1, 2, 5) if low <= (x := step * 10.0**k) <= high]
    if len(ticks) < 3:
        ticks = [x for x in ROUND.tick_values(low, high) if low <= x <= high]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks], fontsize=8)
    axes.xaxis.set_minor_formatter(NullFormatter())


def motions(bout: MotionComparison, shown: Sequence[Panel]) -> Figure:
    """Draw the panels ``shown`` of a motion, one below the other."""
    time = next(iter(bout.results.values())).motion.time
    figure, places = stacked(shown, legend_room(len(bout.results) + 1, 3))
    for axes, panel in zip(places, shown, strict=True):
        labels = distinct(panel.curves, 24)
        styles = (stroke(k) | {"label": labels[name]} for k, name in enumerate(panel.curves))
        draw(axes, time, panel, styles, _drawn)
        finish(axes, panel.label)
    places[-1].set_xlabel("time [s]")
    above(figure, places[-1], 8, 3)
    return figure


def _drawn(time: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Return a curve with lowest and highest value of each slice, at its beginning and middle."""
    drawn, size = extremes(values, SLICES)
    if size == 1:
        return time, drawn
    return time[0] + 0.5 * size * (time[1] - time[0]) * np.arange(len(drawn)), drawn


def legend_room(names: int, columns: int) -> float:
    """Return the height of a legend of so many names [in]."""
    return 0.25 + 0.17 * ceil(names / columns)


def contours(bout: MotionComparison) -> tuple[Figure, str] | None:
    """Draw the deviations of all designs from a path in X-Y; also return the scale as a text.

    They are drawn normal to the path; around a circle by angle, as on a ball bar plot. Diverged
    motions are left out. None: no design has such a path.
    """
    labels = distinct(bout.results, 24)
    paths = ((k, name, one.motion.contour) for k, (name, one) in enumerate(bout.results.items()))
    known = [
        (stroke(k) | THIN | {"label": labels[name]}, path)
        for k, name, path in paths
        if path and not path.any_axes and np.isfinite(path.error).all()
    ]
    if not known:
        return None
    first = known[0][1]
    largest = max(float(np.abs(path.error).max()) for _, path in known)
    division = round_above(max(largest / 2, SMALLEST))
    around = isinstance(first.trajectory, Circle)
    side = 0.45 if around else 0.9
    top = 0.4 + legend_room(len(known), 3)
    figure = framed(4.65 + top, top=top, left=side, right=min(side, 0.45), bottom=side / 2 + 0.1)
    axes, scale = (_ball_bar if around else _across)(figure, known, division)
    above(figure, axes, 8, 3)
    length = f"{division:g} {first.unit} ({1e3 * division * first.millimetres:.3g} µm)"
    return figure, f"One division, from one grey line to the next, is {length}; {scale}."


Known = list[tuple[dict[str, Any], Contour]]  # how each design is drawn, and its path


def _ball_bar(figure: Figure, known: Known, division: float) -> tuple[Axes, str]:
    """Draw the radius against the angle; return the axes, and the scale as a text."""
    axes: Any = figure.add_subplot(projection="polar")
    ball_bar(axes, [(np.arctan2(*x.actual[::-1]), x.error, style) for style, x in known], division)
    path = known[0][1]
    assert isinstance(path.trajectory, Circle)
    enlarged = BAR * path.trajectory.radius_mm / (division * path.millimetres)
    text = f"deviations from the black circle are {enlarged:.0f} times enlarged"
    return axes, f"{text}, outwards is positive"


def _across(figure: Figure, known: Known, division: float) -> tuple[Axes, str]:
    """Draw the path with the deviations across it; return the axes, and the scale as a text."""
    path = known[0][1]
    trajectory = path.planar
    axes = figure.subplots()
    enlarged = draw_path(axes, trajectory, division * path.millimetres)
    for style, path in known:
        base = nearest(trajectory, path.samples, path.actual).point
        drawn = base + enlarged * (path.actual - base)
        axes.plot(*drawn[:, _rough(path.error)], **style)
    return axes, f"deviations from the black path are {enlarged:.0f} times enlarged"


def _rough(error: Floats) -> Indices:
    """Return indices of the samples that a picture needs, including those of largest errors."""
    size = max(len(error) // AROUND, 1)
    starts = np.arange(0, len(error), size)
    parts = np.split(np.abs(error), starts[1:])
    ends = [start + part.argmax() for start, part in zip(starts, parts, strict=True)]
    return np.unique(np.concatenate([starts, ends, [len(error) - 1]]))


def ratios(comparison: Comparison) -> Figure:
    """Draw the median ratio, with interval, of the first design to each other; a row per motion.

    One column for the first metric of each motion, and one for the change of the command.
    """
    first, *others = comparison.designs
    keys = {bout.name: bout.compared() for bout in comparison.bouts}
    columns = {
        "error, rms": {motion: keys_of[:1] for motion, keys_of in keys.items()},
        "change of the\ncommand, rms": {
            motion: [key for key in keys_of if "_change" in key] for motion, keys_of in keys.items()
        },
    }
    drawn = {title: of_motions for title, of_motions in columns.items() if any(of_motions.values())}
    labels = [motion_label(motion) for motion in keys]
    top = 0.28 + legend_room(len(others), 2)
    rows = len(keys) * (len(others) + 1) - 1
    figure = framed(0.55 + top + 0.2 * rows, top=top, left=label_margin(labels, SIZE))
    shape: Any = {"sharey": True, "squeeze": False, "gridspec_kw": {"wspace": 0.1}}
    places = figure.subplots(1, len(drawn), **shape)[0]
    for axes, (title, metrics) in zip(places, drawn.items(), strict=True):
        points = [
            (k * (len(others) + 1) + others.index(one.second), others.index(one.second) + 1, one)
            for k, (motion, keys_of) in enumerate(metrics.items())
            for key in keys_of
            for one in comparison.of(motion, key)
            if one.first == first and not isnan(one.ratio)
        ]
        _forest(axes, points)
        axes.set_title(title, fontsize=9)
    over = "the other design" if others[1:] else plain(others[0], 24)
    figure.supxlabel(f"{plain(first, 24)} / {over} [1]", fontsize=SIZE, parse_math=False)
    _rows(places[0], labels, dict(enumerate(others, 1)), 5)
    above(figure, places[0], SIZE)
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
    # Only three numbers, so that they do not touch in a narrow column.
    step = 10.0**last if last else 5.0 if most >= 5.0 else 2.0
    axes.set_xticks([1 / step, 1.0, step], [f"{x:g}" for x in (1 / step, 1.0, step)], fontsize=SIZE)
    axes.set_xticks([10.0**k for k in range(-last, last + 1)], minor=True)
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(axis="y", length=0)
    gridded(axes)
