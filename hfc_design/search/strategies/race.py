"""The default strategy: a race of structures with Gauss-Newton steps at its end."""

from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field

from hfc_design.controllers.genome import Population, joined, replaced, taken
from hfc_design.controllers.hierarchical.record import Bounds
from hfc_design.core.numbers import Floats, Integers, Mask
from hfc_design.core.records import NotNegative, Positive
from hfc_design.search.newton import individuals
from hfc_design.search.strategy import Probability, Range, Strategy, StrategySettings, Task

#: A double may score this much of its original before luck is suspected.
LUCK = 0.99
#: Damping of the first Gauss-Newton step, of a failed one, and the one at which to give up.
FIRST_DAMPING, FAILURE, HOPELESS = 1.0, 1e3, 1e6
BOUNDS = Bounds()


class RaceSettings(StrategySettings):
    """A race of structures: every tree is an island, and after each heat half of them remain.

    Some of the first individuals know the machine, if the kind of controller can. Inside an island
    individuals breed; when few islands are left, Gauss-Newton steps from the best of an island
    compete with its children.
    """

    preset: Literal["race"] = "race"
    population: int = Field(840, ge=1, le=10_000_000)
    generations: int = Field(160, ge=1, le=10_000_000)
    kp_range: Range = BOUNDS.kp_range
    kd_range: Range = BOUNDS.kd_range
    scale_range: Annotated[float, Field(ge=1)] = BOUNDS.scale_range
    inner_limit: Annotated[float, Field(gt=0, le=4)] = BOUNDS.inner_limit
    root_limit: Positive = BOUNDS.root_limit
    informed: Probability = 0.5  # share of the first individuals that know the machine
    tournament: int = Field(3, ge=1)
    blend: Probability = 0.5  # share of children that mix two parents
    step: Positive = 0.2  # first mutation step, relative
    stick_penalty: NotNegative = 300.0
    newton_islands: int = Field(8, ge=0)  # Gauss-Newton steps begin with this many islands left
    newton_steps: int = Field(2, ge=0)  # of them in one generation


class RaceState(NamedTuple):
    """Individuals stand island by island, the best of each island first."""

    population: Population
    score: Floats  # (n,)
    step: Floats  # (n,) mutation step, inherited and itself mutated
    island: Integers  # (n,) which island an individual lives on: 0, 1, 2, ...
    damping: Floats  # (islands,) of the next Gauss-Newton step


class Asked(NamedTuple):
    """Candidates, and what ``tell`` has to know about them."""

    population: Population
    step: Floats  # (n,)
    damping: Floats  # (n,) of a Gauss-Newton proposal, nan where it was bred


def heats(trees: int) -> list[int]:
    """Islands in each heat: all trees, then half of them, down to one."""
    sizes = [trees]
    while sizes[-1] > 1:
        sizes.append(-(-sizes[-1] // 2))
    return sizes


class SuccessiveHalving(NamedTuple):
    """Ask and tell of the race; everything that changes is in ``RaceState``."""

    settings: RaceSettings
    task: Task

    def start(self, rng: np.random.Generator) -> tuple[RaceState | None, Asked]:
        """The first individuals: a few on every tree, chosen at random where they are too few."""
        s = self.settings
        trees = self.task.genome.structures
        islands = min(trees, s.population)
        chosen = np.sort(rng.permutation(trees)[:islands])
        tree = chosen[shares(s.population, islands)]
        population = self.task.genome.fresh(tree, rng)
        some = np.flatnonzero(rng.random(len(tree)) < s.informed)
        if len(some) and (informed := self.task.genome.informed(tree[some], rng)) is not None:
            population = replaced(population, some, informed)
        return None, Asked(population, np.full(s.population, s.step), np.full(s.population, np.nan))

    def ask(
        self, state: RaceState, generation: int, rng: np.random.Generator
    ) -> tuple[RaceState, Asked]:
        """Children of every island, some replaced by Gauss-Newton steps from its best."""
        s = self.settings
        state = self._culled(state, generation)
        asked = self._bred(state, rng)
        # The last child of each island becomes a double of its best, a millionth off: a loop that
        # is nearly chaotic may score well by luck; its double then does not.
        best, place = doubled(state)
        double = self.task.genome.nudged(taken(state.population, best), rng)
        asked = asked._replace(population=replaced(asked.population, place, double))
        islands = len(state.damping)
        if self.task.linearised is None or islands > s.newton_islands:
            return state, asked
        hopeful = [k for k in range(islands) if state.damping[k] <= HOPELESS]
        for k in np.roll(hopeful, -generation * s.newton_steps)[: s.newton_steps]:
            asked = self._stepped(state, asked, int(k))
        return state, asked

    def tell(self, state: RaceState | None, asked: Asked, score: Floats) -> RaceState:
        """Parents and children compete inside their island."""
        if state is None:
            island = np.unique(asked.population.tree, return_inverse=True)[1]
            damping = np.full(island.max() + 1, FIRST_DAMPING)
            return ranked(RaceState(asked.population, score, asked.step, island, damping))
        state = humbled(state, score)
        damping = state.damping.copy()
        for k in range(len(damping)):
            home = np.flatnonzero(state.island == k)
            best = home[score[home].argmax()]
            improved = score[best] > state.score[home[0]]
            tried = np.isfinite(asked.damping[home]).any()
            if improved:
                stepped = np.isfinite(asked.damping[best])
                damping[k] = asked.damping[best] if stepped else min(damping[k], FIRST_DAMPING)
            elif tried:
                damping[k] *= FAILURE
        population = joined(state.population, asked.population)
        scores = np.concatenate([state.score, score])
        steps = np.concatenate([state.step, asked.step])
        islands = np.concatenate([state.island, state.island])
        both = ranked(RaceState(population, scores, steps, islands, damping))
        rank = np.arange(len(both.island)) - np.searchsorted(both.island, both.island)
        return chosen_of(both, rank < np.bincount(state.island)[both.island])

    def _culled(self, state: RaceState, generation: int) -> RaceState:
        """Drop the islands that this heat has no room for and fill their places with survivors."""
        sizes = heats(self.task.genome.structures)
        room = sizes[min(generation * len(sizes) // self.settings.generations, len(sizes) - 1)]
        if len(state.damping) <= room:
            return state
        first = np.searchsorted(state.island, np.arange(len(state.damping)))
        kept = np.sort(np.argsort(-state.score[first], kind="stable")[:room])
        island = shares(len(state.island), room)
        rank = np.arange(len(island)) - np.searchsorted(island, island)
        lived = np.bincount(state.island)[kept][island]
        chosen = chosen_of(state, first[kept][island] + rank % lived)
        return ranked(chosen._replace(island=island, damping=state.damping[kept]))

    def _bred(self, state: RaceState, rng: np.random.Generator) -> Asked:
        """One child for every individual, with parents from its island."""
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
        return Asked(genome.mutated(mixed, step, rng), step, np.full(count, np.nan))

    def _stepped(self, state: RaceState, asked: Asked, k: int) -> Asked:
        """The children of island k, half of them replaced by steps from its best."""
        home = np.flatnonzero(state.island == k)
        places = home[: (len(home) + 1) // 2]
        best = taken(state.population, home[:1])
        assert self.task.linearised is not None
        linear = self.task.linearised(best)
        if linear is None:
            return asked._replace(damping=changed(asked.damping, places[:1], HOPELESS))
        at = (best, linear, state.damping[k], len(places))
        steps, tried = individuals(self.task.genome, *at)
        population = replaced(asked.population, places, steps)
        return asked._replace(population=population, damping=changed(asked.damping, places, tried))


def doubled(state: RaceState) -> tuple[Integers, Integers]:
    """The best of each island and the last place there; islands of one or two have none."""
    size = np.bincount(state.island)
    best = np.searchsorted(state.island, np.arange(len(size)))
    large = size > 2
    return best[large], (best + size - 1)[large]


def humbled(state: RaceState, score: Floats) -> RaceState:
    """The best of an island is worth no more than its double."""
    best, place = doubled(state)
    own = state.score[best]
    worse = score[place] < np.where(own < 0.0, own / LUCK, LUCK * own)
    return state._replace(score=changed(state.score, best[worse], score[place][worse]))


def shares(count: int, islands: int) -> Integers:
    """``count`` places dealt to the islands as evenly as possible, island by island."""
    return np.sort(np.arange(count) % islands)


def changed(array: Floats, places: Integers, values: Floats | float) -> Floats:
    """The array with other values at some places."""
    found = array.copy()
    found[places] = values
    return found


def chosen_of(state: RaceState, chosen: Integers | Mask) -> RaceState:
    """The chosen individuals; the islands stay as they are."""
    population, score, step, island, damping = state
    population = taken(population, chosen)
    return RaceState(population, score[chosen], step[chosen], island[chosen], damping)


def ranked(state: RaceState) -> RaceState:
    """Island by island, the best first."""
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
