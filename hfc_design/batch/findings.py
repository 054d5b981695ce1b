"""Findings of the runs below a folder: groups, comparisons, structures, published figures.

A group is the runs that differ only in the seed.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, count
from math import comb
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import mannwhitneyu

from hfc_design.batch import folder
from hfc_design.batch.plan import SCENARIO, Published, matches
from hfc_design.batch.results import VERDICTS, Run, batches_below, runs_below
from hfc_design.core.numbers import Floats, digits
from hfc_design.core.records import UserError
from hfc_design.core.statistics import Interval, holm, share_interval
from hfc_design.core.tables import line, table
from hfc_design.files.design_set import apart
from hfc_design.files.labels import LABEL, SEED, run_label
from hfc_design.report import searches
from hfc_design.runs.champion import LEAST_VIOLATED
from hfc_design.runs.run import opened_run

#: Keys of the compared number: the merit, or the fitness if runs of a task have different merits.
MERIT, FITNESS = "merit", "fitness"
#: Prefix of the keys on which the fitness depends.
OF_FITNESS = "fitness."
#: A difference counts as significant if the corrected p is not above this level.
ALPHA = 0.05
#: Largest number of groups of a task that are compared: those with the highest medians.
COMPARED = 20
#: Without ties, p is exact up to this many pairs of runs, which takes milliseconds.
EXACT = 1000
#: Largest number of groups whose median a notebook shows.
SHOWN = 12
#: Largest number of curves that can be distinguished in a figure.
MOST = 10
Quartiles = tuple[float, float, float]


@dataclass(frozen=True, eq=False, repr=False)
class Group:
    """Runs with the same settings and different seeds."""

    number: int  # from 1; its name in tables and pictures
    task: str  # scenario and settings of the fitness; scores are comparable only within a task
    measure: str  # compared number: title of the merit of all runs of the task, or fitness
    settings: dict[str, str]  # only settings in which groups differ
    runs: list[Run]

    def __repr__(self) -> str:
        shown = {"label": self.label, "task": self.task, "measure": self.measure}
        return line("Group", {**shown, "median": self.median, "finished": len(self.finished)})

    @cached_property
    def finished(self) -> list[Run]:
        """One finished run per seed, as another run with the same seed adds nothing."""
        runs: dict[str, Run] = {}
        for run in self.runs:
            if run.state == "finished":
                runs.setdefault(run.setting(SEED), run)
        return [*runs.values()]

    @property
    def key(self) -> str:
        """Key, in ``Run.score``, of the number that is compared."""
        return FITNESS if self.measure == FITNESS else MERIT

    @cached_property
    def scores(self) -> Floats:
        """(finished,) value of ``key``, in float64; -inf where a design diverged."""
        values = (run.score.get(self.key) for run in self.finished)
        return np.array([-np.inf if value is None else value for value in values], float)

    @cached_property
    def quartiles(self) -> Quartiles:
        """Quartiles of the scores; nan without a finished run."""
        return quartiles(self.scores)

    @property
    def median(self) -> float:
        """Median of the final score."""
        return self.quartiles[1]

    @property
    def broken(self) -> int:
        """Number of finished runs in which no design that was tried meets every constraint."""
        return sum(bool(run.score.get(LEAST_VIOLATED)) for run in self.finished)

    @property
    def with_history(self) -> list[Run]:
        """Runs whose convergence can be drawn: finished ones, or all if none has finished."""
        return [run for run in self.finished or self.runs if np.isfinite(run.best).any()]

    @property
    def answers(self) -> list[str]:
        """Seeds with a usable design, median share of machines that pass [%]; empty if unknown."""
        yes, _, share = self._usable
        count = sum(bool(run.verdict) for run in self.finished)
        return [f"{round(yes * count)} of {count}", f"{100 * share:.4g}"] if count else []

    @property
    def place(self) -> tuple[float, ...]:
        """Sort key of groups, the best first: shares of verdicts, share of machines, median."""
        return *(-x for x in self._usable), np.isnan(self.median), -self.median

    @property
    def _usable(self) -> tuple[float, ...]:
        """Shares of the two best verdicts, median share of machines that pass; 0 if unknown."""
        runs = [run for run in self.finished if run.verdict]
        best = (sum(run.verdict == x for run in runs) / max(len(runs), 1) for x in VERDICTS[:2])
        return *best, float(np.median([run.share or 0.0 for run in runs] or [0.0]))

    def metrics(self) -> dict[str, Quartiles]:
        """Quartiles of each metric over the finished runs that have it."""
        values: dict[str, list[float]] = defaultdict(list)
        for run in self.finished:
            for key, value in run.score.items():
                if value is not None and key != LEAST_VIOLATED:
                    values[key].append(value)
        return {key: quartiles(np.array(column)) for key, column in values.items()}

    @property
    def label(self) -> str:
        """Number of the group, and its label or the settings that distinguish it in its task."""
        keys = (k for k in self.settings if k != SCENARIO and not k.startswith(OF_FITNESS))
        words = [f"{key.rpartition('.')[2]} {self.settings[key]}" for key in keys]
        if LABEL in self.settings:
            words = [self.settings[LABEL]]
        return f"{self.number}: {', '.join(words)}" if words else str(self.number)


class Comparison(NamedTuple):
    """Two groups of the same task; the median of the first is not the lower one."""

    first: Group
    second: Group
    a12: float  # Vargha & Delaney's effect size: share of pairs where the first is higher
    p: float  # two-sided Mann-Whitney U test
    holm: float  # p after Holm's correction for all comparisons
    exact: bool  # True: p is exact; False: p is from the normal distribution, corrected for ties

    def __repr__(self) -> str:
        sides = {"first": self.first.label, "second": self.second.label}
        return line("Comparison", {**sides, "a12": self.a12, "p": self.p, "holm": self.holm})

    @property
    def sizes(self) -> tuple[int, int]:
        """Number of runs of each group."""
        return len(self.first.scores), len(self.second.scores)

    @property
    def testable(self) -> bool:
        """True if groups of these sizes can show a difference at all, before Holm's correction."""
        return smallest_p(*self.sizes) <= ALPHA

    @property
    def shown(self) -> bool:
        """True if the difference is significant."""
        return self.holm <= ALPHA


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


def grouped(runs: Sequence[Run]) -> list[Group]:
    """Return the groups of the runs, task by task, the best first (see ``Group.place``)."""
    known = [run for run in runs if run.settings]
    keys = dict.fromkeys(key for run in known for key in run.settings if key != SEED)
    differing = [key for key in keys if len({run.setting(key) for run in known}) > 1]
    tasks: dict[str, dict[tuple[str, ...], list[Run]]] = {}
    for run in known:
        # A task is the scenario and the settings on which the fitness depends.
        fitness = [f"{key} {run.setting(key)}" for key in differing if key.startswith(OF_FITNESS)]
        members = tasks.setdefault(", ".join([run.setting(SCENARIO), *fitness]), {})
        members.setdefault(tuple(run.setting(key) for key in differing), []).append(run)
    groups: list[Group] = []
    for task, members in tasks.items():
        finished = [run for inside in members.values() for run in inside if run.state == "finished"]
        judge, *others = {run.judged_by for run in finished} or {FITNESS}
        # Runs of an earlier version do not name their merit.
        measure = FITNESS if others else judge or FITNESS
        named = ((dict(zip(differing, x, strict=True)), inside) for x, inside in members.items())
        result = [Group(0, task, measure, settings, inside) for settings, inside in named]
        groups += sorted(result, key=lambda group: group.place)
    return [replace(group, number=k) for k, group in enumerate(groups, 1)]


def quartiles(values: Floats) -> Quartiles:
    """Return lower quartile, median and upper quartile, possibly -inf; nan without values."""
    if not len(values):
        return np.nan, np.nan, np.nan
    with np.errstate(invalid="ignore"):  # between -inf and a finite number
        quantiles = np.quantile(values, (0.25, 0.5, 0.75))
    low, median, high = np.nan_to_num(quantiles, nan=-np.inf, neginf=-np.inf).tolist()
    return low, median, high


def compared(groups: Sequence[Group]) -> list[Comparison]:
    """Compare in pairs the highest groups of each task that have at least two finished runs."""
    tasks: dict[str, list[Group]] = defaultdict(list)
    for group in groups:
        if len(group.scores) >= 2:
            tasks[group.task].append(group)
    highest = (sorted(x, key=lambda group: -group.median)[:COMPARED] for x in tasks.values())
    pairs = [pair for inside in highest for pair in combinations(inside, 2)]
    tests = []
    for first, second in pairs:
        x, y = digits(first.scores), digits(second.scores)
        ties = len({*x.tolist(), *y.tolist()}) < len(x) + len(y)
        exact = len(x) * len(y) <= EXACT and not ties
        test = mannwhitneyu(x, y, method="exact" if exact else "asymptotic")
        tests.append((float(test.statistic) / (len(x) * len(y)), float(test.pvalue), exact))
    corrected = holm(np.array([p for _, p, _ in tests])).tolist()
    return [
        Comparison(*pair, a12, p, p_holm, exact)
        for pair, (a12, p, exact), p_holm in zip(pairs, tests, corrected, strict=True)
    ]


def smallest_p(first: int, second: int) -> float:
    """Return p for groups of these sizes if each run of one is better than each of the other."""
    return min(2 / comb(first + second, first), 1.0)


def runs_needed(comparisons: int) -> int:
    """Return the number of runs that groups need to show a difference in so many comparisons."""
    return next(n for n in count(2) if comparisons * smallest_p(n, n) <= ALPHA)


def too_few(comparisons: Sequence[Comparison]) -> int:
    """Return ``runs_needed`` if no comparison has enough runs to show a difference, else 0."""
    size = len(comparisons)
    sizes = {item.sizes for item in comparisons}
    enough = not sizes or size * min(smallest_p(*pair) for pair in sizes) <= ALPHA
    return 0 if enough else runs_needed(size)


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
    medians = [float(np.median(values)) if values else None for values in sides]
    simulated = _ratio(*medians) if len(medians) > 1 else medians[0]
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
    return searches.convergence(histories, measure)
