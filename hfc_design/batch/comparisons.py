"""Statistical comparison of groups of runs."""

from collections import defaultdict
from collections.abc import Sequence
from itertools import combinations, count
from math import comb
from typing import NamedTuple

import numpy as np
from scipy.stats import mannwhitneyu

from hfc_design.batch.groups import Group
from hfc_design.core.numbers import digits
from hfc_design.core.statistics import holm
from hfc_design.core.tables import line

#: A difference counts as significant if the corrected p is not above this level.
ALPHA = 0.05
#: Largest number of groups of a task that are compared: those with the highest medians.
COMPARED = 20
#: Without ties, p is exact up to this many pairs of runs, which takes milliseconds.
EXACT = 1000


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
    samples = [(digits(first.scores), digits(second.scores)) for first, second in pairs]
    alike: dict[tuple[int, int, bool], list[int]] = defaultdict(list)
    for k, (x, y) in enumerate(samples):
        ties = len({*x.tolist(), *y.tolist()}) < len(x) + len(y)
        alike[len(x), len(y), len(x) * len(y) <= EXACT and not ties].append(k)
    a12, p, exact = np.empty(len(pairs)), np.empty(len(pairs)), np.zeros(len(pairs), bool)
    for (n, m, exactly), places in alike.items():  # one call for thousands of pairs
        x, y = (np.stack(side) for side in zip(*(samples[k] for k in places), strict=True))
        tests = mannwhitneyu(x, y, axis=1, method="exact" if exactly else "asymptotic")
        a12[places], p[places], exact[places] = tests.statistic / (n * m), tests.pvalue, exactly
    numbers = zip(*(column.tolist() for column in (a12, p, holm(p), exact)), strict=True)
    return [Comparison(*pair, *tested) for pair, tested in zip(pairs, numbers, strict=True)]


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
