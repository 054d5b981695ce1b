"""Individuals that are compared in several costs: who become parents, and who is on the front."""

from typing import NamedTuple, TypeVar

import numpy as np

from hfc_design.controllers.genome import Population, joined, taken
from hfc_design.core.numbers import Floats, Indices
from hfc_design.search import fronts


class Judged(NamedTuple):
    """Individuals with all that is known of them."""

    population: Population
    score: Floats  # (n,)
    costs: Floats  # (n, objectives) the less, the better
    violation: Floats  # (n,) 0: every constraint is kept
    step: Floats  # (n,) mutation step


class Front(NamedTuple):
    """What nobody dominates of all that was tried and keeps every constraint."""

    population: Population
    score: Floats  # (n,)
    costs: Floats  # (n, objectives)
    step: Floats  # (n,) mutation step


Each = TypeVar("Each", Judged, Front)


def chosen(judged: Each, places: Indices) -> Each:
    """Those at some places."""
    return type(judged)(taken(judged[0], places), *(leaf[places] for leaf in judged[1:]))


def both(one: Each, other: Each) -> Each:
    """One after the other."""
    rest = zip(one[1:], other[1:], strict=True)
    return type(one)(joined(one[0], other[0]), *map(np.concatenate, rest))


def best_first(judged: Judged, kinds: Floats | None = None) -> Indices:
    """The order in which they are preferred; of ``kinds`` (n,) the best of each, then the next.

    Those of a kind that is worse for long would else be gone before they were any good.
    """
    if kinds is None:
        return fronts.best_first(judged.costs, judged.violation)
    place = np.arange(len(judged.step))
    for kind in np.unique(kinds):
        own = np.flatnonzero(kinds == kind)
        order = fronts.best_first(judged.costs[own], judged.violation[own])
        place[own[order]] = np.arange(len(own))
    return np.argsort(place, kind="stable")


def taken_in(front: Front, children: Judged, most: int) -> Front:
    """The front with what belongs there of the children, at most so many."""
    new = chosen(children, np.flatnonzero(children.violation == 0.0))
    found = both(front, Front(new.population, new.score, new.costs, new.step))
    kept = np.flatnonzero(~fronts.dominated(found.costs, found.costs))
    # Of equal ones the oldest stays.
    kept = kept[np.sort(np.unique(found.costs[kept], axis=0, return_index=True)[1])]
    return chosen(found, kept[fronts.spread_out(found.costs[kept], most)])
