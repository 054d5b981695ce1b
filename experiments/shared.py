"""What the experiments share: variants of designs, cycles of a motion, tables and curves."""

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hfc_design.checkpoint import write_whole
from hfc_design.evaluate import Evaluation, evaluate, load_design
from hfc_design.pictures.plots import OTHER, OWN, framed
from hfc_design.rulebase import Design, parse_design
from hfc_design.scenarios import load_scenario

Floats = NDArray[np.float64]
COLORS = (OTHER, OWN, "#009E73")
#: A curve of more than twice as many samples is drawn as its extent in each of so many slices.
SLICES = 120


class Row(NamedTuple):
    """One published figure beside the simulated one."""

    figure: str  # of the paper
    quantity: str  # with its unit
    published: float | None  # None: only in words
    simulated: float
    remark: str = ""


HEADER = ("figure", "quantity", "published", "simulated", "ratio", "remark")


def cells(row: Row) -> tuple[str, ...]:
    """``HEADER`` of one row as text."""
    published = ratio = simulated = "-"
    if np.isfinite(row.simulated):
        simulated = f"{row.simulated:.3g}"
    if row.published is not None:
        published, ratio = f"{row.published:.3g}", f"{row.simulated / row.published:.2f}"
    return row.figure, row.quantity, published, simulated, ratio, row.remark


def markdown(header: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    """A table of a page."""
    rows = [header, ["---"] * len(header), *lines]
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def write_tables(folder: Path, rows: Sequence[Row], others: Mapping[str, str]) -> str:
    """Write ``table.md``, ``table.csv`` and the others by name; returns what there is to print."""
    table = markdown(HEADER, [cells(row) for row in rows])
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([HEADER, *map(cells, rows)])
    for name, content in {"table": table, **others}.items():
        write_whole(folder / f"{name}.md", content.encode())
    write_whole(folder / "table.csv", text.getvalue().encode())
    return "\n".join([table, *others.values()])


def changed(name: str, **controller: Any) -> Design:
    """The built-in design ``name`` with keys of its controller replaced; a dict is laid over."""
    data = load_design(name).model_dump(mode="json")
    for key, value in controller.items():
        old = data["controller"].get(key)
        both = isinstance(old, dict) and isinstance(value, dict)
        data["controller"][key] = old | value if both else value
    return parse_design(Design.model_validate(data).model_dump_json(), name)


def run(design: Design | str, scenario: Path, *changes: str) -> Evaluation:
    """``design`` (or the built-in one of that name) on a scenario file with changes."""
    found = load_design(design) if isinstance(design, str) else design
    return evaluate(found, load_scenario(str(scenario), changes))


def rms(values: Floats) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def in_cycles(values: Floats, count: int = 3) -> list[Floats]:
    """(steps,) cut into equal cycles."""
    return np.array_split(values, count)


class Cycles(NamedTuple):
    """Figures of each cycle of a circle [BLU]."""

    axial: list[float]  # root mean square of the tracking error of X
    contour: list[float]  # root mean square of the contour error
    largest: list[float]  # largest contour error
    unrest: list[float]  # root mean square of the change of X's command from sample to sample


def cycles(evaluation: Evaluation, count: int = 3) -> Cycles:
    """The figures of a circle of ``count`` cycles."""
    assert evaluation.contour is not None
    off = in_cycles(evaluation.contour.error, count)
    axial = in_cycles(evaluation.axes[0].motion.error, count)
    return Cycles(
        [rms(part) for part in axial],
        [rms(part) for part in off],
        [float(np.abs(part).max()) for part in off],
        [rms(np.diff(part)) for part in in_cycles(evaluation.axes[0].motion.command, count)],
    )


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
    for axes, (label, found) in zip(grid, panels.items(), strict=True):
        for (name, values), color in zip(found.items(), COLORS, strict=False):
            _draw(axes, time, values, color, name)
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
