"""CMA-ES: a distribution that moves towards good samples, in the stages of the genome.

Scores are compared only within a generation, so that each generation may be judged on other
machines; the result is the mean of the distribution and not the luckiest individual.
"""

from itertools import accumulate
from typing import Literal, NamedTuple

import numpy as np
from pydantic import Field

from hfc_design.controllers.genome import Population, Stage, replaced, taken
from hfc_design.controllers.hierarchical.record import Bounds
from hfc_design.controllers.kind import ControllerSettings
from hfc_design.core.checkpoint import flat
from hfc_design.core.numbers import Floats, Integers
from hfc_design.core.records import NotNegative, Ordered, Positive
from hfc_design.search.distribution import WHOLE, Distribution, begun, drawn, learnt
from hfc_design.search.strategy import Probability, Strategy, StrategySettings, Task
from hfc_design.search.successive_halving import heats

#: The hard machines are determined again after every 1 / ``ASKING`` of the generations.
ASKING = 18
#: How often samples that violate constraints before any simulation are replaced by new ones.
AGAIN = 3
#: If the first mean violates constraints: number of other means that are drawn, their spread in
#: first standard deviations, and how many populations of the best of them are simulated.
MANY, WIDE, TRIED = 2048, 4.0, 6
#: Number of averages that are kept: on few machines the last one need not look the best.
TRAIL = 40


class CmaSettings(Ordered, Bounds, StrategySettings):
    """CMA-ES, stage by stage; where structures matter, several compete and half of them remain."""

    keys_last = Bounds.model_fields
    preset: Literal["cma"] = "cma"
    population: int = Field(16, ge=6, le=10_000)
    generations: int = Field(450, ge=1, le=10_000_000)
    step: Positive = 1.0  # factor on the first standard deviations [1]
    trees: int = Field(4, ge=1, le=1000)  # number of competing structures
    hardened: Probability = 0.6  # share of the generations, at the end, with difficult machines [1]
    stick_penalty: NotNegative = 0.0  # ranked by fitness / (1 + this times the stick share) [1]


class CmaState(NamedTuple):
    """One island for each structure that still competes."""

    population: Population  # (islands,) the means
    score: Floats  # (islands,) of the means when they were last judged
    about: Population  # (1,) result of the previous stage; in the first stage any individual
    trail: Population  # (``TRAIL``,) averages of means, at even intervals of the last half
    islands: Distribution  # arrays with the islands in the leading axis
    hard: Integers  # indices of the machines that are hard for the best mean; empty: not known yet


class Asked(NamedTuple):
    """Samples of one island; the last one is the mean of the island."""

    population: Population
    points: Floats  # (n, size)
    island: int
    stage: int
    machines: Integers | None  # indices of the hard ones; None: not known yet
    broken: Floats | None  # (n,) violations known without a simulation, see ``Task.broken``
    structures: int  # number of structures that still compete


class Place(NamedTuple):
    """Position of a generation within the search."""

    stage: int
    within: int  # generations of the stage that are done
    room: int  # islands that still compete


class Cma(NamedTuple):
    """The strategy; in each generation it samples one of the islands, in turn."""

    settings: CmaSettings
    task: Task

    def start(self, rng: np.random.Generator) -> tuple[CmaState, Asked]:
        """Return state and samples of the first stage, around the genome's first individual."""
        about, place = taken(self.task.genome.empty(), slice(1)), self._place(0)
        return self._candidates(self._begun(place, about, rng), place, rng)

    def ask(
        self, state: CmaState, generation: int, rng: np.random.Generator
    ) -> tuple[CmaState, Asked]:
        """Return state and samples of the next island; a stage or a heat of islands may end."""
        place = self._place(generation)
        state = self._hardened(self._remembered(state, generation), generation)
        if place.stage != self._place(generation - 1).stage:
            best = int(np.argmax(state.score))
            good = bool(np.isfinite(state.score[best]))  # else all means of the stage failed
            about = taken(state.population, np.array([best])) if good else state.about
            state = self._begun(place, about, rng, state)
        elif place.room < len(state.score):
            survivors = np.sort(np.argsort(-state.score, kind="stable")[: place.room])
            competing = state.population, state.score, state.islands
            population, score, islands = taken(competing, survivors)
            state = state._replace(population=population, score=score, islands=islands)
        return self._candidates(state, place, rng)

    def tell(self, state: CmaState, candidates: Asked, score: Floats) -> CmaState:
        """Return the state in which the sampled island has learned from its scores."""
        k, stage = candidates.island, self._stage(state.about, candidates.stage)
        after = learnt(taken(state.islands, k), candidates.points[:-1], score[:-1])
        islands, score = replaced((state.islands, state.score), k, (after, score[-1]))
        mean = stage.members(after.mean[None], state.population.tree[k : k + 1])
        population = replaced(state.population, np.array([k]), mean)
        return state._replace(population=population, score=score, islands=islands)

    def _remembered(self, state: CmaState, generation: int) -> CmaState:
        """Return the state; at even intervals, put the best island's average into the trail."""
        total = self.settings.generations
        every = max(total // (2 * TRAIL), 1)
        behind = generation - (total - every * TRAIL)
        if behind < 0 or behind % every:
            return state
        k = np.array([int(np.argmax(state.score))])
        stage = self._stage(state.about, self._place(generation - 1).stage)
        average = stage.members(state.islands.average[k], state.population.tree[k])
        return state._replace(trail=replaced(state.trail, np.array([behind // every]), average))

    def _hardened(self, state: CmaState, generation: int) -> CmaState:
        """Return the state; at even intervals, determine the hard machines of the best mean."""
        total, hardest = self.settings.generations, self.task.hardest
        behind = generation - round((1.0 - self.settings.hardened) * total)
        if hardest is None or behind < 0 or behind % max(total // ASKING, 1):
            return state
        best = taken(state.population, np.array([int(np.argmax(state.score))]))
        machines = hardest(best, 0.0)
        return state._replace(hard=machines[machines > 0])

    def _place(self, generation: int) -> Place:
        stages = self.task.genome.stages
        ends = [*accumulate(share for share, _ in stages)]
        total = self.settings.generations
        last = [round(total * end / ends[-1]) for end in ends]
        number = next(k for k, end in enumerate(last) if generation < end)
        first, competing = (last[number - 1] if number else 0), stages[number][1]
        islands = min(self.settings.trees, self.task.genome.structures) if competing else 1
        sizes = heats(islands)
        length = max(last[number] - first, 1)
        return Place(number, generation - first, sizes[(generation - first) * len(sizes) // length])

    def _begun(
        self,
        place: Place,
        about: Population,
        rng: np.random.Generator,
        state: CmaState | None = None,
    ) -> CmaState:
        genome = self.task.genome
        stage = self._stage(about, place.stage)
        one = begun(stage.start, stage.step * self.settings.step)
        each = Distribution(*(np.repeat(leaf[None], place.room, axis=0) for leaf in one))
        others = np.setdiff1d(np.arange(genome.structures), about.tree)
        tree = np.append(about.tree, rng.permutation(others))
        if not place.stage:
            means = self._apart(stage, one, place.room, rng)
            tree = self._promising(stage, means[:1], tree)
            each.mean[:] = means
        tree = tree[: place.room]
        population = stage.members(each.mean, tree)
        trail = taken(population, np.zeros(TRAIL, int)) if state is None else state.trail
        hard = np.empty(0, np.int64) if state is None else state.hard
        return CmaState(population, np.full(place.room, -np.inf), about, trail, each, hard)

    def _promising(self, stage: Stage, mean: Floats, tree: Integers) -> Integers:
        """Return the structures; if more than can compete, some of them, best at ``mean`` first."""
        if self.task.worth is None or len(tree) <= self.settings.trees:
            return tree
        tree = tree[: self.settings.population]
        rank = self.task.worth(stage.members(np.repeat(mean, len(tree), axis=0), tree))
        return tree[np.argsort(-rank, kind="stable")]

    def _apart(
        self, stage: Stage, one: Distribution, count: int, rng: np.random.Generator
    ) -> Floats:
        """Return first means (``count``, size); different starts may end in different optima.

        The first mean is that of the stage, unless it has a violation that is known at once. Then
        many are drawn, those with the least violation are simulated, and the best are returned.
        """
        means = one.mean + one.step * rng.standard_normal((count, one.mean.size))
        means[0] = one.mean
        broken, worth, tree = self.task.broken, self.task.worth, np.zeros(MANY, int)
        if broken is None or worth is None or not broken(stage.members(means[:1], tree[:1])).any():
            return means
        many = one.mean + WIDE * one.step * rng.standard_normal((MANY, one.mean.size))
        off = broken(stage.members(many, tree))
        some = many[np.argsort(off, kind="stable")[: TRIED * self.settings.population]]
        each = np.array_split(some, TRIED)  # each of the size of a generation
        rank = np.concatenate([worth(stage.members(x, tree[: len(x)])) for x in each])
        return np.asarray(some[np.argsort(-rank, kind="stable")[:count]])

    def _stage(self, about: Population, number: int) -> Stage:
        return self.task.genome.stage(number, about if number else None)

    def _candidates(
        self, state: CmaState, place: Place, rng: np.random.Generator
    ) -> tuple[CmaState, Asked]:
        island = place.within % len(state.score)
        distribution = taken(state.islands, island)
        tree = state.population.tree[island : island + 1]
        stage = self._stage(state.about, place.stage)
        points, off = self._drawn(distribution, stage, tree, rng)
        members = stage.members(points, np.repeat(tree, len(points)))
        hard = state.hard if len(state.hard) else None
        competing = len(np.unique(state.population.tree))
        return state, Asked(members, points, island, place.stage, hard, off, competing)

    def _drawn(
        self, distribution: Distribution, stage: Stage, tree: Integers, rng: np.random.Generator
    ) -> tuple[Floats, Floats | None]:
        """Return the samples with the least known violations, then the mean, (n, size).

        Also return the violation of each, (n,); None if it is not known without a simulation.
        """
        count, broken = self.settings.population - 1, self.task.broken
        points, mean = drawn(distribution, count, rng), distribution.mean[None]
        if broken is None:
            return np.concatenate([points, mean]), None
        off = broken(stage.members(np.concatenate([points, mean]), np.repeat(tree, count + 1)))
        off, of_mean = off[:-1], off[-1:]
        for _ in range(AGAIN):
            if not off.any():
                break
            more = drawn(distribution, count, rng)
            off = np.append(off, broken(stage.members(more, np.repeat(tree, count))))
            best = np.argsort(off, kind="stable")[:count]
            points, off = np.concatenate([points, more])[best], off[best]
        return np.concatenate([points, mean]), np.append(off, of_mean)


def _fault(settings: CmaSettings, controller: ControllerSettings) -> str | None:
    if controller.staged:
        return None
    if "linear" in type(controller).model_fields:
        return "searches hierarchies with a linear part: add [controller.linear], or use race"
    for axis, axis_controller in getattr(controller, "axes", {}).items():
        if fault := _fault(settings, axis_controller):
            return f"axis {axis}: {fault}"
    return f"does not search controllers of kind {controller.kind}; use race"


def _sound(settings: CmaSettings, state: CmaState) -> bool:
    mean, step, covariance, path, steady, age, average = state.islands
    islands, size = mean.shape
    leaves = flat((state.islands, state.about, state.trail))
    finite = all(np.isfinite(numbers).all() for _, numbers in leaves)
    return (
        state.population.tree.shape == state.score.shape == (islands,)
        and 0 < islands <= settings.trees
        and len(np.unique(state.population.tree)) == islands
        and state.about.tree.shape == (1,)
        and state.hard.ndim == 1
        and bool((state.hard > 0).all())
        and state.trail.tree.shape == (TRAIL,)
        and step.shape == age.shape == (islands, 1)
        and mean.shape == path.shape == steady.shape == average.shape
        and covariance.shape == (islands, size, size if size <= WHOLE else 1)
        and bool((state.score < np.inf).all())
        and finite
        and bool((step > 0.0).all())
    )


STRATEGY = Strategy(
    "cma",
    CmaSettings,
    CmaState,
    Cma,
    "covariance matrix adaptation (CMA-ES), in the stages of the controller",
    _fault,
    _sound,
    forgets=lambda settings: int(settings.generations),
)
