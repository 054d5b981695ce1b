"""Groups of runs that differ only in the seed, and their statistical comparison."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, count
from math import comb
from typing import NamedTuple

import numpy as np
from scipy.stats import mannwhitneyu

from hfc_design.batch.plan import SCENARIO
from hfc_design.batch.results import VERDICTS, Run
from hfc_design.core.numbers import Floats, digits
from hfc_design.core.statistics import holm
from hfc_design.core.tables import line
from hfc_design.files.labels import LABEL, SEED
from hfc_design.runs.champion import LEAST_VIOLATED

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
        count = sum(bool(run.use.verdict) for run in self.finished)
        return [f"{round(yes * count)} of {count}", f"{100 * share:.4g}"] if count else []

    @property
    def place(self) -> tuple[float, ...]:
        """Sort key of groups, the best first: shares of verdicts, share of machines, median."""
        return *(-x for x in self._usable), np.isnan(self.median), -self.median

    @property
    def _usable(self) -> tuple[float, ...]:
        """Shares of the two best verdicts, median share of machines that pass; 0 if unknown."""
        uses = [run.use for run in self.finished if run.use.verdict]
        best = (sum(use.verdict == x for use in uses) / max(len(uses), 1) for x in VERDICTS[:2])
        return *best, float(np.median([use.share or 0.0 for use in uses] or [0.0]))

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
