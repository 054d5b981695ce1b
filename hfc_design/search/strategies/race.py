"""The default strategy: a race of structures with Gauss-Newton steps at its end."""

from typing import Any, NamedTuple

import numpy as np

from hfc_design.controllers.genome import Floats, Genome, Integers, Population, joined, replaced
from hfc_design.search.newton import Newton
from hfc_design.search.settings import RaceSettings

#: Damping of the first Gauss-Newton step, of a failed one, and the one at which to give up.
FIRST_DAMPING, FAILURE, HOPELESS = 1.0, 1e3, 1e6
#: A double may score this much of its original before luck is suspected.
LUCK = 0.99


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


class Race(NamedTuple):
    """Ask and tell of the race; everything that changes is in ``RaceState``."""

    settings: RaceSettings
    genome: Genome

    def start(self, rng: np.random.Generator) -> tuple[RaceState | None, Asked]:
        """The first individuals: a few on every tree, chosen at random where they are too few."""
        s = self.settings
        trees = self.genome.structures
        islands = min(trees, s.population)
        chosen = np.sort(rng.permutation(trees)[:islands])
        population = self.genome.fresh(chosen[_shares(s.population, islands)], rng)
        return None, Asked(population, np.full(s.population, s.step), np.full(s.population, np.nan))

    def ask(
        self, state: RaceState, generation: int, newton: Newton | None, rng: np.random.Generator
    ) -> tuple[RaceState, Asked]:
        """Children of every island, some replaced by Gauss-Newton steps from its best."""
        s = self.settings
        state = self._culled(state, generation)
        asked = self._with_doubles(state, self._bred(state, rng), rng)
        islands = len(state.damping)
        if newton is None or islands > s.newton_islands:
            return state, asked
        hopeful = [k for k in range(islands) if state.damping[k] <= HOPELESS]
        for k in np.roll(hopeful, -generation * s.newton_steps)[: s.newton_steps]:
            asked = self._stepped(state, asked, int(k), newton)
        return state, asked

    def tell(self, state: RaceState | None, asked: Asked, score: Floats) -> RaceState:
        """Parents and children compete inside their island."""
        if state is None:
            island = np.unique(asked.population.tree, return_inverse=True)[1]
            damping = np.full(island.max() + 1, FIRST_DAMPING)
            return _ranked(RaceState(asked.population, score, asked.step, island, damping))
        state = _humbled(state, score)
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
        both = _ranked(
            RaceState(
                joined(state.population, asked.population),
                np.concatenate([state.score, score]),
                np.concatenate([state.step, asked.step]),
                np.concatenate([state.island, state.island]),
                damping,
            )
        )
        rank = np.arange(len(both.island)) - np.searchsorted(both.island, both.island)
        return _taken(both, rank < np.bincount(state.island)[both.island])

    def _culled(self, state: RaceState, generation: int) -> RaceState:
        """Drop the islands that this heat has no room for and fill their places with survivors."""
        sizes = heats(self.genome.structures)
        room = sizes[min(generation * len(sizes) // self.settings.generations, len(sizes) - 1)]
        if len(state.damping) <= room:
            return state
        first = np.searchsorted(state.island, np.arange(len(state.damping)))
        kept = np.sort(np.argsort(-state.score[first], kind="stable")[:room])
        island = _shares(len(state.island), room)
        rank = np.arange(len(island)) - np.searchsorted(island, island)
        lived = np.bincount(state.island)[kept][island]
        chosen = _taken(state, first[kept][island] + rank % lived)
        return _ranked(chosen._replace(island=island, damping=state.damping[kept]))

    def _bred(self, state: RaceState, rng: np.random.Generator) -> Asked:
        """One child for every individual, with parents from its island."""
        s, count = self.settings, len(state.island)
        first = np.searchsorted(state.island, state.island)
        size = np.bincount(state.island)[state.island]

        def parent(rounds: int) -> Integers:
            # The best of an island stands first, so the smallest of some draws wins.
            return first + (rng.random((rounds, count)).min(axis=0) * size).astype(np.int64)

        one, other = parent(s.tournament), parent(2)
        share = np.where(rng.random(count) < s.blend, rng.uniform(-0.25, 1.25, count), 0.0)
        mixed = self.genome.blended(state.population.take(one), state.population.take(other), share)
        step = np.clip(state.step[one] * np.exp(0.3 * rng.standard_normal(count)), 1e-3, 1.0)
        return Asked(self.genome.mutated(mixed, step, rng), step, np.full(count, np.nan))

    def _stepped(self, state: RaceState, asked: Asked, k: int, newton: Newton) -> Asked:
        """The children of island k, half of them replaced by steps from its best."""
        home = np.flatnonzero(state.island == k)
        places = home[: (len(home) + 1) // 2]
        found = newton(state.population.take(home[:1]), state.damping[k], len(places))
        if found is None:
            return asked._replace(damping=_set(asked.damping, places[:1], HOPELESS))
        steps, damping = found
        return asked._replace(
            population=replaced(asked.population, places, steps),
            damping=_set(asked.damping, places, damping),
        )

    def _with_doubles(self, state: RaceState, asked: Asked, rng: np.random.Generator) -> Asked:
        """The last child of each island becomes a double of its best, a millionth off.

        A loop that is nearly chaotic may score well by luck; its double then does not.
        """
        best, place = _doubled(state)
        double = self.genome.nudged(state.population.take(best), rng)
        return asked._replace(population=replaced(asked.population, place, double))


def _doubled(state: RaceState) -> tuple[Integers, Integers]:
    """The best of each island and the last place there; islands of one or two have none."""
    size = np.bincount(state.island)
    best = np.searchsorted(state.island, np.arange(len(size)))
    large = size > 2
    return best[large], (best + size - 1)[large]


def _humbled(state: RaceState, score: Floats) -> RaceState:
    """The best of an island is worth no more than its double."""
    best, place = _doubled(state)
    own = state.score[best]
    worse = score[place] < np.where(own < 0.0, own / LUCK, LUCK * own)
    return state._replace(score=_set(state.score, best[worse], score[place][worse]))


def _shares(count: int, islands: int) -> Integers:
    """``count`` places dealt to the islands as evenly as possible, island by island."""
    return np.sort(np.arange(count) % islands)


def _set(array: Any, places: Integers, values: Any) -> Any:
    changed = array.copy()
    changed[places] = values
    return changed


def _taken(state: RaceState, chosen: Any) -> RaceState:
    """The chosen individuals; the islands stay as they are."""
    return RaceState(
        state.population.take(chosen),
        state.score[chosen],
        state.step[chosen],
        state.island[chosen],
        state.damping,
    )


def _ranked(state: RaceState) -> RaceState:
    return _taken(state, np.lexsort((-state.score, state.island)))
