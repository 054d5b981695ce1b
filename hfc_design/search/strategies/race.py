"""The default strategy: a race of structures with Gauss-Newton steps at its end."""

from typing import Literal, NamedTuple

import numpy as np
from pydantic import Field

from hfc_design.controllers.genome import Population, joined, replaced, taken
from hfc_design.controllers.hierarchical.record import Bounds
from hfc_design.core.checkpoint import flat
from hfc_design.core.numbers import Floats, Integers, Mask
from hfc_design.core.records import NotNegative, Positive
from hfc_design.search.newton import individuals, some_numbers
from hfc_design.search.strategy import Probability, Strategy, StrategySettings, Task
from hfc_design.search.successive_halving import room, shares

#: Share of an individual's score that its double has to reach; else the score was luck.
LUCK = 0.99
#: First damping of Gauss-Newton steps, its factor after a failed step, and the largest damping: it
#: is limited, as the next step changes other numbers and may succeed.
FIRST_DAMPING, FAILURE, LARGEST = 1.0, 10.0, 1e4
#: Individuals whose numbers differ by up to this share of the largest count as nearly equal.
KIN = 1e-3


class RaceSettings(Bounds, StrategySettings):
    """A race of structures: every tree is an island, and after each heat half of them remain.

    Some of the first individuals use knowledge of the machine, if the kind of controller has it.
    Inside an island individuals breed; when few islands are left, Gauss-Newton steps from the best
    of an island compete with its children.
    """

    preset: Literal["race"] = "race"
    population: int = Field(840, ge=1, le=10_000_000)
    generations: int = Field(100, ge=1, le=10_000_000)
    #: share of the initial individuals derived from the machine's model [1]
    informed: Probability = 0.5
    #: individuals of a tournament, of which the best becomes a parent
    tournament: int = Field(3, ge=1)
    blend: Probability = 0.5  # share of children from two parents [1]
    step: Positive = 0.2  # first mutation step, relative [1]
    stick_penalty: NotNegative = 300.0  # ranked by fitness / (1 + this times the stick share) [1]
    #: number of remaining structures at which Gauss-Newton steps begin
    newton_islands: int = Field(8, ge=0)
    newton_steps: int = Field(4, ge=0)  # Gauss-Newton steps per generation
    newton_numbers: int = Field(96, ge=1)  # numbers changed in a step, chosen at random for each


class RaceState(NamedTuple):
    """Individuals island by island, the best of each island first."""

    population: Population
    score: Floats  # (n,)
    step: Floats  # (n,) mutation step, inherited and itself mutated
    island: Integers  # (n,) which island an individual lives on: 0, 1, 2, ...
    damping: Floats  # (islands,) of the next Gauss-Newton step


class Asked(NamedTuple):
    """Candidates, and the data about them that ``tell`` needs."""

    population: Population
    step: Floats  # (n,)
    damping: Floats  # (n,) damping of a Gauss-Newton proposal; nan for a child
    needed: Floats  # (n,) a score below this need not be exact


class SuccessiveHalving(NamedTuple):
    """The strategy; everything that changes is in ``RaceState``."""

    settings: RaceSettings
    task: Task

    def start(self, rng: np.random.Generator) -> tuple[RaceState | None, Asked]:
        """Return first individuals of all trees, or of random ones if trees are too many."""
        s = self.settings
        trees = self.task.genome.structures
        islands = min(trees, s.population)
        chosen = np.sort(rng.permutation(trees)[:islands])
        tree = chosen[shares(s.population, islands)]
        population = self.task.genome.fresh(tree, rng)
        some = np.flatnonzero(rng.random(len(tree)) < s.informed)
        known = self.task.informed or self.task.genome.informed
        if len(some) and (informed := known(tree[some], rng)) is not None:
            population = replaced(population, some, informed)
        each = (np.full(s.population, value) for value in (s.step, np.nan, -np.inf))
        return None, Asked(population, *each)

    def ask(
        self, state: RaceState, generation: int, rng: np.random.Generator
    ) -> tuple[RaceState, Asked]:
        """Return children of every island, some replaced by Gauss-Newton steps from its best."""
        s = self.settings
        state = self._culled(state, generation)
        candidates = self._bred(state, rng)
        # The last child of each island becomes a double of its best, a millionth off: a loop that
        # is nearly chaotic may score well by luck; its double then does not.
        best, place = doubled(state)
        double = self.task.genome.nudged(taken(state.population, best), rng)
        candidates = candidates._replace(
            population=replaced(candidates.population, place, double),
            needed=replaced(candidates.needed, place, -np.inf),
        )
        islands = len(state.damping)
        if self.task.linearised is None or islands > s.newton_islands:
            return state, candidates
        # Islands take turns; if there are fewer islands than steps, some get several steps.
        turns = (np.arange(s.newton_steps) + generation * s.newton_steps) % islands
        for k, count in zip(*np.unique(turns, return_counts=True), strict=True):
            candidates = self._stepped(state, candidates, int(k), int(count), rng)
        return state, candidates

    def tell(self, state: RaceState | None, candidates: Asked, score: Floats) -> RaceState:
        """Return the state after parents and children have competed inside each island."""
        if state is None:
            island = np.unique(candidates.population.tree, return_inverse=True)[1]
            damping = np.full(island.max() + 1, FIRST_DAMPING)
            return ranked(RaceState(candidates.population, score, candidates.step, island, damping))
        state, score = with_kin(state, humbled(state, score), candidates.population, score)
        damping = state.damping.copy()
        for k in range(len(damping)):
            home = np.flatnonzero(state.island == k)
            best = home[score[home].argmax()]
            improved = score[best] > state.score[home[0]]
            tried = np.isfinite(candidates.damping[home]).any()
            if improved:
                stepped = np.isfinite(candidates.damping[best])
                damping[k] = candidates.damping[best] if stepped else min(damping[k], FIRST_DAMPING)
            elif tried:
                damping[k] = min(damping[k] * FAILURE, LARGEST)
        children = candidates.population, score, candidates.step, state.island
        both = ranked(RaceState(*joined(state[:4], children), damping))
        rank = np.arange(len(both.island)) - np.searchsorted(both.island, both.island)
        return chosen_of(both, rank < np.bincount(state.island)[both.island])

    def _culled(self, state: RaceState, generation: int) -> RaceState:
        """Drop the islands that this heat has no room for and fill their places with survivors."""
        s = self.settings
        trees = self.task.genome.structures
        stepping = trees if self.task.linearised is None else s.newton_islands
        places = room(trees, stepping, generation / s.generations)
        if len(state.damping) <= places:
            return state
        first = np.searchsorted(state.island, np.arange(len(state.damping)))
        survivors = np.sort(np.argsort(-state.score[first], kind="stable")[:places])
        island = shares(len(state.island), places)
        rank = np.arange(len(island)) - np.searchsorted(island, island)
        lived = np.bincount(state.island)[survivors][island]
        chosen = chosen_of(state, first[survivors][island] + rank % lived)
        return ranked(chosen._replace(island=island, damping=state.damping[survivors]))

    def _bred(self, state: RaceState, rng: np.random.Generator) -> Asked:
        """Return a child for every individual, with parents from the same island."""
        s, count = self.settings, len(state.island)
        first = np.searchsorted(state.island, state.island)
        size = np.bincount(state.island)[state.island]

        def parent(rounds: int) -> Integers:
            # The best of an island stands first, so the smallest of some draws wins.
            return first + (rng.random((rounds, count)).min(axis=0) * size).astype(np.int64)

        one, other = parent(s.tournament), parent(2)
        genome, population = self.task.genome, state.population
        share = np.where(rng.random(count) < s.blend, rng.uniform(-0.25, 1.25, count), 0.0)
        mixed = genome.blended(taken(population, one), taken(population, other), share)
        step = np.clip(state.step[one] * np.exp(0.3 * rng.standard_normal(count)), 1e-3, 1.0)
        # A child takes the place of the worst of its island, or dies.
        worst = state.score[first + size - 1]
        return Asked(genome.mutated(mixed, step, rng), step, np.full(count, np.nan), worst)

    def _stepped(
        self, state: RaceState, candidates: Asked, k: int, steps: int, rng: np.random.Generator
    ) -> Asked:
        """Replace half of the children of island ``k`` by Gauss-Newton steps from its best."""
        home = np.flatnonzero(state.island == k)
        best = taken(state.population, home[:1])
        assert self.task.linearised is not None
        population, damping = candidates.population, candidates.damping.copy()
        for places in np.array_split(home[: (len(home) + 1) // 2], steps):
            numbers = some_numbers(self.task.genome, best, self.settings.newton_numbers, rng)
            linear = self.task.linearised(best, numbers)
            if linear is None or not len(places):
                continue
            at = (best, linear, state.damping[k], len(places))
            replacements, damping[places] = individuals(self.task.genome, *at)
            population = replaced(population, places, replacements)
        return candidates._replace(population=population, damping=damping)


def doubled(state: RaceState) -> tuple[Integers, Integers]:
    """Return indices of the first (best) and last individual of islands of three or more."""
    size = np.bincount(state.island)
    best = np.searchsorted(state.island, np.arange(len(size)))
    large = size > 2
    return best[large], (best + size - 1)[large]


def humbled(state: RaceState, score: Floats) -> RaceState:
    """Give the best of each island the score of its double, if that score is much worse."""
    best, place = doubled(state)
    best_score = state.score[best]
    worse = score[place] < np.where(best_score < 0.0, best_score / LUCK, LUCK * best_score)
    return state._replace(score=replaced(state.score, best[worse], score[place][worse]))


def with_kin(
    state: RaceState, humble: RaceState, children: Population, score: Floats
) -> tuple[RaceState, Floats]:
    """Limit the scores of individuals nearly equal to a best one that ``humbled`` has changed.

    Small steps make many such parents and children in an island, and in every generation one of so
    many is lucky. ``score`` is that of the children.
    """
    parent_scores, score = humble.score.copy(), score.copy()
    for k in np.flatnonzero(humble.score < state.score):
        home = np.flatnonzero(state.island == state.island[k])
        best = taken(state.population, np.array([k]))
        for scores, population in ((parent_scores, state.population), (score, children)):
            alike = home[kin(best, taken(population, home))]
            scores[alike] = np.minimum(scores[alike], humble.score[k])
    return humble._replace(score=parent_scores), score


def kin(one: Population, others: Population) -> Mask:
    """Return True for each individual whose numbers all differ from ``one`` by ``KIN`` at most."""
    similar = np.ones(len(others.tree), bool)
    for (_, reference), (_, each) in zip(flat(one), flat(others), strict=True):
        away = np.abs(each - reference).reshape(len(similar), -1).max(axis=1)
        similar &= away <= KIN * np.abs(reference).max()
    return similar


def chosen_of(state: RaceState, chosen: Integers | Mask) -> RaceState:
    """Return the state with the chosen individuals only; the islands stay as they are."""
    return RaceState(*taken(state[:4], chosen), state.damping)


def ranked(state: RaceState) -> RaceState:
    """Return the state with individuals island by island, the best first."""
    return chosen_of(state, np.lexsort((-state.score, state.island)))


def _sound(settings: RaceSettings, state: RaceState) -> bool:
    each = state.score, state.step, state.island, state.population.tree
    return (
        all(array.shape == (settings.population,) for array in each)
        and np.array_equal(np.unique(state.island), np.arange(len(state.damping)))
        and np.array_equal(np.lexsort((-state.score, state.island)), np.arange(len(state.score)))
        and bool((state.score < np.inf).all())
        and bool(((state.step > 0.0) & (state.step < np.inf)).all())
        and bool((state.damping >= 0.0).all())
    )


STRATEGY = Strategy(
    "race",
    RaceSettings,
    RaceState,
    SuccessiveHalving,
    "successive halving of the structures, with Gauss-Newton steps at the end",
    sound=_sound,
)
