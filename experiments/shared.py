"""What the pages of the experiments share: runs of a batch by their settings, tables, curves."""

import json
from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

import click
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from experiments.steps import FILE, FINER, WINDOWED, Ranged, Ranges, finer
from hfc_design.batch.findings import Reproduced, reproduced
from hfc_design.batch.folder import batch_notes
from hfc_design.batch.plan import LABEL, Published, matches
from hfc_design.batch.results import Run, batches_below, runs_below
from hfc_design.batch.summary import published_table
from hfc_design.core.records import UserError
from hfc_design.plotting.figure import OTHER, OWN, framed
from hfc_design.runs.run import finished_run
from hfc_design.simulation.evaluating import Evaluation, evaluate
from hfc_design.simulation.repeats import range_text

Floats = NDArray[np.float64]
COLORS = (OTHER, OWN, "#009E73", "#7A3E9D")
#: A curve of more than twice as many samples is drawn as its extent in each of so many slices.
SLICES = 120
HEAD = ("figure", "quantity", "published", "simulated", "ratio", "remark")


class Batch:
    """The finished runs of a batch, by their settings."""

    def __init__(self, folder: Path):
        self.folder = folder
        try:
            self.runs = [run for run in runs_below(folder) if run.state == "finished"]
        except UserError as error:
            raise click.UsageError(f"{error}; run its batch first, with hfc batch") from None

        file = folder / FILE
        self.steps: dict[str, Ranges] = json.loads(file.read_text("utf-8")) if file.exists() else {}

    def run(self, label: str = "", **settings: Any) -> Run:
        """The first run with a label, or with settings."""
        wanted = {LABEL: label} if label else settings
        return next(run for run in self.runs if matches(wanted, run.settings))

    def values(self, label: str, *metrics: str) -> list[float | None]:
        """Metrics of the run with a label, ``Ranged`` where its steps were tried."""
        return [self.value(self.run(label), metric) for metric in metrics]

    def value(self, run: Run, metric: str) -> float | None:
        """A metric of a run, ``Ranged`` where its steps were tried."""
        limits = self.steps.get(run.path, {}).get(metric)
        return run.score[metric] if limits is None else Ranged.of(*limits)

    def motion(self, label: str) -> Evaluation:
        """What the run with a label does, simulated again."""
        return finished_run(self.folder / self.run(label).path)[1].evaluation

    def motions(self, label: str) -> list[Evaluation]:
        """The same, and in finer steps."""
        scenario, result = finished_run(self.folder / self.run(label).path)
        found = [evaluate(result.design, finer(scenario, times)) for times in FINER[1:]]
        return [result.evaluation, *found]

    def published(self) -> list[list[str]]:
        """``HEAD`` of every published figure."""
        listed = (told.published for own in batches_below(self.folder) for told in batch_notes(own))
        each = zip(reproduced(self.folder, self.runs), chain.from_iterable(listed), strict=True)
        return [self._row(*pair) for pair in each]

    def _row(self, item: Reproduced, wanted: Published) -> list[str]:
        """With the range that finer steps give it; of several runs that of their median."""
        (row,) = published_table([item]).rows
        cells = [str(cell) for cell in row]
        sides = [
            [self.value(run, metric) for run in self.runs if matches(settings, run.settings)]
            for settings, metric in wanted.sides
        ]
        found = [*filter(None, map(_median, sides))]
        if len(found) == len(sides):
            own = found[0].over(found[1]) if len(found) == 2 else found[0]
            cells[3] = number(own, ".3g" if own.high < 1e3 else ".0f")
            if item.published:
                cells[4] = number(own.over(Ranged.among([item.published])), ".2f")
            if len(found) == 1 and (other := self._windows(wanted)):
                cells[6] = "; ".join(filter(None, (cells[6], other)))
        return [*cells[:5], cells[6]]

    def _windows(self, wanted: Published) -> str:
        """What other windows make of a path error; "" for any other figure."""
        (settings, metric), *_ = wanted.sides
        run = next(run for run in self.runs if matches(settings, run.settings))
        limits = self.steps[run.path].get(metric + WINDOWED)
        return "" if limits is None else f"{Ranged.of(*limits):.3g}{WINDOWED}"


def _median(side: Sequence[float | None]) -> Ranged | None:
    """Of runs whose steps were tried; None of others."""
    found = [x for x in side if isinstance(x, Ranged)]
    if not found or len(found) < len(side):
        return None
    return Ranged.of(*np.median([(x, x.low, x.high) for x in found], axis=0).tolist())


def chaotic(batch: Batch) -> str:
    """The fitness of every run that a millionth of the command moves by more than 1 %."""
    found = {run.settings[LABEL]: run.ranges for run in batch.runs if "fitness" in run.ranges}
    rows = [[label, range_text(own["fitness"])] for label, own in found.items()]
    return markdown(("chaotic run", "fitness [1/BLU]"), rows)


def markdown(header: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    """A table of a page."""
    rows = [header, ["---"] * len(header), *lines]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in rows)


def calculated(
    figure: str, quantity: str, published: float | None, found: float, remark: str = ""
) -> list[str]:
    """A row of ``HEAD`` that no run stands behind."""
    own = found if isinstance(found, Ranged) else Ranged.among([found])
    times = own.over(Ranged.among([published])) if published else None
    told = (number(published), number(found), number(times, ".2f"))
    return [figure, quantity, *told, remark]


def ratio(one: float | None, other: float | None) -> float | None:
    """Of two figures, a range where they are; None where one is missing."""
    if one is None or other is None:
        return None
    return one.over(other) if isinstance(one, Ranged) and isinstance(other, Ranged) else one / other


def number(value: float | None, form: str = ".3g") -> str:
    """A number, or a dash where there is none."""
    return "–" if value is None else format(value, form)


def curves(
    time: Floats,
    panels: Mapping[str, Mapping[str, Floats]],
    levels: Mapping[str, Mapping[str, float]] | None = None,
) -> Figure:
    """Panels of curves against time, one above the other; what oscillates becomes a band.

    Args:
        time: (steps,) [s].
        panels: label of each panel with its unit -> name of each curve -> values (steps,).
        levels: label of a panel -> name -> a value of the paper, drawn as a line.
    """
    figure = framed(1.9 * len(panels) + 0.9, top=0.35)
    grid = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    names = dict.fromkeys(name for found in panels.values() for name in found)
    colors = dict(zip(names, COLORS, strict=False))
    for axes, (label, found) in zip(grid, panels.items(), strict=True):
        for name, values in found.items():
            _draw(axes, time, values, colors[name], name)
        for name, level in (levels or {}).get(label, {}).items():
            axes.axhline(level, color="black", lw=1, ls="--", label=name)
        axes.set_ylabel(label)
        axes.grid(color="0.9")
        axes.set_axisbelow(True)
        axes.margins(x=0)
    grid[-1].set_xlabel("time [s]")
    handles = {}
    for axes in grid:
        handles |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    figure.legend(
        handles.values(), handles.keys(), fontsize=9, frameon=False, ncols=4, loc="upper center"
    )
    return figure


def _draw(axes: Axes, time: Floats, values: Floats, color: str, name: str) -> None:
    size = -(-len(values) // SLICES)
    if size <= 2:
        axes.plot(time, values, color=color, lw=1.2, label=name)
        return
    starts = np.arange(0, len(values), size)
    low, high = (f.reduceat(values, starts) for f in (np.minimum, np.maximum))
    middle = time[np.minimum(starts + size // 2, len(time) - 1)]
    axes.fill_between(middle, low, high, color=color, alpha=0.65, lw=0.4, label=name)
