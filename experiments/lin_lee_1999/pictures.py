"""Figures of the page of Lin & Lee 1999 (LL), of the runs of its batch; see ``page``."""

from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.shared import Batch
from hfc_design.batch.plan import LABEL
from hfc_design.batch.results import Run
from hfc_design.files.loop_setup import load_design
from hfc_design.plotting.figure import OTHER, OWN, framed
from hfc_design.report import searches
from hfc_design.report.designs import picture
from hfc_design.report.overlaid import motions
from hfc_design.runs.run import finished_run
from hfc_design.simulation.evaluating import Evaluation


class Case(NamedTuple):
    """One of the two simulations of the paper: its figure, and the labels of its batch."""

    figure: str
    table: str  # printed
    design: str  # the same, built in
    ending: str  # of the labels of searches

    @property
    def searches(self) -> dict[str, str]:
        """Name -> label of what was searched here."""
        names = ("the paper's algorithm", "the default search")
        return {name: name + self.ending for name in names}


ALONE = "PD alone"
SIX = Case("6", "Table I", "lin-lee-1999-table-1", "")
SEVEN = Case("7", "Table II", "lin-lee-1999-table-2", ", cutting")
#: Of fig. 5: which unit each input enters once those of one input are gone, and how far right.
REDUCED = {"A": (0, 0.0), "C": (0, 0.6), "B": (1, -0.3), "D": (1, 0.3)}


def of_label(batch: Batch, label: str) -> list[Run]:
    """The runs with a label, the worst first."""
    found = [run for run in batch.runs if run.settings[LABEL] == label]
    return sorted(found, key=lambda run: run.score["fitness"] or 0.0)


def shown(batch: Batch, case: Case) -> dict[str, Evaluation]:
    """What is drawn of a case; of searches the run with the median fitness."""
    labels = {case.table: case.table, ALONE: f"PD of {case.table}"} | case.searches
    found = {}
    for name, label in labels.items():
        runs = of_label(batch, label)
        if runs:
            middle = runs[len(runs) // 2]
            found[name] = finished_run(batch.folder / middle.path)[1].evaluation
    return found


def convergence(batch: Batch, case: Case) -> Figure:
    """Figs. 6a and 7a: the best fitness so far, and that of the printed table."""
    runs = {name: of_label(batch, label) for name, label in case.searches.items()}
    figure = searches.convergence({name: [x.best for x in own] for name, own in runs.items()})
    axes = figure.axes[0]
    printed = of_label(batch, case.table)[0].score["fitness"] or 0.0
    axes.axhline(printed, color="black", lw=1, ls=":")
    told, place = f"{case.table}: {printed:.1f}", axes.get_yaxis_transform()
    axes.text(0.98, printed, told, fontsize=9, ha="right", va="bottom", transform=place)
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, 0.7 * printed), high)
    return figure


def tree(case: Case) -> Figure:
    """Figs. 6b and 7b: the printed hierarchy."""
    return picture(load_design(case.design), "tree")


def motion(batch: Batch, case: Case) -> Figure:
    """Figs. 6c to 6f and 7c to 7f: the printed table, beside what is left without its hierarchy."""
    found = shown(batch, case)
    kept = {name: found[name] for name in (case.table, ALONE)}
    return motions(kept, f"{case.table} and its PD gains alone")


def code() -> Figure:
    """Fig. 5: where the inputs of the code 0123 enter, and what LL's step 2(ii) leaves of it."""
    figure = framed(2.9, top=0.3, left=0.1, right=0.1, bottom=0.1)
    printed, left = figure.subplots(1, 2)
    places = {0: (0.0, 0.0), 1: (-1.0, -1.0), 2: (1.0, -1.0), 3: (-1.6, -2.0)}
    _draw(printed, places, {"A": (0, 0.0), "B": (1, 0.3), "C": (2, 0.0), "D": (3, 0.0)})
    printed.set_title("the code 0123", fontsize=10)
    _draw(left, {0: places[0], 1: places[1]}, REDUCED)
    left.set_title("units of one input passed on", fontsize=10)
    left.text(0.5, 0.0, "three inputs", color=OTHER, fontsize=9, va="center")
    return figure


def _draw(
    axes: Axes, units: dict[int, tuple[float, float]], inputs: dict[str, tuple[int, float]]
) -> None:
    """Units with what they feed; below each, so far to the right, the inputs that enter it."""
    for unit, (x, y) in units.items():
        if unit:
            to = units[(unit - 1) // 2]
            axes.plot((x, to[0]), (y, to[1]), color="0.3", lw=1, zorder=0)
        frame = {"boxstyle": "round,pad=0.4", "facecolor": "#E8F1F8", "edgecolor": "0.3"}
        axes.text(x, y, f"unit {unit}", ha="center", va="center", fontsize=9, bbox=frame)
    for name, (unit, right) in inputs.items():
        x, y = units[unit]
        axes.plot((x, x + right), (y, y - 0.6), color=OWN, lw=1.2, zorder=0)
        axes.text(x + right, y - 0.63, name, ha="center", va="top", fontsize=10)
    axes.set(xlim=(-2.2, 1.6), ylim=(-2.95, 0.35))
    axes.set_axis_off()
