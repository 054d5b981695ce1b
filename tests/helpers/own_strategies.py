"""A module with two search strategies of one's own, and some that lack something."""

import pytest

#: So small that a whole search takes no time.
SIZES = {"simulation.duration_s": 0.1, "search.population": 12, "search.generations": 5}

MODULE = '''
from typing import Any, NamedTuple
import numpy as np
import hfc_design.api as hfc

class Asked(NamedTuple):
    population: Any

class Drawn(NamedTuple):
    """All that random search remembers; it has no population of its own."""
    draws: int
    luck: float
    seen: np.ndarray

class Random(NamedTuple):
    settings: hfc.StrategySettings
    task: hfc.Task

    def start(self, rng):
        return Drawn(0, 0.0, np.empty(0)), self.fresh(rng)

    def ask(self, state, generation, rng):
        return state, self.fresh(rng)

    def tell(self, state, asked, score):
        seen = np.append(state.seen, score.max())
        return Drawn(state.draws + len(score), float(seen.max()), seen)

    def fresh(self, rng):
        genome, count = self.task.genome, self.settings.population
        return Asked(genome.fresh(rng.integers(genome.structures, size=count), rng))

class Best(NamedTuple):
    population: Any
    score: np.ndarray
    step: float

class ClimbSettings(hfc.StrategySettings):
    step: float = 0.3
    stick_penalty: float = 5.0

class Climb(NamedTuple):
    settings: ClimbSettings
    task: hfc.Task

    def start(self, rng):
        genome, count = self.task.genome, self.settings.population
        return None, Asked(genome.fresh(rng.integers(genome.structures, size=count), rng))

    def ask(self, state, generation, rng):
        count = self.settings.population
        copies = hfc.taken(state.population, np.zeros(count, int))
        return state, Asked(self.task.genome.mutated(copies, np.full(count, state.step), rng))

    def tell(self, state, asked, score):
        best = np.array([score.argmax()])
        if state is not None and state.score[0] >= score[best[0]]:
            return state._replace(step=0.8 * state.step)
        return Best(hfc.taken(asked.population, best), score[best], self.settings.step)

RANDOM = hfc.Strategy("random", hfc.StrategySettings, Drawn, Random)
CLIMB = hfc.Strategy("climb", ClimbSettings, Best, Climb, "a hill climber")

TAKEN = CLIMB._replace(name="race")
NO_SETTINGS = CLIMB._replace(settings=dict)
NO_STATE = CLIMB._replace(state=dict)
NO_MAKE = CLIMB._replace(make=None)

class Mute(NamedTuple):
    settings: Any
    task: Any
    def start(self, rng):
        return None, Asked(self.task.genome.empty())
    def ask(self, state, generation, rng):
        return state, Asked(self.task.genome.empty())

class Nothing(Climb):
    def start(self, rng):
        return None, "nobody"

class Foreign(Climb):
    def tell(self, state, asked, score):
        return {"best": score.max()}

class Broken(Climb):
    def ask(self, state, generation, rng):
        return 1 / 0

MUTE = CLIMB._replace(make=Mute)
NOTHING = CLIMB._replace(make=Nothing)
FOREIGN = CLIMB._replace(make=Foreign)
BROKEN = CLIMB._replace(make=Broken)
PICKY = CLIMB._replace(fault=lambda settings, controller: f"searches no {controller.kind}")
'''


@pytest.fixture
def searching(own):
    """The current folder, with a module of strategies that nobody has imported."""
    (own / "hunt.py").write_text(MODULE)
    return own
