"""Findings of the runs below a folder: groups, comparisons, structures, published figures."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from hfc_design.batch import folder
from hfc_design.batch.groups import Comparison, Group, compared, grouped, quartiles
from hfc_design.batch.plan import Published, matches
from hfc_design.batch.results import Run, batches_below, runs_below
from hfc_design.core.numbers import Floats
from hfc_design.core.records import UserError
from hfc_design.core.statistics import Interval, share_interval
from hfc_design.core.tables import line, table
from hfc_design.files.design_set import apart
from hfc_design.files.labels import run_label
from hfc_design.report import searches
from hfc_design.runs.run import opened_run

#: Largest number of groups whose median a notebook shows.
SHOWN = 12
#: Largest number of curves that can be distinguished in a figure.
MOST = 10


class Reproduced(NamedTuple):
    """A published number, and the same number from the runs."""

    figure: str  # number of the figure in the paper
    quantity: str
    published: float | None
    simulated: float | None  # median of finished runs, or ratio of two medians; None: unknown
    ratio: float | None  # simulated over published
    runs: int
    remark: str


class Winner(NamedTuple):
    """A structure that searches of a group ended with."""

    group: Group
    structure: str  # as text
    runs: list[Run]  # runs that ended with this structure, the best first
    scores: Floats  # (runs,) merit or fitness (``Group.key``); -inf where a design diverged
    searches: int  # number of the group's finished searches with a known structure, one per seed

    def __repr__(self) -> str:
        shown = {"group": self.group.label, "structure": self.structure, "best": self.best}
        return line("Winner", {**shown, "runs": len(self.runs), "searches": self.searches})

    @property
    def share(self) -> float:
        """Share of the searches that ended with the structure."""
        return len(self.runs) / self.searches

    @property
    def interval(self) -> Interval:
        """Confidence interval of the share that a search with every possible seed would give."""
        return share_interval(len(self.runs), self.searches)

    @property
    def best(self) -> float:
        """Highest of the scores."""
        return float(self.scores[0])

    @property
    def median(self) -> float:
        """Median of the scores."""
        return quartiles(self.scores)[1]


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


def findings(path: Path) -> Findings:
    """Findings of the runs below ``path``."""
    runs = runs_below(path)
    groups = grouped(runs)
    return Findings(runs, groups, compared(groups), reproduced(path, runs), winners(groups))


def winners(groups: Sequence[Group]) -> list[Winner]:
    """Return the structures of each group, the most frequent first; on a tie, the best first.

    Runs with a given design do not count, as they have no search. Kinds of controller with only
    one structure are left out.
    """
    best: list[Winner] = []
    for group in groups:
        members: dict[str, list[tuple[float, Run]]] = defaultdict(list)
        for run, value in zip(group.finished, group.scores.tolist(), strict=True):
            if run.searched and run.structure:
                members[run.structure].append((value, run))
        searches = sum(map(len, members.values()))
        of_group = []
        for structure, inside in members.items():
            scores, runs = zip(*sorted(inside, key=lambda pair: -pair[0]), strict=True)
            of_group.append(Winner(group, structure, list(runs), np.array(scores), searches))
        best += sorted(of_group, key=lambda x: (-len(x.runs), -x.best, x.structure))
    return best


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
    named = zip(apart(labels, parts), folders, strict=True)
    return _curves([(name, path, grouped(runs_below(path))) for name, path in named])


def of_findings(findings_of: Mapping[str, Findings]) -> Figure:
    """Return the figure of ``convergence`` for several findings, with their names as labels.

    Raises:
        UserError: some findings contain no history of a search, or there are too many curves.
    """
    return _curves([(name, None, one.groups) for name, one in findings_of.items()])


def _curves(sources: Sequence[tuple[str, Path | None, Sequence[Group]]]) -> Figure:
    """Draw the groups of each source: its name, its folder (None: unknown), its groups."""
    histories: dict[str, list[Floats]] = {}
    titles = set()
    for name, path, groups in sources:
        drawn = [(group, runs) for group in groups if (runs := group.with_history)]
        if not drawn:
            raise UserError(f"{path or name or 'findings'}: has no history of a search")
        several = len({group.task for group, _ in drawn}) > 1
        for group, runs in drawn:
            label = f"{group.label}, {group.task}" if several else group.label
            which = label if len(drawn) > 1 else ""
            source = name if len(sources) > 1 or not which else ""
            histories[f"{source} {which}".strip() or group.label] = [run.best for run in runs]
            title = runs[0].judged_by
            if not title:
                title = opened_run(path / runs[0].path).judge().title if path else group.measure
            titles.add(title)
    if len(histories) > MOST:
        raise UserError(f"at most {MOST} curves can be told apart (got {len(histories)})")
    measure = titles.pop() if len(titles) == 1 else "merit (definitions differ)"
    numbers = range(len(histories))
    return searches.convergence(list(histories), list(histories.values()), numbers, measure)
