"""Individuals with several costs: selection of parents and of the front."""

from typing import NamedTuple

import numpy as np

from hfc_design.controllers.genome import Population, joined, taken
from hfc_design.core.numbers import Floats, Indices
from hfc_design.search import fronts


class Judged(NamedTuple):
    """Individuals with their results."""

    population: Population
    score: Floats  # (n,)
    costs: Floats  # (n, objectives) the less, the better
    violation: Floats  # (n,) 0: every constraint is kept
    step: Floats  # (n,) mutation step


class Front(NamedTuple):
    """Individuals that meet every constraint and that no other tried individual dominates."""

    population: Population
    score: Floats  # (n,)
    costs: Floats  # (n, objectives)
    step: Floats  # (n,) mutation step


def best_first(judged: Judged, kinds: Floats | None = None) -> Indices:
    """Return the indices in order; with ``kinds`` (n,): the best of each kind, the second, ...

    Without ``kinds``, a kind that is worse for a long time is lost before it becomes good.
    """
    if kinds is None:
        return fronts.best_first(judged.costs, judged.violation)
    place = np.arange(len(judged.step))
    for kind in np.unique(kinds):
        members = np.flatnonzero(kinds == kind)
        order = fronts.best_first(judged.costs[members], judged.violation[members])
        place[members[order]] = np.arange(len(members))
    return np.argsort(place, kind="stable")


def insert(front: Front, children: Judged, most: int) -> Front:
    """Return the front with the children that belong to it, reduced to ``most`` individuals."""
    new = taken(children, np.flatnonzero(children.violation == 0.0))
    merged = joined(front, Front(new.population, new.score, new.costs, new.step))
    survivors = np.flatnonzero(~fronts.dominated(merged.costs, merged.costs))
    # Of individuals with equal costs the oldest stays.
    survivors = survivors[np.sort(np.unique(merged.costs[survivors], axis=0, return_index=True)[1])]
    return taken(merged, survivors[fronts.spread_out(merged.costs[survivors], most)])
