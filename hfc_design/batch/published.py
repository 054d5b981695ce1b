"""Figures that a paper prints, beside what the runs of a batch give."""

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hfc_design.batch.folder import published
from hfc_design.batch.plan import Published, matches
from hfc_design.batch.runs import Run, batches_below
from hfc_design.batch.summary import Comparison, Group, compared, grouped
from hfc_design.core.shapes import Json

#: What the tables say of each.
HEAD = ("figure", "quantity", "published", "simulated", "ratio", "runs", "remark")


class Reproduced(NamedTuple):
    """A published figure with the simulated one."""

    published: Published
    simulated: float  # median over the finished runs; nan without any
    runs: int

    @property
    def ratio(self) -> float | None:
        """Simulated over published."""
        value = self.published.value
        return None if not value else self.simulated / value


class Findings(NamedTuple):
    """What pages and tables tell of the runs below a folder."""

    runs: list[Run]
    groups: list[Group]
    comparisons: list[Comparison]
    figures: list[Reproduced]


def findings(path: Path, runs: list[Run]) -> Findings:
    """What the runs below ``path`` give."""
    groups = grouped(runs)
    return Findings(runs, groups, compared(groups), reproduced(path, runs))


def reproduced(path: Path, runs: Iterable[Run]) -> list[Reproduced]:
    """Every published figure of the batches below ``path`` beside the median of its runs."""
    found = []
    for batch in batches_below(path):
        own = [run for run in runs if (path / run.path).parent == batch]
        finished = [run for run in own if run.state == "finished"]
        found += [_figure(item, finished) for item in published(batch)]
    return found


def _figure(item: Published, finished: list[Run]) -> Reproduced:
    values = _values(item.metric, item.of, finished)
    simulated = float(np.median(values)) if values else np.nan
    if item.over or item.over_metric:
        others = _values(item.over_metric or item.metric, item.over or item.of, finished)
        simulated = simulated / float(np.median(others)) if others else np.nan
    return Reproduced(item, simulated, len(values))


def _values(metric: str, wanted: Json, finished: list[Run]) -> list[float]:
    found = (run.score.get(metric) for run in finished if matches(wanted, run.settings))
    return [value for value in found if value is not None]


def row(item: Reproduced) -> list[str]:
    """``HEAD`` of a figure as a reader sees it."""
    paper, ratio = item.published, item.ratio
    return [
        paper.figure,
        paper.quantity,
        "–" if paper.value is None else _number(paper.value),
        _number(item.simulated) if np.isfinite(item.simulated) else "–",
        f"{ratio:.2f}" if ratio is not None and np.isfinite(ratio) else "–",
        str(item.runs),
        paper.remark,
    ]


def _number(value: float) -> str:
    """Three digits, or all that stand before the point."""
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e9 else f"{value:.3g}"
