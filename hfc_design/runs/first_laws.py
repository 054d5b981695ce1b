"""First individuals from a simulated search: laws of few numbers, transferred to every tree."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from hfc_design.controllers.genome import Population, taken
from hfc_design.controllers.hierarchical.law import PREVIOUS
from hfc_design.core.numbers import Floats, Integers
from hfc_design.search.distribution import Distribution, begun, drawn, learnt
from hfc_design.search.multistart_cma import ISLANDS, SAMPLES, multistart, room

#: Share of a search's evaluations for the search of laws, and again for their transfer to trees;
#: and the largest number for each, because more brought no improvement.
SHARE, MOST_SEARCHED, MOST_LAID = 0.25, 11_000, 6_700
#: Share of the random first laws in the search of laws; evaluations of the shortest search with it.
FIRST, FEWEST = 0.05, 15_000
#: Shares of the evaluations of the transfer: for random laws and trees, each with a random *way* to
#: lay the law along the tree; for the best of these on every tree; the rest improves the best ones.
#: Laws are drawn from those with at least ``GOOD`` of the best score: the most aggressive laws do
#: not tolerate the bends of tables.
DRAWN, EVERYWHERE, GOOD = 0.08, 0.08, 0.25
#: First standard deviation of an improvement, and the rounds planned for each improved tree.
NEAR, ROUNDS = 0.1, 30


def first_laws(
    problem: Any, of_laws: Any, evaluations: int, tree: Integers, rng: np.random.Generator
) -> Population | None:
    """Return the best individuals (n,) found for the given trees; None: every law failed.

    Args:
        problem: ``runs.problem.Problem`` of the hierarchies.
        of_laws: ``runs.problem.Problem`` of the laws.
        evaluations: number of evaluations of the whole search.
        tree: (n,) numbers of trees.
        rng: source of all random numbers.
    """
    laws: Any = of_laws.genome
    total = min(int(SHARE * evaluations), MOST_SEARCHED)
    fresh = laws.points(laws.fresh(max(int(FIRST * total), 1), rng))
    tried = multistart(fresh, lambda points: of_laws.rank(laws.laws(points)), total, rng)
    best = tried.score.max()
    if not np.isfinite(best):
        return None
    largest = of_laws.largest_signals(laws.laws(tried.points[int(np.argmax(tried.score))][None]))
    sizes = np.array([largest[name.removeprefix(PREVIOUS)] for name in laws.genome.names])

    def rank(points: Floats, trees: Integers) -> Floats:
        return np.asarray(problem.rank(laws.laid(points, trees, sizes)))

    good = np.flatnonzero(tried.score > best - (1.0 - GOOD) * abs(best))
    total = min(int(SHARE * evaluations), MOST_LAID)
    chosen = tried.points[rng.choice(good, max(int(DRAWN * total), 1))]
    ways = laws.ways(laws.laws(chosen), rng)
    trees, wanted = np.unique(tree, return_counts=True)
    order = np.argsort(-rank(ways, rng.choice(trees, len(ways))), kind="stable")
    each = max(int(EVERYWHERE * total) // len(trees), int(wanted.max()))
    points = np.tile(ways[order[np.arange(each) % len(order)]], (len(trees), 1))
    every = np.repeat(trees, each)
    left = int((1.0 - DRAWN - EVERYWHERE) * total)
    points, every, score = _climbed(points, every, rank(points, every), rank, left, rng)
    order = np.lexsort((-score, every))
    first = np.searchsorted(every[order], trees)
    order_of_first = np.concatenate([order[a : a + n] for a, n in zip(first, wanted, strict=True)])
    places = np.argsort(np.argsort(tree, kind="stable"), kind="stable")
    population: Population = laws.laid(points[order_of_first], every[order_of_first], sizes)
    return taken(population, places)


class Climbing(NamedTuple):
    """A distribution of laws on a tree, with the ways to lay them along the tree."""

    distribution: Distribution
    tree: int
    best: float


def _climbed(
    points: Floats,
    trees: Integers,
    score: Floats,
    rank: Callable[[Floats, Integers], Floats],
    evaluations: int,
    rng: np.random.Generator,
) -> tuple[Floats, Integers, Floats]:
    """Return points, trees and scores: the given ones, then those of searches on the best trees."""
    order = np.argsort(-score, kind="stable")
    alive = order[np.isfinite(score[order])]
    best = alive[np.sort(np.unique(trees[alive], return_index=True)[1])][:ISLANDS]
    islands = [Climbing(begun(points[k], NEAR), int(trees[k]), score[k]) for k in best]
    while islands:
        islands = sorted(islands, key=lambda x: -x.best)[: room(evaluations, ROUNDS, 1)]
        evaluations -= len(islands) * SAMPLES
        if evaluations < 0:
            break
        drawings = np.stack([drawn(x.distribution, SAMPLES, rng) for x in islands])
        flat, on = np.concatenate(drawings), np.repeat([x.tree for x in islands], SAMPLES)
        worth = rank(flat, on)
        points, trees = np.concatenate([points, flat]), np.append(trees, on)
        score = np.append(score, worth)
        rounds = zip(islands, drawings, worth.reshape(-1, SAMPLES), strict=True)
        islands = [
            Climbing(learnt(x.distribution, y, scores), x.tree, max(x.best, float(scores.max())))
            for x, y, scores in rounds
        ]
    return points, trees, score
