"""What runs give: groups that differ in nothing but the seed, how their scores compare, and the
published figures that they stand beside.
"""

from collections import defaultdict
from collections.abc import Sequence
from itertools import combinations, count
from math import comb
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import mannwhitneyu

from hfc_design.batch import folder
from hfc_design.batch.plan import LABEL, SCENARIO, Published, matches
from hfc_design.batch.runs import SEED, Run, batches_below
from hfc_design.core.numbers import Floats
from hfc_design.core.shown import line, table
from hfc_design.core.statistics import holm

#: A difference counts as shown where the corrected p is not above this.
ALPHA = 0.05
#: What is compared: the merit, or the fitness where runs of a task were not all judged alike.
MERIT, FITNESS = "merit", "fitness"
#: What keys begin with that the fitness depends on.
OF_FITNESS = "fitness."
#: So many groups of a task are compared with each other: those with the highest medians.
COMPARED = 20
#: Up to this many runs in the smaller group, and without ties, p is exact.
EXACT = 8
Quartiles = tuple[float, float, float]


class Group(NamedTuple):
    """Runs with the same settings and different seeds."""

    number: int  # from 1; what tables and pictures call it
    task: str  # what the score is of; scores of different tasks do not compare
    measure: str  # what is compared: title of the merit of all runs of the task, or fitness
    settings: dict[str, str]  # those that differ somewhere among all groups
    runs: list[Run]
    finished: list[Run]  # one a seed: run again, it would give the same and tell nothing more
    scores: Floats  # (finished,) in float64; -inf where a design diverged
    quartiles: Quartiles  # of the scores; nan without a finished run

    @property
    def key(self) -> str:
        """Which of the numbers of a run is compared."""
        return FITNESS if self.measure == FITNESS else MERIT

    @property
    def median(self) -> float:
        """Median of the final score."""
        return self.quartiles[1]

    def metrics(self) -> dict[str, Quartiles]:
        """Quartiles of each metric over the finished runs that have it."""
        values: dict[str, list[float]] = defaultdict(list)
        for run in self.finished:
            for key, value in run.score.items():
                if value is not None:
                    values[key].append(value)
        return {key: quartiles(np.array(found)) for key, found in values.items()}

    @property
    def label(self) -> str:
        """Its number and what sets it apart from the other groups of its task."""
        named = (k for k in self.settings if k != SCENARIO and not k.startswith(OF_FITNESS))
        own = [f"{key.rpartition('.')[2]} {self.settings[key]}" for key in named]
        if LABEL in self.settings:
            own = [self.settings[LABEL]]
        return f"{self.number}: {', '.join(own)}" if own else str(self.number)


class Comparison(NamedTuple):
    """Two groups of the same task; the first one's median is not the lower one."""

    first: Group
    second: Group
    a12: float  # Vargha & Delaney's effect size: share of pairs where the first is higher
    p: float  # two-sided Mann-Whitney U test
    holm: float  # p after Holm's correction for all comparisons

    @property
    def testable(self) -> bool:
        """Whether so few runs could show any difference, however large it is."""
        return smallest_p(len(self.first.scores), len(self.second.scores)) <= ALPHA


class Reproduced(NamedTuple):
    """A published figure with the simulated one."""

    figure: str  # of the paper
    quantity: str
    published: float | None
    simulated: float | None  # median over the finished runs; None without any
    ratio: float | None  # simulated over published
    runs: int
    remark: str


class Findings(NamedTuple):
    """What pages and tables tell of the runs below a folder."""

    runs: list[Run]
    groups: list[Group]
    comparisons: list[Comparison]
    figures: list[Reproduced]

    def __repr__(self) -> str:
        return line("Findings", self._told())

    def _repr_html_(self) -> str:
        return table("Findings", self._told())

    def _told(self) -> dict[str, object]:
        return {field: len(value) for field, value in self._asdict().items()}

    def number_of(self) -> dict[str, int]:
        """Path of each run in a group -> the group's number."""
        return {run.path: group.number for group in self.groups for run in group.runs}


def findings(path: Path, runs: list[Run]) -> Findings:
    """What the runs below ``path`` give."""
    groups = grouped(runs)
    return Findings(runs, groups, compared(groups), reproduced(path, runs))


def grouped(runs: Sequence[Run]) -> list[Group]:
    """The groups, task by task, the highest median first."""
    known = [run for run in runs if run.settings]
    keys = dict.fromkeys(key for run in known for key in run.settings if key != SEED)
    differing = [key for key in keys if len({run.setting(key) for run in known}) > 1]
    tasks: dict[str, dict[tuple[str, ...], list[Run]]] = {}
    for run in known:
        members = tasks.setdefault(_task(run, differing), {})
        members.setdefault(tuple(run.setting(key) for key in differing), []).append(run)
    found: list[Group] = []
    for task, members in tasks.items():
        finished = [run for inside in members.values() for run in inside if run.state == "finished"]
        judge, *others = {run.judged_by for run in finished} or {FITNESS}
        # Runs of an earlier version do not name their judge.
        measure = FITNESS if others else judge or FITNESS
        groups = [
            _group(task, measure, dict(zip(differing, own, strict=True)), inside)
            for own, inside in members.items()
        ]
        found += sorted(groups, key=lambda group: (np.isnan(group.median), -group.median))
    return [group._replace(number=k) for k, group in enumerate(found, 1)]


def compared(groups: Sequence[Group]) -> list[Comparison]:
    """Every two groups of a task that have at least two finished runs each."""
    tasks: dict[str, list[Group]] = defaultdict(list)
    for group in groups:
        if len(group.scores) >= 2:
            tasks[group.task].append(group)
    pairs = [pair for inside in tasks.values() for pair in combinations(inside[:COMPARED], 2)]
    a12, p = np.empty(len(pairs)), np.empty(len(pairs))
    alike: dict[tuple[int, int, bool], list[int]] = defaultdict(list)
    for k, (first, second) in enumerate(pairs):
        both = np.concatenate([first.scores, second.scores])
        ties = len(np.unique(both)) < len(both)
        alike[len(first.scores), len(second.scores), ties].append(k)
    for (own, other, ties), places in alike.items():  # one call for thousands of pairs
        x = np.stack([pairs[k][0].scores for k in places])
        y = np.stack([pairs[k][1].scores for k in places])
        exact = min(own, other) <= EXACT and not ties
        found = mannwhitneyu(x, y, axis=1, method="exact" if exact else "asymptotic")
        a12[places], p[places] = found.statistic / (own * other), found.pvalue
    return [Comparison(*pair, *v) for pair, *v in zip(pairs, a12, p, holm(p), strict=True)]


def smallest_p(own: int, other: int) -> float:
    """The p of two groups of that many runs where every run of one beats every run of the other."""
    return min(2 / comb(own + other, own), 1.0)


def runs_needed(comparisons: int) -> int:
    """Runs in each group with which a difference can be shown among so many comparisons."""
    return next(n for n in count(2) if comparisons * smallest_p(n, n) <= ALPHA)


def _task(run: Run, differing: Sequence[str]) -> str:
    """The scenario, and what else the fitness depends on."""
    own = [f"{key} {run.setting(key)}" for key in differing if key.startswith(OF_FITNESS)]
    return ", ".join([run.setting(SCENARIO), *own])


def _group(task: str, measure: str, settings: dict[str, str], runs: list[Run]) -> Group:
    once: dict[str, Run] = {}
    for run in runs:
        if run.state == "finished":
            once.setdefault(run.setting(SEED), run)
    group = Group(0, task, measure, settings, runs, list(once.values()), np.empty(0), (np.nan,) * 3)
    found = [run.score.get(group.key) for run in group.finished]
    scores = np.array([-np.inf if value is None else value for value in found], float)
    return group._replace(scores=scores, quartiles=quartiles(scores))


def quartiles(values: Floats) -> Quartiles:
    """Lower quartile, median and upper quartile, which may be -inf; nan of nothing."""
    if not len(values):
        return np.nan, np.nan, np.nan
    with np.errstate(invalid="ignore"):  # between -inf and what is finite
        found = np.quantile(values, (0.25, 0.5, 0.75))
    low, median, high = np.nan_to_num(found, nan=-np.inf, neginf=-np.inf).tolist()
    return low, median, high


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
