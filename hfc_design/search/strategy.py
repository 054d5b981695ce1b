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
    #: (individual, indices of numbers; default: all) -> the tracking error near the individual, and
    #: the derivative of the error by these numbers; the result is None if they are not finite. None
    #: if the genome or the machine has no such derivative.
    linearised: Callable[..., Linear | None] | None = None
    #: (individuals, share) -> indices of the nominal machine and of those on which the individuals
    #: violate constraints most; machines on which less than ``share`` of them passes are left out.
    #: None if there is only one machine. Candidates may name ``machines``: those of a front are
    #: simulated on these only; for other candidates, a part of the machines is taken from them.
    hardest: Callable[[Population, float], Integers] | None = None
    #: (trees, generator) -> first individuals on these trees that use knowledge of the machine;
    #: None, or a result of None, if there is no such knowledge.
    informed: Callable[[Integers, np.random.Generator], Population | None] | None = None
    #: individuals -> (n,) violations that are known without a simulation; None: none are known.
    broken: Callable[[Population], Floats] | None = None
    #: individuals -> (n,) their ranks in the first generation; None if ``broken`` is None.
    worth: Callable[[Population], Floats] | None = None


class Scored(NamedTuple):
    """Results of candidates for a strategy that searches a front: costs beside the score."""

    score: Floats  # (n,) rank outside the strategy; -inf if a candidate failed
    costs: Floats  # (n, objectives) lower is better; undefined if a candidate failed
    violation: Floats  # (n,) 0: every constraint is met; infinite: the candidate failed


class Weighed(NamedTuple):
    """Results for a strategy that compares candidates only within a generation.

    Its ``fitness`` may prefer a candidate with more merit to one with a smaller violation.
    """

    score: Floats  # (n,) rank outside the strategy; not finite if a candidate failed
    fitness: Floats | Scored  # what the strategy gets


#: Data of a strategy: its state, and its candidates (a record with a ``population`` and all else
#: that ``tell`` needs).
State: TypeAlias = Any
Asked: TypeAlias = Any


class Searcher(Protocol):
    """A strategy at work: pure functions of its state and of a random generator."""

    def start(self, rng: np.random.Generator) -> tuple[State, Asked]:
        """Return the state before the first generation, and the candidates of that generation."""

    def ask(self, state: State, generation: int, rng: np.random.Generator) -> tuple[State, Asked]:
        """Return state and candidates of a later generation."""

    def tell(self, state: State, candidates: Asked, score: Any) -> State:
        """Return the state after the candidates were scored; a failed one has the score -inf.

        A strategy that searches a front gets ``Scored``, every other strategy scores (n,).
        """


class Strategy(NamedTuple):
    """A search strategy as the rest of the package knows it."""

    name: str  # the ``preset`` of a scenario
    settings: type[StrategySettings]
    #: Type of the state: a NamedTuple of arrays, numbers and such NamedTuples. If it has the fields
    #: ``population`` and ``score``, the best of these individuals become finalists.
    state: type[Any]
    make: Callable[[Any, Task], Searcher]  # (settings, task) -> strategy at work
    summary: str = ""  # for hfc list strategies
    #: (settings, ``[controller]``) -> line on why the strategy cannot search this; None: it can.
    fault: Callable[[Any, Any], str | None] = lambda settings, controller: None
    #: (settings, state) -> True if ``tell`` can return such a state with these settings. The state
    #: comes from a file; its arrays and numbers have the right types.
    sound: Callable[[Any, Any], bool] = lambda settings, state: True
    #: settings -> number of generations, from the first on, whose scores are compared only within
    #: the generation; each of these generations can use other machines.
    forgets: Callable[[Any], int] = lambda settings: 0
    #: settings -> names of the objectives of a front; None: the strategy ranks by a score. With a
    #: front, the state has a field ``front``, a record with a ``population`` and its ``score``.
    trades: Callable[[Any], tuple[str, ...]] | None = None

    def __repr__(self) -> str:
        return f"Strategy({self.name!r})"
