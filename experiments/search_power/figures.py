"""What the stored results say: targets reached against samples and seconds, tests, tables."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np
from matplotlib.figure import Figure
from scipy.stats import mannwhitneyu

from experiments.search_power.methods import DEFAULT, names
from experiments.search_power.tasks import GROUNDS
from hfc_design.core.numbers import Floats
from hfc_design.core.statistics import holm
from hfc_design.plotting.figure import OWN, framed
from hfc_design.report.errors import RIVALS

#: Targets of a picture (Hansen et al., COCO, 2021), and times at which they are counted.
TARGETS, TIMES = 51, 120
#: What p has to be below, after Holm.
ALPHA = 0.01
HEADER = ("task", "method", "median in the end (quartiles)", "A12", "p (Holm)", "seconds")


class Result(NamedTuple):
    """A method on a task."""

    task: str
    method: str
    shares: Floats  # (checks,) of the budget
    best: Floats  # (seeds, checks) -inf before anything
    seconds: Floats  # (seeds, checks)
    final: Floats  # (seeds,)
    stored: Mapping[str, Any]


class Beaten(NamedTuple):
    """The default beside a peer."""

    task: str
    peer: str
    a12: float  # share of the pairs of seeds in which the default is better (Vargha, Delaney)
    p: float  # two-sided Mann-Whitney U
    holm: float  # p after Holm's correction for all of the page


def read(folder: Path) -> dict[str, list[Result]]:
    """The results of each task, the default first.

    Raises:
        click.UsageError: there are none.
    """
    found: dict[str, list[Result]] = {}
    files = (json.loads(file.read_text("utf-8")) for file in sorted(folder.glob("*.json")))
    each = sorted(files, key=lambda one: names().index(one["method"]))
    for one in each:
        arrays = (_floats(one[key]) for key in ("shares", "best", "seconds", "final"))
        found.setdefault(one["task"], []).append(Result(one["task"], one["method"], *arrays, one))
    if not found:
        raise click.UsageError(
            f"{folder}: no results; run python -m experiments.search_power.run first"
        )
    return {task: found[task] for task in GROUNDS if task in found}


def _floats(values: Any) -> Floats:
    found = np.array(values, float)  # None becomes nan
    return np.where(np.isnan(found), -np.inf, found)


def beaten(results: Mapping[str, Sequence[Result]]) -> list[Beaten]:
    """The default beside every peer on every task, in the end."""
    pairs = [
        (own[0], peer) for own in results.values() for peer in own[1:] if own[0].method == DEFAULT
    ]
    if not pairs:
        return []
    tests = [mannwhitneyu(one.final, peer.final, method="auto") for one, peer in pairs]
    p = np.array([test.pvalue for test in tests])
    a12 = [
        float(test.statistic) / (len(one.final) * len(peer.final))
        for test, (one, peer) in zip(tests, pairs, strict=True)
    ]
    each = zip(pairs, a12, p.tolist(), holm(p).tolist(), strict=True)
    return [Beaten(one.task, peer.method, a, b, c) for (one, peer), a, b, c in each]


def table(results: Mapping[str, Sequence[Result]]) -> list[list[str]]:
    """``HEADER`` of every method on every task."""
    tests = {(one.task, one.peer): one for one in beaten(results)}
    each = (one for own in results.values() for one in own)
    return [_row(one, tests.get((one.task, one.method))) for one in each]


def _row(one: Result, test: Beaten | None) -> list[str]:
    quartiles = np.quantile(one.final, (0.25, 0.5, 0.75))
    low, middle, high = (f"{x:,.0f}" if abs(x) >= 100.0 else f"{x:.3g}" for x in quartiles)
    if test is None:
        compared = ["", ""]
    else:
        p = "< 0.001" if test.holm < 0.001 else f"{test.holm:.3f}"
        compared = [f"{test.a12:.2f}", p]
    seconds = f"{np.median(one.seconds[:, -1]):.3g}"
    return [one.task, one.method, f"{middle} ({low} to {high})", *compared, seconds]


def targets(results: Sequence[Result]) -> Floats:
    """(TARGETS,) from the worst that any seed began with to the best that one ended with.

    Evenly spaced by their logarithm; where constraints can be broken, half of them by that of
    what is broken, a negative number, and the others by that of the merit.
    """
    first, last = [], []
    for one in results:
        for row in one.best:
            known = row[np.isfinite(row)]
            first += known[:1].tolist()
            last += known[-1:].tolist()
    worst, best = min(first), max(last)
    if worst > 0.0:
        return np.geomspace(worst, best, TARGETS)
    every = np.concatenate([one.best.ravel() for one in results])
    every = every[np.isfinite(every)]
    least = -every[every < 0.0].max()
    broken = -np.geomspace(-worst, least, TARGETS // 2)
    if best <= 0.0:
        return -np.geomspace(-worst, max(-best, 1e-9), TARGETS)
    kept = every[every > 0.0].min()
    return np.append(broken, np.geomspace(kept, best, TARGETS - TARGETS // 2))


def reached(one: Result, wanted: Floats) -> Floats:
    """(checks,) the share of pairs of target and seed that are reached."""
    hits = one.best[:, :, None] >= wanted * (1.0 - 1e-9 * np.sign(wanted))
    return np.asarray(hits.mean(axis=(0, 2)))


def reached_by(one: Result, wanted: Floats, seconds: Floats) -> Floats:
    """(times,) the same by ``seconds`` of a seed."""
    places = np.array([np.searchsorted(own, seconds, side="right") - 1 for own in one.seconds])
    known = np.take_along_axis(one.best, np.maximum(places, 0), axis=1)
    known = np.where(places < 0, -np.inf, known)
    return reached(one._replace(best=known), wanted)


def picture(results: Sequence[Result]) -> Figure:
    """Targets reached against samples of a seed and against its seconds."""
    figure = framed(5.6, top=0.75)
    panels = figure.subplots(2, 1, gridspec_kw={"hspace": 0.32})
    wanted = targets(results)
    last = max(one.seconds.max() for one in results)
    earliest = min(one.seconds[one.seconds > 0.0].min() for one in results)
    times = np.geomspace(max(earliest, last / 300.0), last, TIMES)
    styles = [{"color": OWN, "lw": 2.5, "zorder": 3}, *RIVALS, *({**x, "lw": 2.2} for x in RIVALS)]
    for one, style in zip(results, styles, strict=False):
        samples = one.shares * one.stored["budget"]
        panels[0].step(samples, reached(one, wanted), where="post", label=one.method, **style)
        panels[1].step(times, reached_by(one, wanted, times), where="post", **style)
    for axes, label in zip(panels, ("simulated samples", "seconds of a seed"), strict=True):
        axes.set(xscale="log", ylim=(0.0, 1.0), xlabel=label, ylabel="targets reached")
        axes.grid(color="0.9")
        axes.set_axisbelow(True)
    figure.legend(fontsize=8, frameon=False, ncols=3, loc="upper center")
    return figure
