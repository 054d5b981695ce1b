"""Whether groups of runs differ by more than chance: in numbers, and in words for people."""

from collections import defaultdict
from collections.abc import Sequence
from itertools import combinations, count
from math import comb
from typing import NamedTuple

import numpy as np
from scipy.stats import mannwhitneyu

from hfc_design.batch.groups import FITNESS, Group
from hfc_design.core.numbers import digits
from hfc_design.core.shown import line
from hfc_design.core.statistics import holm
from hfc_design.pictures.numbers import score

#: A difference counts as shown where the corrected p is not above this.
ALPHA = 0.05
#: So many groups of a task are compared with each other: those with the highest medians.
COMPARED = 20
#: Up to so many pairs of runs, and without ties, p is exact: it takes milliseconds.
EXACT = 1000
#: So many groups are named in a caption; of more the table of the groups says what they are.
NAMED = 12
#: What keys begin with that make a task harder or easier, whoever controls.
OF_MACHINE = ("plant.", "reference.", "load.", "limits.", "sensors.", "start.", "simulation.")


class Comparison(NamedTuple):
    """Two groups of the same task; the first one's median is not the lower one."""

    first: Group
    second: Group
    a12: float  # Vargha & Delaney's effect size: share of pairs where the first is higher
    p: float  # two-sided Mann-Whitney U test
    holm: float  # p after Holm's correction for all comparisons
    exact: bool  # else p is by the normal distribution, corrected for ties

    def __repr__(self) -> str:
        sides = {"first": self.first.label, "second": self.second.label}
        return line("Comparison", {**sides, "a12": self.a12, "p": self.p, "holm": self.holm})

    @property
    def testable(self) -> bool:
        """Whether so few runs could show any difference, however large it is."""
        return smallest_p(len(self.first.scores), len(self.second.scores)) <= ALPHA


def compared(groups: Sequence[Group]) -> list[Comparison]:
    """Every two groups of a task that have at least two finished runs each."""
    tasks: dict[str, list[Group]] = defaultdict(list)
    for group in groups:
        if len(group.scores) >= 2:
            tasks[group.task].append(group)
    highest = (sorted(own, key=lambda one: -one.median)[:COMPARED] for own in tasks.values())
    pairs = [pair for inside in highest for pair in combinations(inside, 2)]
    a12, p = np.empty(len(pairs)), np.empty(len(pairs))
    exactly = np.zeros(len(pairs), bool)
    alike: dict[tuple[int, int, bool], list[int]] = defaultdict(list)
    for k, (first, second) in enumerate(pairs):
        both = digits([*first.scores, *second.scores])
        ties = len(np.unique(both)) < len(both)
        alike[len(first.scores), len(second.scores), ties].append(k)
    for (own, other, ties), places in alike.items():  # one call for thousands of pairs
        x = np.stack([digits(pairs[k][0].scores) for k in places])
        y = np.stack([digits(pairs[k][1].scores) for k in places])
        exact = own * other <= EXACT and not ties
        found = mannwhitneyu(x, y, axis=1, method="exact" if exact else "asymptotic")
        a12[places], p[places] = found.statistic / (own * other), found.pvalue
        exactly[places] = exact
    numbers = (column.tolist() for column in (a12, p, holm(p), exactly))
    return [Comparison(*pair, *own) for pair, *own in zip(pairs, *numbers, strict=True)]


def smallest_p(own: int, other: int) -> float:
    """The p of two groups of that many runs where every run of one beats every run of the other."""
    return min(2 / comb(own + other, own), 1.0)


def runs_needed(comparisons: int) -> int:
    """Runs in each group with which a difference can be shown among so many comparisons."""
    return next(n for n in count(2) if comparisons * smallest_p(n, n) <= ALPHA)


def too_few(comparisons: Sequence[Comparison]) -> int:
    """Runs in each group that were needed; 0 where there are enough to show something."""
    count = len(comparisons)
    sizes = {(len(item.first.scores), len(item.second.scores)) for item in comparisons}
    enough = not sizes or count * min(smallest_p(*own) for own in sizes) <= ALPHA
    return 0 if enough else runs_needed(count)


def sentence(groups: Sequence[Group], comparisons: Sequence[Comparison]) -> str:
    """What came out of a task, nothing of groups whose runs are too few to tell them apart.

    Args:
        groups: of the task, the best first.
        comparisons: of all tasks, which p is corrected for.
    """
    highest = max(groups, key=lambda group: np.nan_to_num(group.median, nan=-np.inf))
    if not highest.finished:
        return "No run has finished."
    told = ""
    if answers := groups[0].answers:
        told = f"{answers[0]} designs of group {groups[0].label} can be used; {answers[1]} % of "
        told += "the unseen machines pass in the median. "
    return told + _highest(highest, groups, comparisons)


def _highest(highest: Group, groups: Sequence[Group], comparisons: Sequence[Comparison]) -> str:
    against = [item for item in comparisons if item.first is highest]
    if against and (needed := too_few(comparisons)):
        several = f"{len(comparisons)} comparisons need" if len(comparisons) > 1 else "it takes"
        return (
            "Which group is better cannot be shown with so few runs, however much they differ: "
            f"{several} at least {needed} runs in each group."
        )
    note = _unlike(groups)
    count = len(highest.finished)
    median = "fitness" if highest.measure == FITNESS else f"of {highest.measure}"
    told = f"The highest median {median} is {score(highest.median)}, of group {highest.label}"
    told += f" ({count} run{'s' if count > 1 else ''})"
    if not against:
        return f"{told}{_alone(groups)}.{note}"
    shown = sum(item.holm <= ALPHA for item in against)
    if len(against) > 1:
        return f"{told}; by more than chance higher than {shown} of {len(against)} others.{note}"
    lower = "The other group is lower by more than chance"
    return f"{told}. {lower if shown else 'That the other group is lower may be chance'}.{note}"


def _unlike(groups: Sequence[Group]) -> str:
    """That groups of a task differ in more than controller and search, and in what they rank by."""
    keys = {key for group in groups for key in group.settings if key.startswith(OF_MACHINE)}
    each = {key: {group.settings.get(key) for group in groups} for key in keys}
    differ = ", ".join(sorted(key for key, values in each.items() if len(values) > 1))
    told = f" They differ in {differ} too: a higher score may be that of an easier task."
    merits = {run.judged_by for group in groups for run in group.finished if run.judged_by}
    other = f" Their searches ranked by different merits ({'; '.join(sorted(merits))})."
    return (told if differ else "") + (other if len(merits) > 1 else "")


def _alone(groups: Sequence[Group]) -> str:
    """That a single run of a search says nothing about another group."""
    searched = any(run.searched for group in groups for run in group.finished)
    chance = len(groups) > 1 and searched
    return ", which may be chance: a group needs several seeds" if chance else ""


def broken(groups: Sequence[Group]) -> str:
    """Which groups have runs that end with a design which breaks constraints; "" without any."""
    of_each = [
        f"{group.broken} of {len(group.finished)} runs of group {group.number}"
        for group in groups
        if group.broken
    ]
    if not of_each:
        return ""
    others = f" and runs of {len(of_each) - NAMED} more groups" if len(of_each) > NAMED else ""
    return (
        f"{', '.join(of_each[:NAMED])}{others} break constraints: no design that was tried there "
        "keeps every one, and the one that breaks them least counts."
    )


def key_of(groups: Sequence[Group]) -> str:
    """What the numbers of groups mean, for a caption that stands alone."""
    tasks = {group.task for group in groups}
    if len(groups) > NAMED:
        return "What the numbers of the groups mean is in the table of the groups."
    each = (f"{one.label} in {one.task}" if len(tasks) > 1 else one.label for one in groups)
    return f"Groups: {'; '.join(each)}."
