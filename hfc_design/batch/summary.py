"""What runs give: groups that differ in nothing but the seed, how their scores compare, which
structures won, the published figures that they stand beside, and how searches converge.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from rich.text import Text

from hfc_design.batch import folder
from hfc_design.batch.comparisons import Comparison, broken, compared, sentence
from hfc_design.batch.groups import ANSWERS, Group, Winner, grouped, tell_structures, winners
from hfc_design.batch.plan import Published, matches
from hfc_design.batch.runs import Run, batches_below, runs_below
from hfc_design.core.console import show_rows, terminal
from hfc_design.core.numbers import Floats
from hfc_design.core.records import UserError, harmless
from hfc_design.core.shown import line, table
from hfc_design.files.cells import called
from hfc_design.files.together import apart
from hfc_design.pictures.figure import LARGEST
from hfc_design.report import batch_plots, searches
from hfc_design.runs.run import opened_run

#: Of so many groups a notebook has the median.
SHOWN = 12
#: Of so many tasks, and groups of each, the medians are told.
TASKS, GROUPS = 6, 10
HEAD = ["group", "runs", "median", "quartiles", "best"]
#: So many ratios of published figures are drawn.
RATIOS = 60
#: So many curves can be told apart.
MOST = 10
#: A group, its runs with a history, and what they were ranked by.
Curves = tuple[Group, list[Run], str]


class Reproduced(NamedTuple):
    """A published figure with the simulated one."""

    figure: str  # of the paper
    quantity: str
    published: float | None
    simulated: float | None  # median over the finished runs; None without any
    ratio: float | None  # simulated over published
    runs: int
    remark: str


def reproduced(path: Path, runs: Sequence[Run]) -> list[Reproduced]:
    """Every published figure of the batches below ``path`` beside the median of its runs."""
    found = []
    for batch in batches_below(path):
        own = (run for run in runs if (path / run.path).parent == batch)
        finished = [run for run in own if run.state == "finished"]
        found += [_figure(x, finished) for told in folder.told(batch) for x in told.published]
    return found


def _ratio(value: float | None, over: float | None) -> float | None:
    """None where there is no number."""
    found = np.inf if value is None or not over else value / over
    return found if np.isfinite(found) else None


def _figure(item: Published, finished: list[Run]) -> Reproduced:
    sides = []
    for wanted, metric in item.sides:
        found = (run.score.get(metric) for run in finished if matches(wanted, run.settings))
        sides.append([value for value in found if value is not None])
    simulated: float | None = None
    ratio = None
    if all(sides):
        simulated, *over = (float(np.median(values)) for values in sides)
        simulated = _ratio(simulated, over[0]) if over else simulated
        ratio = _ratio(simulated, item.value)
    told = (item.value, simulated, ratio, len(sides[0]))
    return Reproduced(item.figure, item.quantity, *told, item.remark)


def ratios(figures: Sequence[Reproduced]) -> Figure | None:
    """The ratios that there are and that a logarithm can show."""
    shown = [item for item in figures if 1 / LARGEST < (item.ratio or 0) < LARGEST][:RATIOS]
    told = ((f"{item.figure} {item.quantity}".strip(), item.remark) for item in shown)
    labels = [", ".join(filter(None, parts)) for parts in told]
    return batch_plots.ratios(labels, [item.ratio or 0 for item in shown]) if shown else None


def figure_row(item: Reproduced) -> list[str]:
    """What a reader sees of a published figure."""
    ratio = "–" if item.ratio is None else f"{item.ratio:.2f}"
    told = (_number(item.published), _number(item.simulated), ratio, str(item.runs))
    return [item.figure, item.quantity, *told, item.remark]


def _number(value: float | None) -> str:
    """Three digits, or all that stand before the point."""
    if value is None:
        return "–"
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e9 else f"{value:.3g}"


class Findings(NamedTuple):
    """What pages and tables tell of the runs below a folder."""

    runs: list[Run]
    groups: list[Group]  # runs that differ in nothing but the seed, the highest median first
    comparisons: list[Comparison]  # of every two groups of a task, with p
    figures: list[Reproduced]  # that a batch file names as published, beside what the runs give
    winners: list[Winner]  # structures that searches of hierarchies ended with

    def __repr__(self) -> str:
        return line("Findings", self._told())

    def _repr_html_(self) -> str:
        shown = {
            f"{one.task}, {one.label}": f"{one.measure} {one.median:.4g} in the median of "
            f"{len(one.finished)} finished runs"
            for one in self.groups[:SHOWN]
        }
        return table("Findings", self._told() | shown)

    def _told(self) -> dict[str, object]:
        return {field: len(value) for field, value in self._asdict().items()}

    def number_of(self) -> dict[str, int]:
        """Path of each run in a group -> the group's number."""
        return {run.path: group.number for group in self.groups for run in group.runs}


def findings(path: Path, runs: list[Run]) -> Findings:
    """What the runs below ``path`` give."""
    groups = grouped(runs)
    return Findings(runs, groups, compared(groups), reproduced(path, runs), winners(groups))


def tell(page: Path, found: Findings | None) -> None:
    """Print what the runs gave, if it is more than one, and where the page is."""
    if found is not None:
        tasks = list(dict.fromkeys(group.task for group in found.groups))
        for task in tasks[:TASKS]:
            groups = [group for group in found.groups if group.task == task]
            _show(groups)
            terminal().print(Text(harmless(sentence(groups, found.comparisons))))
            if failed := broken(groups):
                terminal().print(Text(harmless(failed)))
            terminal().print()
        if len(tasks) > TASKS:
            terminal().print(f"{len(tasks) - TASKS} more tasks are in groups.csv\n")
        tell_structures(found.winners)
    print(page)


def _show(groups: list[Group]) -> None:
    """The medians of a task over the seeds, the highest first."""
    title = f"{groups[0].task}: {groups[0].measure}"
    heads = [*HEAD, *(ANSWERS if groups[0].answers else [])]
    cells = ([harmless(group.label), *group.row()[1:]] for group in groups[:GROUPS])
    show_rows(heads, (map(Text, row) for row in cells), title=Text(harmless(title)), title_style="")
    if len(groups) > GROUPS:
        terminal().print(f"{len(groups) - GROUPS} more groups are in groups.csv")


def convergence(folders: Sequence[Path]) -> Figure:
    """Best merit so far against generation: a curve of each run folder, or of the groups below one.

    That of a group is the median of its finished runs over a band between their quartiles.

    Raises:
        UserError: a folder has no run or no history, stands there twice, or there are too many
            curves.
    """
    for k, path in enumerate(folders):
        if any(path.resolve() == other.resolve() for other in folders[:k]):
            raise UserError(f"{path}: stands there twice; it does what it does")
    parts = [path.resolve().parts for path in folders]
    own = zip(folders, parts, strict=True)
    names = apart([called(path) or part[-1] for path, part in own], parts)
    each = {}
    for path, name in zip(folders, names, strict=True):
        each[name] = list(_curves(path))
        if not each[name]:
            raise UserError(f"{path}: has no history of a search")
    return _curves_drawn(each)


def of_findings(found: Mapping[str, Findings]) -> Figure:
    """The same of what runs gave, by the names that they are to have.

    Raises:
        UserError: nothing was searched, or there are too many curves.
    """
    each = {name: [*_histories(one.groups)] for name, one in found.items()}
    for name, groups in each.items():
        if not groups:
            raise UserError(f"{name or 'findings'}: no run has a history of a search")
    return _curves_drawn(each)


def _curves_drawn(each: Mapping[str, list[Curves]]) -> Figure:
    curves: dict[str, list[Floats]] = {}
    titles = set()
    for name, found in each.items():
        for group, runs, title in found:
            task = f", {group.task}" if len({one.task for one, *_ in found}) > 1 else ""
            which = f"{group.label}{task}" if len(found) > 1 else ""
            called = name if len(each) > 1 or not which else ""
            curves[f"{called} {which}".strip() or group.label] = [run.best for run in runs]
            titles.add(title)
    if len(curves) > MOST:
        raise UserError(f"{len(curves)} curves are more than the {MOST} that can be told apart")
    measure = titles.pop() if len(titles) == 1 else "merit, each by its own,"
    return searches.convergence(list(curves), list(curves.values()), range(len(curves)), measure)


def _histories(groups: Sequence[Group]) -> Iterator[Curves]:
    """Of each group that has any its histories, and what they were ranked by."""
    for group in groups:
        runs = [run for run in group.finished or group.runs if np.isfinite(run.best).any()]
        if runs:
            yield group, runs, runs[0].judged_by or group.measure


def _curves(path: Path) -> Iterator[Curves]:
    """The same of the groups below a folder; a run that goes on says itself what ranks it."""
    for group, runs, title in _histories(grouped(runs_below(path))):
        place = path / runs[0].path
        yield group, runs, (runs[0].judged_by and title) or opened_run(place).judge().title
