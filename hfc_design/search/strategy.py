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

    ``stick_penalty`` is the weight of sticking in the judge's divisor, 0 if a strategy has no such
    key. The keys of ``controllers.hierarchical.record.Bounds`` bound the varied numbers of a
    hierarchy.
    """

    preset: str  # which search strategy
    population: int = Field(100, ge=1, le=10_000_000)  # individuals per generation
    generations: int = Field(100, ge=1, le=10_000_000)  # number of generations


class Task(NamedTuple):
    """Task of a strategy: the genome to search, and functions that help."""

    genome: Genome
    #: The tracking error about one individual and its derivative, by all of its numbers or by some
    #: that are named behind it; gives None where they are not finite. None where the genome or the
    #: machine has no such derivative.
    linearised: Callable[..., Linear | None] | None = None
    #: The numbers of the machines on which individuals break constraints most, the nominal one
    #: among them, without those on which less than a share of the individuals passes; of
    #: (individuals, share). None where there is but one machine. What a strategy asks may have
    #: ``machines``: one that trades meets these and no others, in others a share is of them.
    hardest: Callable[[Population, float], Integers] | None = None
    #: First individuals on the given trees that know the machine, of (trees, generator); None, or
    #: giving None, where nothing is known.
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


#: What only its strategy knows: what it remembers, and what it asks, a record with a
#: ``population`` and whatever ``tell`` has to know of it.
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
    #: NamedTuple of arrays, numbers and such records, as ``tell`` gives it. What it calls
    #: ``population`` is one; with a ``score`` beside it, its best are looked at in the end.
    state: type[Any]
    make: Callable[[Any, Task], Searcher]  # of settings and task
    summary: str = ""  # for hfc list strategies
    #: Why it cannot search, in a line: of its settings and of the ``[controller]``.
    fault: Callable[[Any, Any], str | None] = lambda settings, controller: None
    #: Whether a state from a file, whose arrays and numbers are of their types, can be one that
    #: ``tell`` gave with these settings.
    sound: Callable[[Any, Any], bool] = lambda settings, state: True
    #: In how many of its first generations, of its settings, scores are compared within each only;
    #: then each may have machines of its own.
    forgets: Callable[[Any], int] = lambda settings: 0
    #: Names of the objectives that it trades off, of its settings; None: it ranks by a score. The
    #: state then has a ``front``, a record with a ``population`` and its ``score``.
    trades: Callable[[Any], tuple[str, ...]] | None = None

    def __repr__(self) -> str:
        return f"Strategy({self.name!r})"
