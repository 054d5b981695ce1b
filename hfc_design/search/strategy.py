"""Search strategies, and the task that they are given."""

from collections.abc import Callable
from typing import Annotated, Any, NamedTuple, Protocol, TypeAlias

import numpy as np
from pydantic import Field

from hfc_design.controllers.genome import Genome, Population
from hfc_design.core.numbers import Floats, Integers
from hfc_design.core.records import Record
from hfc_design.search.newton import Linear

Probability = Annotated[float, Field(ge=0, le=1)]


class StrategySettings(Record):
    """The ``[search]`` of a scenario; each strategy adds keys of its own.

    ``stick_penalty`` is the weight of sticking in the merit, 0 if a strategy has no such key. The
    keys of ``controllers.hierarchical.record.Bounds`` limit the varied numbers of a hierarchy.
    """

    preset: str  # which search strategy
    population: int = Field(100, ge=1, le=10_000_000)  # individuals per generation
    generations: int = Field(100, ge=1, le=10_000_000)  # number of generations


class Task(NamedTuple):
    """Task of a strategy: the genome to search, and functions that help."""

    genome: Genome
    #: The tracking error near one individual and its derivative with respect to all of its numbers,
    #: or to those named in a second argument; returns None where they are not finite. None if the
    #: genome or the machine has no such derivative.
    linearised: Callable[..., Linear | None] | None = None
    #: (individuals, share) -> numbers of the machines on which the individuals violate constraints
    #: most, with the nominal one, without those on which less than this share of the individuals
    #: passes. None if there is only one machine. A strategy may ask for ``machines``: if it trades,
    #: candidates are simulated on these only, otherwise a part of the machines is taken from them.
    hardest: Callable[[Population, float], Integers] | None = None
    #: (trees, generator) -> first individuals on these trees that use knowledge of the machine;
    #: None, or a result of None, if there is no such knowledge.
    informed: Callable[[Integers, np.random.Generator], Population | None] | None = None
    #: (n,) by how much individuals break what is known without a simulation; None: nothing is.
    broken: Callable[[Population], Floats] | None = None
    #: (n,) what they are worth in the first generation; None with ``broken``.
    worth: Callable[[Population], Floats] | None = None


class Scored(NamedTuple):
    """Results of candidates for a strategy that searches a front, instead of a score alone."""

    score: Floats  # (n,) what they are ranked by elsewhere; -inf of one that failed
    costs: Floats  # (n, objectives) the less, the better; means nothing where one failed
    violation: Floats  # (n,) 0: every constraint is kept; else by how much, infinite: it failed


class Weighed(NamedTuple):
    """Results for a strategy that compares only within a generation, and the values to show.

    It may prefer a candidate with more merit that breaks a little more.
    """

    score: Floats  # (n,) what they are ranked by elsewhere; no finite number where one failed
    fitness: Floats | Scored


#: Data of a strategy: its state, and its candidates, a record with a ``population`` and everything
#: that ``tell`` needs about it.
State: TypeAlias = Any
Asked: TypeAlias = Any


class Searcher(Protocol):
    """A strategy at work: pure functions of its state and of a random generator."""

    def start(self, rng: np.random.Generator) -> tuple[State, Asked]:
        """State before the first generation, and its candidates."""

    def ask(self, state: State, generation: int, rng: np.random.Generator) -> tuple[State, Asked]:
        """State and candidates of a later generation."""

    def tell(self, state: State, candidates: Asked, score: Any) -> State:
        """State after the candidates have been scored; -inf is the score of one that failed.

        A strategy that searches a front gets ``Scored``, others their scores (n,).
        """


class Strategy(NamedTuple):
    """A search strategy as the rest of the package knows it."""

    name: str  # the ``preset`` of a scenario
    settings: type[StrategySettings]
    #: NamedTuple of arrays, numbers and such records, as ``tell`` returns it. ``population`` in it
    #: holds individuals; if ``score`` is beside it, the best of them are finalists.
    state: type[Any]
    make: Callable[[Any, Task], Searcher]  # of settings and task
    summary: str = ""  # for hfc list strategies
    #: Why it cannot search, in a line: of its settings and of the ``[controller]``.
    fault: Callable[[Any, Any], str | None] = lambda settings, controller: None
    #: Whether a state from a file, whose arrays and numbers are of their types, can be one that
    #: ``tell`` gave with these settings.
    sound: Callable[[Any, Any], bool] = lambda settings, state: True
    #: settings -> number of first generations whose scores are compared within a generation only;
    #: each of them can have other machines.
    forgets: Callable[[Any], int] = lambda settings: 0
    #: settings -> names of the objectives that it trades off; None: it ranks by a score. If it
    #: trades, the state has a ``front``, a record with a ``population`` and its ``score``.
    trades: Callable[[Any], tuple[str, ...]] | None = None

    def __repr__(self) -> str:
        return f"Strategy({self.name!r})"
