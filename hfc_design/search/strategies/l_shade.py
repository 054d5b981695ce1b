"""L-SHADE: differential evolution of one structure's numbers, with ever fewer individuals.

It needs no derivative, so it suits controllers that switch and machines of several axes.
"""

from typing import Literal, NamedTuple

import numpy as np
from pydantic import Field

from hfc_design.controllers.genome import Population, replaced, taken
from hfc_design.controllers.hierarchical.record import Bounds
from hfc_design.core.checkpoint import flat
from hfc_design.core.numbers import Floats
from hfc_design.core.records import NotNegative, Ordered, Positive
from hfc_design.search.coordinates import Coordinates, coordinates
from hfc_design.search.differential import ARCHIVE, Points, Trials, begun, learnt, tried
from hfc_design.search.strategy import Strategy, StrategySettings, Task


class LShadeSettings(Ordered, Bounds, StrategySettings):
    """Settings of L-SHADE around the best first individual; all later ones have its structure."""

    keys_last = Bounds.model_fields
    preset: Literal["l-shade"] = "l-shade"
    population: int = Field(80, ge=4, le=100_000)
    last: int = Field(4, ge=4, le=100_000)  # individuals of the last generation
    generations: int = Field(380, ge=1, le=10_000_000)
    step: Positive = 6.0  # factor on the first standard deviations [1]
    stick_penalty: NotNegative = 0.0  # ranked by fitness / (1 + this times the stick share) [1]


class LShadeState(NamedTuple):
    """Individuals as points around the best first one; after one generation only this one."""

    population: Population  # (n,)
    score: Floats  # (n,)
    about: Population  # (1,) where all coordinates are 0
    points: Points


class Asked(NamedTuple):
    """A trial for every individual."""

    population: Population
    trials: Trials  # without factors in the first two generations
    needed: Floats | None  # (n,) score of the individual that each trial has to beat


class LShade(NamedTuple):
    """The strategy; everything that changes is in ``LShadeState``."""

    settings: LShadeSettings
    task: Task

    def start(self, rng: np.random.Generator) -> tuple[None, Asked]:
        """Return first individuals, evenly distributed over the structures."""
        genome, count = self.task.genome, self.settings.population
        tree = np.sort(rng.permutation(genome.structures)[np.arange(count) % genome.structures])
        population = genome.fresh(tree, rng)
        known = (self.task.informed or genome.informed)(tree[::2], rng)
        if known is not None:
            population = replaced(population, np.arange(0, count, 2), known)
        return None, Asked(population, _trials(np.empty((count, 0))), None)

    def ask(
        self, state: LShadeState, generation: int, rng: np.random.Generator
    ) -> tuple[LShadeState, Asked]:
        """Return random points around the best first individual; later, trials of ever fewer."""
        chart = self._coordinates(state.about)
        if not len(state.points.places):
            cloud = rng.standard_normal((self.settings.population, chart.size))
            cloud[0] = 0.0
            trials = _trials(np.clip(self.settings.step * chart.step * cloud, *chart.room))
            return state, Asked(chart.members(trials.places), trials, None)
        survivors = np.sort(np.argsort(-state.score, kind="stable")[: self._room(generation)])
        every = state.population, state.score, state.points.places
        population, score, places = taken(every, survivors)
        points = state.points._replace(places=places)
        state = state._replace(population=population, score=score, points=points)
        trials = tried(state.points, state.score, chart.room, rng)
        return state, Asked(chart.members(trials.places), trials, state.score)

    def tell(self, state: LShadeState | None, candidates: Asked, score: Floats) -> LShadeState:
        """Return the state in which a trial replaces its individual if the trial is no worse."""
        population, trials, _ = candidates
        if state is None:
            best = np.array([int(np.argmax(score))])
            about = taken(population, best)
            nowhere = begun(np.empty((0, self._coordinates(about).size)))
            return LShadeState(about, score[best], about, nowhere)
        if not len(state.points.places):
            return LShadeState(population, score, state.about, begun(trials.places))
        with np.errstate(invalid="ignore"):  # if both failed
            gained = np.nan_to_num(score - state.score, nan=0.0, posinf=np.inf, neginf=-np.inf)
        won = np.flatnonzero(gained >= 0.0)
        return LShadeState(
            replaced(state.population, won, taken(population, won)),
            np.where(gained >= 0.0, score, state.score),
            state.about,
            learnt(state.points, trials, gained),
        )

    def _coordinates(self, about: Population) -> Coordinates:
        chart = coordinates(self.task.genome, about)
        if chart is None:
            raise TypeError("the genome has no coordinates: implement around(about), or use race")
        return chart

    def _room(self, generation: int) -> int:
        """Return the number of individuals of a generation, from ``population`` to ``last``."""
        s = self.settings
        share = (generation - 1) / max(s.generations - 2, 1)
        return max(round(s.population + (s.last - s.population) * share), 4)


def _trials(places: Floats) -> Trials:
    return Trials(places, np.empty((2, 0)))


def _sound(settings: LShadeSettings, state: LShadeState) -> bool:
    places, beaten, memory, turn = state.points
    count = len(state.score)
    finite = all(np.isfinite(numbers).all() for _, numbers in flat((state.points, state.about)))
    return (
        finite
        and all(len(numbers) == 1 for _, numbers in flat(state.about))
        and len(beaten) == (int(ARCHIVE * settings.population) if len(places) else 0)
        and bool(((memory >= 0.0) & (memory <= 1.0)).all())
        and 0 < count <= settings.population
        and state.population.tree.shape == state.score.shape
        and state.about.tree.shape == (1,)
        and len(places) in (0, count)
        and places.shape[1:] == beaten.shape[1:]
        and memory.shape == begun(places).memory.shape
        and turn.shape == (1,)
        and turn[0] in range(memory.shape[1])
        and bool((state.score < np.inf).all())
    )


STRATEGY = Strategy(
    "l-shade",
    LShadeSettings,
    LShadeState,
    LShade,
    "differential evolution of all numbers (L-SHADE), for controllers without a derivative",
    sound=_sound,
)
