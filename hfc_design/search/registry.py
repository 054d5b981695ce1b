"""Every search strategy by its name: the files in ``strategies``, and what users add."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import SerializeAsAny

from hfc_design.core.plugins import Group, chosen, found_in
from hfc_design.core.records import UserError
from hfc_design.core.shapes import Floats
from hfc_design.search import strategies
from hfc_design.search.strategy import (
    Asked,
    Searcher,
    State,
    Strategy,
    StrategySettings,
    Task,
    strategy_fault,
)

STRATEGIES: Group[Strategy] = Group(
    "strategy",
    Strategy,
    "hfc_design.strategies",
    found_in(strategies, "STRATEGY"),
    fault=strategy_fault,
)
#: The ``[search]`` of a scenario.
SearchSettings = Annotated[
    SerializeAsAny[StrategySettings], chosen(STRATEGIES, "settings", "preset", default="race")
]


def searcher(settings: StrategySettings, task: Task) -> Searcher:
    """The strategy that ``settings`` describe, at work on a task.

    Raises:
        UserError: it is a user's own and lacks something.
    """
    strategy = STRATEGIES.get(settings.preset)
    if strategy.name in STRATEGIES.built_in:
        return strategy.make(settings, task)
    with _own_code(strategy.name):
        found = strategy.make(settings, task)
    for part in ("start", "ask", "tell"):
        if not callable(getattr(found, part, None)):
            raise UserError(f"strategy {strategy.name!r}: what it makes has no {part}")
    return _Own(strategy, found)


class _Own(NamedTuple):
    """A user's own strategy; what it lacks or does wrong becomes a line."""

    strategy: Strategy
    searcher: Searcher

    def start(self, rng: np.random.Generator) -> tuple[State, Asked]:
        with _own_code(self.strategy.name):
            return _with_population(*self.searcher.start(rng))

    def ask(self, state: State, generation: int, rng: np.random.Generator) -> tuple[State, Asked]:
        with _own_code(self.strategy.name):
            return _with_population(*self.searcher.ask(state, generation, rng))

    def tell(self, state: State, asked: Asked, score: Floats) -> State:
        with _own_code(self.strategy.name):
            told = self.searcher.tell(state, asked, score)
            if not isinstance(told, self.strategy.state):
                raise TypeError(f"tell gave no {self.strategy.state.__name__}")
        return told


def _with_population(state: State, asked: Asked) -> tuple[State, Asked]:
    if not hasattr(asked, "population"):
        raise TypeError("what it asks has no population")
    return state, asked


@contextmanager
def _own_code(name: str) -> Iterator[None]:
    try:
        yield
    except UserError:
        raise
    except Exception as error:
        reason = (str(error).splitlines() or [""])[0]
        line = f"strategy {name!r} cannot search: {type(error).__name__}: {reason}"
        raise UserError(line) from error
