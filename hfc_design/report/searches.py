"""Convergence of searches: best and median of a single one, or bands of groups of searches."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from hfc_design.core.numbers import Floats
from hfc_design.plotting.curves import thinned
from hfc_design.plotting.figure import (
    LINE,
    OTHER,
    OWN,
    STYLES,
    colour,
    drawable,
    finish,
    framed,
    list_above,
    logarithmic,
    plain,
)
from hfc_design.search.loop import History

#: Largest number of points of a band.
POINTS = 150


def history(history: History, title: str) -> Figure:
    """Draw best and median merit (``title`` defines it) and the number of diverged individuals."""
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
    searches: Mapping[str, Sequence[Floats]],
    measure: str = "merit",
    order: Sequence[int] | None = None,
) -> Figure:
    """Draw the best merit so far against generation: median and quartile band of each group.

    Args:
        searches: label of each group -> merits of its runs, at least one run; (generations,) each,
            nan while all individuals failed.
        measure: name of the number that ranked the individuals.
        order: number of each group, which selects colour and line style; default: from 0.
    """
    order = range(len(searches)) if order is None else order
    top = 0.15 + LINE * len(searches)
    figure = framed(3.6 + top, top, right=0.25)  # half of the last number stands outside
    axes = figure.subplots()
    bands = [_band(runs) for runs in searches.values()]
    for label, (generation, _, median, _), k in zip(searches, bands, order, strict=True):
        style = STYLES[k % len(STYLES)]
        axes.plot(generation, median, color=colour(k), ls=style, lw=1.6, label=plain(label))
    finish(axes, f"best {measure} so far", "generation")
    logarithmic(axes)
    medians = np.concatenate([median for _, _, median, _ in bands])
    # On a logarithmic axis, bands end at the smallest positive median.
    floor = medians[medians > 0].min() if axes.get_yscale() == "log" else -np.inf
    for (generation, low, _, high), k in zip(bands, order, strict=True):
        axes.fill_between(
            generation, np.maximum(low, floor), np.maximum(high, floor),
            color=colour(k), alpha=0.2 if len(searches) < 5 else 0.1, lw=0,
        )  # fmt: skip
    axes.margins(x=0)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    list_above(figure)
    return figure


def _band(runs: Sequence[Floats]) -> tuple[NDArray[np.intp], Floats, Floats, Floats]:
    """Return generations, and lower quartile, median, upper quartile of runs that reached them."""
    longest = max(len(run) for run in runs)
    drawn = np.unique(np.round(np.linspace(0, longest - 1, POINTS)).astype(int))
    scores = np.full((len(runs), len(drawn)), np.nan)
    for row, run in zip(scores, runs, strict=True):
        there = drawn < len(run)
        row[there] = drawable(run[drawn[there]])
    known = np.isfinite(scores).any(axis=0)
    low, median, high = np.nanquantile(scores[:, known], (0.25, 0.5, 0.75), axis=0)
    return drawn[known] + 1, low, median, high
