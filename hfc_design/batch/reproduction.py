"""Comparison of published figures with the results of the runs of a batch."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from hfc_design.batch import folder
from hfc_design.batch.plan import Published, matches
from hfc_design.batch.results import Run, batches_below
from hfc_design.core.tables import MISSING, Table
from hfc_design.plotting.figure import LARGEST
from hfc_design.report import batch_plots

#: Largest number of ratios of published figures that are drawn.
RATIOS = 60
PUBLISHED = (
    "Values printed in the paper and medians of the runs here. A dash: the paper gives no number, "
    "or no run has finished. In full precision: published.csv."
)


class Reproduced(NamedTuple):
    """A published number, and the same number from the runs."""

    figure: str  # number of the figure in the paper
    quantity: str
    published: float | None
    simulated: float | None  # median of finished runs, or ratio of two medians; None: unknown
    ratio: float | None  # simulated over published
    runs: int
    remark: str


def reproduced(path: Path, runs: Sequence[Run]) -> list[Reproduced]:
    """Return every published number of the batches below ``path`` with the result of its runs."""
    rows = []
    for batch in batches_below(path):
        inside = (run for run in runs if (path / run.path).parent == batch)
        finished = [run for run in inside if run.state == "finished"]
        rows += [_figure(x, finished) for file in folder.batch_notes(batch) for x in file.published]
    return rows


def _figure(item: Published, finished: list[Run]) -> Reproduced:
    sides = []
    for wanted, metric in item.sides:
        values = (run.score.get(metric) for run in finished if matches(wanted, run.settings))
        sides.append([value for value in values if value is not None])
    simulated: float | None = None
    if all(sides):
        simulated, *over = (float(np.median(values)) for values in sides)
        simulated = _ratio(simulated, over[0]) if over else simulated
    numbers = (item.value, simulated, _ratio(simulated, item.value), len(sides[0]))
    return Reproduced(item.figure, item.quantity, *numbers, item.remark)


def _ratio(value: float | None, over: float | None) -> float | None:
    """Return ``value / over``; None if a number is missing or the ratio is not finite."""
    ratio = np.inf if value is None or not over else value / over
    return ratio if np.isfinite(ratio) else None


def ratios(figures: Sequence[Reproduced]) -> Figure | None:
    """Return a picture of the first ``RATIOS`` positive ratios; None if there are none."""
    shown = [item for item in figures if 1 / LARGEST < (item.ratio or 0) < LARGEST][:RATIOS]
    names = ((f"{item.figure} {item.quantity}".strip(), item.remark) for item in shown)
    labels = [", ".join(filter(None, parts)) for parts in names]
    return batch_plots.ratios(labels, [item.ratio or 0 for item in shown]) if shown else None


def published_table(figures: Sequence[Reproduced]) -> Table:
    """Return a table of the published and simulated numbers."""
    rows = []
    for item in figures:
        ratio = MISSING if item.ratio is None else f"{item.ratio:.2f}"
        numbers = (_number(item.published), _number(item.simulated), ratio, str(item.runs))
        rows.append([item.figure, item.quantity, *numbers, item.remark])
    return Table(PUBLISHED, Reproduced._fields, rows)


def _number(value: float | None) -> str:
    """Text of a number with three digits, or with all digits before the point."""
    if value is None:
        return MISSING
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e9 else f"{value:.3g}"
