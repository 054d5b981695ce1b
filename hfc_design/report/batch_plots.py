"""Final scores of searches, and distributions of a design's metrics over machines."""

from collections.abc import Mapping, Sequence
from math import ceil
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullLocator

from hfc_design.core.numbers import Floats
from hfc_design.plotting.figure import (
    COLOURS,
    LABEL,
    LINE,
    OTHER,
    OWN,
    above,
    colour,
    drawable,
    finish,
    framed,
    gridded,
    list_above,
    logarithmic,
    plain,
)
from hfc_design.plotting.numbers import readable
from hfc_design.report.comparison.tables import titled
from hfc_design.simulation.acceptance import Usable
from hfc_design.simulation.monte_carlo import QUANTILES, Robustness
from hfc_design.simulation.usable_tables import TITLES

#: Width of a picture with long labels [in].
WIDE = 8.4
COLUMNS, PANEL = 2, 1.2  # panels of distributions side by side; height of each [in]
TITLE = 30  # letters of a line above such a panel
#: Ratios closer to 1 than this factor count as close.
CLOSE = 1.1
#: Share of the machines that a panel shows: a few very large values would squeeze all others.
SHOWN = 0.99


def outcomes(scores: Mapping[str, Floats], measure: str) -> Figure:
    """Draw the final score of every run, a column for each group, with median and quartiles.

    Args:
        scores: (runs,) scores of each group, at least one, by its label, which begins with its
            number and a colon; values that are not finite are not drawn.
        measure: name of the scores, merit or fitness.
    """
    top = 0.15 + LINE * len(scores)
    figure = framed(3.05 + top, top)
    axes = figure.subplots()
    for k, (label, numbers) in enumerate(scores.items()):
        axes.plot([], [], "o", ms=4.5, mew=0, color=colour(k), label=plain(label))
        values = drawable(numbers[np.isfinite(numbers)])
        if len(values) == 0:
            continue
        share = (np.arange(len(values)) + 0.5) / len(values) - 0.5
        dots = np.unique(np.round(np.linspace(0, len(values) - 1, 400)).astype(int))
        around, heights = k + 0.5 * share[dots], np.sort(values)[dots]
        axes.plot(around, heights, "o", ms=4.5, mew=0, color=colour(k), alpha=0.6)
        low, median, high = np.quantile(values, (0.25, 0.5, 0.75))
        axes.plot([k] * 2, [low, high], color="0.25", lw=1)
        axes.plot([k - 0.3, k + 0.3], [median] * 2, color="0.1", lw=2)
    finish(axes, f"final {measure}", "group")
    logarithmic(axes)
    axes.set_xlim(-0.6, len(scores) - 0.4)
    axes.set_xticks(range(len(scores)), [label.partition(":")[0] for label in scores])
    list_above(figure)
    return figure


def ratios(labels: Sequence[str], values: Sequence[float]) -> Figure:
    """Draw positive ratios of simulated to published numbers, each in a line, from the top down."""
    place = np.arange(len(values))
    height = 0.75 + 0.2 * len(values)
    figure = Figure(figsize=(WIDE, height))
    figure.subplots_adjust(left=0.58, right=0.98, bottom=0.5 / height, top=1 - 0.1 / height)
    axes = figure.subplots()
    axes.axvspan(1 / CLOSE, CLOSE, color=COLOURS[2], alpha=0.2, lw=0)
    axes.axvline(1.0, color="0.25", lw=1)
    axes.hlines(place, 1.0, values, color="0.6", lw=1)
    axes.plot(values, place, "o", ms=5, mew=0, color=COLOURS[0])
    most = max(2.0, 1.3 * max(*values, *(1 / value for value in values), 1.0))
    axes.set_xscale("log")
    axes.set_xlim(1 / most, most)
    # Plain numbers, few enough to stand side by side.
    steps, last = (1.0, 2.0, 5.0) if most < 12 else (1.0,), ceil(np.log10(most))
    every = ceil((2 * last + 1) / 9)
    decades = [decade for decade in range(-last, last + 1) if decade % every == 0]
    numbers = [step * 10.0**decade for decade in decades for step in steps]
    ticks = [tick for tick in numbers if 1 / most <= tick <= most]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.xaxis.set_minor_locator(NullLocator())
    names = [plain(label, 2 * LABEL) for label in labels]
    axes.set_yticks(place, names, fontsize=6.5, parse_math=False)
    axes.set_ylim(len(values) - 0.5, -0.5)
    axes.grid(color="0.9", axis="x")
    axes.set_axisbelow(True)
    axes.set_xlabel("simulated / published")
    return figure


def distributions(judged: Robustness | Usable, title: str) -> Figure:
    """Draw for each metric the share of machines up to a value, with the nominal value dashed.

    ``Robustness``: only stable machines, with a band from the 5 % to the 95 % quantile; metrics
    that are the same on every machine are left out. ``Usable``: all machines, also those that do
    not pass, in a row for each motion and a column for each measure.
    """
    if isinstance(judged, Usable):
        return _in_motions(judged, title)
    drawn = [key for key in judged.values if np.unique(judged.spread_of(key)).size > 1]
    rows = max(-(-len(drawn) // COLUMNS), 1)
    share = f"{100 * judged.stable.mean():.4g} % stable"
    machines = f"{len(judged.stable)} machines, parameters ±{100 * judged.spread:g} %, {share}"
    heading = [*filter(None, [title]), machines]
    top = 0.35 + 0.2 * len(heading)
    height = PANEL * rows + top + 0.35
    figure = framed(height, top=top, left=0.65, right=0.2, bottom=0.6)
    panels = figure.subplots(
        rows, COLUMNS, sharey=True, squeeze=False, gridspec_kw={"hspace": 0.8, "wspace": 0.12}
    )
    for axes, key in zip(panels.flat, drawn, strict=False):
        values = judged.spread_of(key)
        called, factor = titled(key, judged.meanings[key], np.quantile(values, QUANTILES).tolist())
        only = "" if len(values) == judged.stable.sum() else f", {len(values)} machines"
        low, *_, high = np.quantile(drawable(factor * values), QUANTILES)
        axes.axvspan(low, high, color=OWN, alpha=0.12, lw=0, label="5 % to 95 %")
        _machines(axes, factor * values, factor * judged.nominal[key], 8)
        axes.set_title(fill(plain(called) + only, TITLE), fontsize=9, parse_math=False)
    for axes in panels.flat[len(drawn) :]:
        axes.set_visible(False)
    for axes in panels[:, 0]:
        axes.set_ylabel("share [1]")
    figure.suptitle("\n".join(heading), fontsize=11, y=1 - 0.08 / height)
    if drawn:
        above(figure, panels.flat[0], columns=3, loc="lower center")
    return figure


def _in_motions(judged: Usable, title: str) -> Figure:
    """Draw distributions with a row for each motion and a column for each measure."""
    rows, columns = len(judged.motions), len(judged.units)
    share = f"{100 * judged.good.mean():.4g} % pass"
    machines = f"{len(judged.good)} machines within ±{100 * judged.spread:g} %: {share}"
    heading = [*filter(None, [title]), machines, "share of them up to a value"]
    top = 0.5 + 0.18 * len(heading)
    height = 1.15 * rows + top + 0.65
    figure = framed(height, top=top, left=0.8, right=0.15, bottom=0.65)
    shape = {"hspace": 0.75, "wspace": 0.15}
    grid = figure.subplots(rows, columns, sharey=True, squeeze=False, gridspec_kw=shape)
    for row, motion in zip(grid, judged.motions, strict=True):
        for axes, (name, measure_unit) in zip(row, judged.units.items(), strict=True):
            values = motion.measured[name][np.isfinite(motion.measured[name])]
            most = float(np.quantile(values, SHOWN)) if len(values) else 0.0
            factor, unit = readable(measure_unit, most)
            nominal = motion.nominal[name]
            _machines(axes, factor * values, factor * nominal, 7)
            most = max(most, nominal) if np.isfinite(nominal) else most
            axes.set_xlim(0.0, float(drawable(1.05 * factor * most)) or 1.0)
            axes.set_title(f"[{unit}]", fontsize=8, loc="right")
        row[0].set_ylabel(
            f"{plain(motion.name, 12)}\n{100 * motion.good.mean():.3g} % pass", fontsize=8
        )
    for axes, name in zip(grid[0], judged.units, strict=True):
        called = TITLES.get(name, name.replace("_", " "))
        axes.set_title(f"{called}\n{axes.get_title('right')}", fontsize=8, loc="right")
    figure.suptitle("\n".join(heading), fontsize=10, y=1 - 0.08 / height)
    above(figure, grid[0, 0], loc="lower center")
    return figure


def _machines(axes: Axes, values: Floats, nominal: float, size: float) -> None:
    """Draw the share of machines up to each of the ``values``, and the ``nominal`` value."""
    if len(values):
        axes.ecdf(drawable(values), color=OWN, lw=1.6, label="machines")
    if np.isfinite(nominal):
        dashed: Any = {"color": OTHER, "lw": 1.2, "ls": "--", "label": "nominal"}
        axes.axvline(float(drawable(nominal)), **dashed)
    gridded(axes)
    axes.tick_params(labelsize=size)
    axes.xaxis.set_major_locator(MaxNLocator(nbins=4))
    axes.set_yticks([0.0, 0.5, 1.0])
