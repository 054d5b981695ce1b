"""Populations that stand island by island, the best of each first.

A ``state`` here is a record with ``population``, ``score`` (n,), ``step`` (n,) and ``island`` (n,).
"""

from typing import Any

import numpy as np

from hfc_design.core.shapes import Floats, Integers

#: A double may score this much of its original before luck is suspected.
LUCK = 0.99


def doubled(state: Any) -> tuple[Integers, Integers]:
    """The best of each island and the last place there; islands of one or two have none."""
    size = np.bincount(state.island)
    best = np.searchsorted(state.island, np.arange(len(size)))
    large = size > 2
    return best[large], (best + size - 1)[large]


def humbled(state: Any, score: Floats) -> Any:
    """The best of an island is worth no more than its double."""
    best, place = doubled(state)
    own = state.score[best]
    worse = score[place] < np.where(own < 0.0, own / LUCK, LUCK * own)
    return state._replace(score=changed(state.score, best[worse], score[place][worse]))


def shares(count: int, islands: int) -> Integers:
    """``count`` places dealt to the islands as evenly as possible, island by island."""
    return np.sort(np.arange(count) % islands)


def changed(array: Any, places: Integers, values: Any) -> Any:
    """The array with other values at some places."""
    found = array.copy()
    found[places] = values
    return found


def taken(state: Any, chosen: Any) -> Any:
    """The chosen individuals; the islands stay as they are."""
    return state._replace(
        population=state.population.take(chosen),
        score=state.score[chosen],
        step=state.step[chosen],
        island=state.island[chosen],
    )


def ranked(state: Any) -> Any:
    """Island by island, the best first."""
    return taken(state, np.lexsort((-state.score, state.island)))
