"""How searches converge and where they end; how a design's metrics spread over machines."""

from collections.abc import Mapping, Sequence
from math import ceil
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullLocator
from numpy.typing import NDArray

from hfc_design.core.numbers import Floats
from hfc_design.pictures.curves import thinned
from hfc_design.pictures.figure import (
    LABEL,
    OTHER,
    OWN,
    WIDTH,
    drawable,
    finish,
    framed,
    gridded,
    logarithmic,
    plain,
)
from hfc_design.search.loop import History
from hfc_design.simulation.monte_carlo import QUANTILES, Robustness

#: Okabe and Ito's colours, without the yellow that is hard to see on white, and black.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
STYLES = ("-", "--", "-.", ":")
#: A band is drawn with at most this many points.
POINTS = 150
#: Width of a picture with long labels [in].
WIDE = 8.4
COLUMNS, PANEL = 2, 1.45  # panels of distributions side by side; height of each [in]
#: Ratios of less than this, either way, count as close.
CLOSE = 1.1
#: Height of a line of the legend [in].
LINE = 0.16


def history(history: History, title: str) -> Figure:
    """Best and median merit, by its ``title``, and how many individuals diverged."""
    figure = framed(4.15, top=0.4)
    ratios = {"height_ratios": (3, 1), "hspace": 0.12}
    scores, diverged = figure.subplots(2, 1, sharex=True, gridspec_kw=ratios)
    count = len(history.best)
    generation = np.arange(1.0, count + 1)
    style: dict[str, Any] = {"marker": "." if count < 30 else None}
    scores.plot(*thinned(generation, history.best), color=OWN, label="best so far", **style)
    scores.plot(*thinned(generation, history.median), color=OTHER, label="median", **style)
    scores.legend(fontsize=9, frameon=False)
    scores.set_title(title, fontsize=11, parse_math=False)
    finish(scores, "merit")
    logarithmic(scores)
    place, bars = thinned(generation, history.diverged)
    place = np.concatenate([[0.5], place, [count + 0.5]])
    diverged.fill_between(place, np.pad(bars, 1, mode="edge"), step="mid", color="0.6")
    finish(diverged, "diverged [1]", "generation")
    diverged.set(xlim=(0.5, count + 0.5), ylim=(0, 1.05 * max(int(history.diverged.max()), 1)))
    diverged.xaxis.set_major_locator(MaxNLocator(integer=True))
    diverged.yaxis.set_major_locator(MaxNLocator(nbins=3, integer=True))
    return figure


def convergence(
    labels: Sequence[str], searches: Sequence[Sequence[Floats]], order: Sequence[int]
) -> Figure:
    """Best merit so far against generation: the median of each group over a band of quartiles.

    Args:
        labels: of each group.
        searches: of each group the merits of its runs, (generations,) each, nan while all failed;
            at least one run.
        order: of each group the number that chooses its colour and line style.
    """
    top = 0.15 + LINE * len(labels)
    figure = framed(3.6 + top, top, right=0.25)  # half of the last number stands outside
    axes = figure.subplots()
    bands = [_band(runs) for runs in searches]
    for label, (generation, _, median, _), k in zip(labels, bands, order, strict=True):
        style = STYLES[k % len(STYLES)]
        axes.plot(generation, median, color=_colour(k), ls=style, lw=1.6, label=plain(label))
    finish(axes, "best merit so far", "generation")
    logarithmic(axes)
    medians = np.concatenate([median for _, _, median, _ in bands])
    # A band may reach down to everything, or to what has a logarithm.
    floor = medians[medians > 0].min() if axes.get_yscale() == "log" else -np.inf
    for (generation, low, _, high), k in zip(bands, order, strict=True):
        axes.fill_between(
            generation, np.maximum(low, floor), np.maximum(high, floor),
            color=_colour(k), alpha=0.2 if len(labels) < 5 else 0.1, lw=0,
        )  # fmt: skip
    axes.margins(x=0)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    legend = figure.legend(
        fontsize=9, frameon=False, loc="upper left", bbox_to_anchor=(0.9 / WIDTH, 1),
        borderaxespad=0.2, borderpad=0, labelspacing=0.2,
    )  # fmt: skip
    for text in legend.get_texts():
        text.set_parse_math(False)
    return figure


def outcomes(scores: Mapping[int, Floats], measure: str) -> Figure:
    """The final score of every run, a column each group, with median and quartiles.

    Args:
        scores: by the number of each group, (runs,), at least one; what is not finite is not drawn.
        measure: what the scores are, merit or fitness.
    """
    figure = framed(3.2, top=0.15)
    axes = figure.subplots()
    for k, found in enumerate(scores.values()):
        values = drawable(found[np.isfinite(found)])
        if len(values) == 0:
            continue
        share = (np.arange(len(values)) + 0.5) / len(values) - 0.5
        dots = np.unique(np.round(np.linspace(0, len(values) - 1, 400)).astype(int))
        around, heights = k + 0.5 * share[dots], np.sort(values)[dots]
        axes.plot(around, heights, "o", ms=4.5, mew=0, color=_colour(k), alpha=0.6)
        low, median, high = np.quantile(values, (0.25, 0.5, 0.75))
        axes.plot([k] * 2, [low, high], color="0.25", lw=1)
        axes.plot([k - 0.3, k + 0.3], [median] * 2, color="0.1", lw=2)
    finish(axes, f"final {measure}", "group")
    logarithmic(axes)
    axes.set_xlim(-0.6, len(scores) - 0.4)
    axes.set_xticks(range(len(scores)), map(str, scores))
    return figure


def ratios(labels: Sequence[str], values: Sequence[float]) -> Figure:
    """Simulated over published figures, each more than 0, a line each, from the top down."""
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
    told = [plain(label, 2 * LABEL) for label in labels]
    axes.set_yticks(place, told, fontsize=6.5, parse_math=False)
    axes.set_ylim(len(values) - 0.5, -0.5)
    axes.grid(color="0.9", axis="x")
    axes.set_axisbelow(True)
    axes.set_xlabel("simulated / published")
    return figure


def distributions(found: Robustness, title: str) -> Figure:
    """Of each metric, the share of stable machines up to a value, and the nominal one's value.

    The band reaches from the 5 % to the 95 % quantile. A metric that is the same on every machine
    is left out.
    """
    drawn = [key for key in found.values if np.unique(found.spread_of(key)).size > 1]
    rows = max(-(-len(drawn) // COLUMNS), 1)
    height = PANEL * rows + 1.35
    figure = framed(height, top=0.75, left=0.65, right=0.2, bottom=0.6)
    panels = figure.subplots(
        rows, COLUMNS, sharey=True, squeeze=False, gridspec_kw={"hspace": 0.75, "wspace": 0.12}
    )
    for axes, key in zip(panels.flat, drawn, strict=False):
        values = drawable(found.spread_of(key))
        only = "" if len(values) == found.stable.sum() else f", {len(values)} machines"
        low, *_, high = np.quantile(values, QUANTILES)
        axes.axvspan(low, high, color=OWN, alpha=0.12, lw=0, label="5 % to 95 %")
        axes.ecdf(values, color=OWN, lw=1.6, label="machines")
        if np.isfinite(nominal := found.nominal[key]):
            axes.axvline(nominal, color=OTHER, lw=1.2, ls="--", label="nominal")
        gridded(axes)
        axes.set_title(key + only, fontsize=9)
        axes.tick_params(labelsize=8)
        axes.xaxis.set_major_locator(MaxNLocator(nbins=4))
        axes.set_yticks([0.0, 0.5, 1.0])
    for axes in panels.flat[len(drawn) :]:
        axes.set_visible(False)
    for axes in panels[:, 0]:
        axes.set_ylabel("share [1]")
    share = 100 * found.stable.mean()
    figure.suptitle(
        f"{title}\n{len(found.stable)} machines, parameters ±{100 * found.spread:g} %, "
        f"{share:.4g} % stable",
        fontsize=11,
        y=1 - 0.08 / height,
    )
    if drawn:
        handles = panels.flat[0].get_legend_handles_labels()
        figure.legend(*handles, fontsize=9, frameon=False, ncols=3, loc="lower center")
    return figure


def _band(runs: Sequence[Floats]) -> tuple[NDArray[np.intp], Floats, Floats, Floats]:
    """Generations, and lower quartile, median and upper quartile of the runs that got there."""
    longest = max(len(run) for run in runs)
    drawn = np.unique(np.round(np.linspace(0, longest - 1, POINTS)).astype(int))
    scores = np.full((len(runs), len(drawn)), np.nan)
    for row, run in zip(scores, runs, strict=True):
        there = drawn < len(run)
        row[there] = drawable(run[drawn[there]])
    known = np.isfinite(scores).any(axis=0)
    low, median, high = np.nanquantile(scores[:, known], (0.25, 0.5, 0.75), axis=0)
    return drawn[known] + 1, low, median, high


def _colour(k: int) -> str:
    return COLOURS[k % len(COLOURS)]
