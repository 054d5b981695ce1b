"""First individuals that were found by simulation: laws of few numbers, laid down on every tree."""

from typing import Any, NamedTuple

import numpy as np

from hfc_design.controllers.genome import Population, taken
from hfc_design.controllers.hierarchical.law import PREVIOUS
from hfc_design.core.numbers import Floats, Integers
from hfc_design.search.distribution import Distribution, begun, drawn, learnt
from hfc_design.search.restarts import ISLANDS, SAMPLES, Tried, climbed, room

#: Share of a search's evaluations that goes to laws, and as much to laying them down; and how many
#: each of them takes at most, because more have brought nothing.
SHARE, MOST_SEARCHED, MOST_LAID = 0.25, 11_000, 6_700
#: First laws in shares of those evaluations; a shorter search does without laws.
FIRST, FEWEST = 0.05, 15_000
#: Shares of the second part: laws, ways and trees are drawn; the best of it meet every tree; what
#: is best there climbs on its tree. Drawn are all laws that are worth ``GOOD`` of the best: the
#: sharpest ones do not stand the bends of tables.
DRAWN, EVERYWHERE, GOOD = 0.08, 0.08, 0.25
#: First standard deviation there, and how many rounds a tree that climbs has before it.
NEAR, ROUNDS = 0.1, 30


def worthwhile(evaluations: int) -> bool:
    """Whether a search of so many is long enough to search laws first."""
    return evaluations >= FEWEST


class Climbing(NamedTuple):
    """A distribution of laws and ways on a tree."""

    distribution: Distribution
    tree: int
    best: float

    def after(self, points: Floats, score: Floats) -> "Climbing":
        """Having learnt what its points are worth."""
        distribution = learnt(self.distribution, points, score)
        return Climbing(distribution, self.tree, max(self.best, float(score.max())))


class FirstLaws(NamedTuple):
    """What is known of a scenario once its laws have been searched."""

    problem: Any  # ``runs.problem.Problem`` of the hierarchies
    of_laws: Any  # the same of the laws
    evaluations: int  # of the whole search

    def dealt(self, tree: Integers, rng: np.random.Generator) -> Population | None:
        """(n,) individuals on the given trees, of each its best ones; None: no law is finite."""
        laws: Any = self.of_laws.genome
        tried = self._searched(rng)
        best = tried.score.max()
        if not np.isfinite(best):
            return None
        own = laws.laws(tried.points[int(np.argmax(tried.score))][None])
        sizes = self._sizes(own)
        good = np.flatnonzero(tried.score > best - (1.0 - GOOD) * abs(best))
        total = min(int(SHARE * self.evaluations), MOST_LAID)
        chosen = tried.points[rng.choice(good, max(int(DRAWN * total), 1))]
        ways = laws.ways(laws.laws(chosen), rng)
        trees, wanted = np.unique(tree, return_counts=True)
        score = self._laid(ways, rng.choice(trees, len(ways)), sizes)
        order = np.argsort(-score, kind="stable")
        each = max(int(EVERYWHERE * total) // len(trees), int(wanted.max()))
        points = np.tile(ways[order[np.arange(each) % len(order)]], (len(trees), 1))
        every = np.repeat(trees, each)
        score = self._laid(points, every, sizes)
        left = int((1.0 - DRAWN - EVERYWHERE) * total)
        points, every, score = self._climbed(points, every, score, sizes, left, rng)
        order = np.lexsort((-score, every))
        first = np.searchsorted(every[order], trees)
        found = np.concatenate([order[a : a + n] for a, n in zip(first, wanted, strict=True)])
        places = np.argsort(np.argsort(tree, kind="stable"), kind="stable")
        population: Population = laws.laid(points[found], every[found], sizes)
        return taken(population, places)

    def _climbed(
        self,
        points: Floats,
        trees: Integers,
        score: Floats,
        sizes: Floats,
        evaluations: int,
        rng: np.random.Generator,
    ) -> tuple[Floats, Integers, Floats]:
        """These, and what the best of the best trees become there."""
        order = np.argsort(-score, kind="stable")
        alive = order[np.isfinite(score[order])]
        best = alive[np.sort(np.unique(trees[alive], return_index=True)[1])][:ISLANDS]
        if not len(best):
            return points, trees, score
        islands = [Climbing(begun(points[k], NEAR), int(trees[k]), score[k]) for k in best]
        while True:
            islands = sorted(islands, key=lambda one: -one.best)[: room(evaluations, ROUNDS, 1)]
            evaluations -= len(islands) * SAMPLES
            if evaluations < 0:
                break
            asked = [drawn(one.distribution, SAMPLES, rng) for one in islands]
            flat, each = np.concatenate(asked), np.repeat([one.tree for one in islands], SAMPLES)
            told = self._laid(flat, each, sizes)
            found = zip(islands, asked, np.split(told, len(islands)), strict=True)
            islands = [one.after(*more) for one, *more in found]
            points, trees = np.concatenate([points, flat]), np.append(trees, each)
            score = np.append(score, told)
        return points, trees, score

    def _laid(self, points: Floats, trees: Integers, sizes: Floats) -> Floats:
        return np.asarray(self.problem.rank(self.of_laws.genome.laid(points, trees, sizes)))

    def _searched(self, rng: np.random.Generator) -> Tried:
        """Laws and what they are worth."""
        laws, total = self.of_laws.genome, min(int(SHARE * self.evaluations), MOST_SEARCHED)
        first = laws.points(laws.fresh(max(int(FIRST * total), 1), rng))
        return climbed(first, lambda points: self.of_laws.rank(laws.laws(points)), total, rng)

    def _sizes(self, law: Any) -> Floats:
        """(inputs,) largest magnitudes of the inputs of a hierarchy under a law."""
        found = self.of_laws.largest_signals(law)
        names = self.of_laws.genome.genome.names
        return np.array([found[name.removeprefix(PREVIOUS)] for name in names])
