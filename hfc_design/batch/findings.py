"""Results of the runs below a folder: groups, comparisons, structures and convergence."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from matplotlib.figure import Figure

from hfc_design.batch.comparisons import Comparison, compared
from hfc_design.batch.groups import Group, grouped
from hfc_design.batch.reproduction import Reproduced, reproduced
from hfc_design.batch.results import Run, runs_below
from hfc_design.batch.structures import Winner, winners
from hfc_design.core.numbers import Floats
from hfc_design.core.records import UserError
from hfc_design.core.tables import line, table
from hfc_design.files.design_set import apart
from hfc_design.files.labels import run_label
from hfc_design.report import searches
from hfc_design.runs.run import opened_run

#: Largest number of groups whose median a notebook shows.
SHOWN = 12
#: Largest number of curves that can be distinguished in a figure.
MOST = 10
#: A group, those of its runs that have a history, and the title of the merit in these histories.
Curves = tuple[Group, list[Run], str]


class Findings(NamedTuple):
    """Summary of the runs below a folder, from which pages and tables are made."""

    runs: list[Run]
    groups: list[Group]  # task by task, within a task the best first
    comparisons: list[Comparison]  # pairs of groups of the same task, see ``compared``
    figures: list[Reproduced]  # published numbers of the batch files, and the results of the runs
    winners: list[Winner]  # structures with which the searches of each group ended

    def __repr__(self) -> str:
        return line("Findings", self._counts())

    def _repr_html_(self) -> str:
        medians = {
            f"{group.task}, {group.label}": f"{group.measure} {group.median:.4g} in the median of "
            f"{len(group.finished)} finished runs"
            for group in self.groups[:SHOWN]
        }
        return table("Findings", self._counts() | medians)

    def _counts(self) -> dict[str, object]:
        return {field: len(value) for field, value in self._asdict().items()}

    @property
    def tasks(self) -> list[str]:
        """Names of all tasks; scores are comparable only within a task."""
        return list(dict.fromkeys(group.task for group in self.groups))

    def of_task(self, task: str) -> list[Group]:
        """Groups of a task."""
        return [group for group in self.groups if group.task == task]

    def number_of(self) -> dict[str, int]:
        """Return the path of each run -> the number of its group."""
        return {run.path: group.number for group in self.groups for run in group.runs}


def findings(path: Path, runs: list[Run]) -> Findings:
    """Findings of the runs below ``path``."""
    groups = grouped(runs)
    return Findings(runs, groups, compared(groups), reproduced(path, runs), winners(groups))


def convergence(folders: Sequence[Path]) -> Figure:
    """Draw the best merit so far against generation: a curve for each group of runs below a folder.

    A curve is the median of the group's finished runs (of all its runs if none has finished), with
    a band between the quartiles.

    Raises:
        UserError: a folder has no run or no history, or is given twice; or too many curves.
    """
    for k, path in enumerate(folders):
        if any(path.resolve() == other.resolve() for other in folders[:k]):
            raise UserError(f"{path}: is listed twice")
    parts = [path.resolve().parts for path in folders]
    labels = [run_label(path) or x[-1] for path, x in zip(folders, parts, strict=True)]
    names = apart(labels, parts)
    curves = {}
    for path, name in zip(folders, names, strict=True):
        curves[name] = _histories(grouped(runs_below(path)), path)
        if not curves[name]:
            raise UserError(f"{path}: has no history of a search")
    return _drawn(curves)


def of_findings(findings_of: Mapping[str, Findings]) -> Figure:
    """Return the figure of ``convergence`` for several findings, with their names as labels.

    Raises:
        UserError: some findings contain no history of a search, or there are too many curves.
    """
    curves = {name: _histories(x.groups) for name, x in findings_of.items()}
    for name, groups in curves.items():
        if not groups:
            raise UserError(f"{name or 'findings'}: no run has a history of a search")
    return _drawn(curves)


def _histories(groups: Sequence[Group], path: Path | None = None) -> list[Curves]:
    """Return groups with histories; a title that is unknown is read from a run below ``path``."""
    curves = []
    for group in groups:
        if runs := group.with_history:
            title = runs[0].judged_by
            if not title:
                place = path and path / runs[0].path
                title = opened_run(place).judge().title if place else group.measure
            curves.append((group, runs, title))
    return curves


def _drawn(curves: Mapping[str, list[Curves]]) -> Figure:
    histories: dict[str, list[Floats]] = {}
    titles = set()
    for name, groups in curves.items():
        tasks = {group.task for group, *_ in groups}
        for group, runs, title in groups:
            label = f"{group.label}, {group.task}" if len(tasks) > 1 else group.label
            which = label if len(groups) > 1 else ""
            source = name if len(curves) > 1 or not which else ""
            histories[f"{source} {which}".strip() or group.label] = [run.best for run in runs]
            titles.add(title)
    if len(histories) > MOST:
        raise UserError(f"at most {MOST} curves can be told apart (got {len(histories)})")
    measure = titles.pop() if len(titles) == 1 else "merit (definitions differ)"
    numbers = range(len(histories))
    return searches.convergence(list(histories), list(histories.values()), numbers, measure)
