"""What a search strategy needs to know of what it varies."""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol, TypeAlias, TypeVar

import numpy as np

from hfc_design.controllers.kind import Target
from hfc_design.core.numbers import Floats, Gains, Integers, Json, Mask, Own


class Population(Protocol):
    """n individuals: a NamedTuple of arrays that carry them in the leading axis."""

    @property
    def tree(self) -> Integers:
        """(n,) structure of each individual, from 0 on."""


AnyPopulation = TypeVar("AnyPopulation", bound=Population)
#: The individuals of a genome's own kind, a ``Population``.
Members: TypeAlias = Any


class Space(NamedTuple):
    """Individuals as points, so that the derivative of a loop tells where to go from one."""

    vectors: Callable[[Members], Floats]  # population -> (n, parameters), ordered as ``gains`` are
    from_vectors: Callable[[Floats, Members], Members]  # (points, one of their structure) -> they
    frozen: Mask  # (parameters,) those that stay
    low: Floats  # (parameters,)
    high: Floats  # (parameters,)


class Stage(NamedTuple):
    """Coordinates in which a distribution of individuals moves for a part of a search."""

    start: Floats  # (size,) where it begins
    step: float  # first standard deviation of each
    members: Callable[[Floats, Integers], Members]  # points (n, size), structures (n,) -> they


class Genome(Protocol):
    """Individuals of one kind of controller: how they begin, vary and become a controller.

    The base of every kind's genome. One whose individuals are points too says so by a method
    ``space() -> Space``; one through which a distribution can be led has ``stages``.
    """

    settings: Own  # the ``ControllerSettings`` of the kind
    target: Target
    structures: int = 1  # how many there are

    def __init__(self, settings: Own, target: Target):
        self.settings, self.target = settings, target

    #: Share of a search for each of its stages, and whether structures compete in it.
    stages: tuple[tuple[float, bool], ...] = ()

    def stage(self, number: int, about: Members | None) -> Stage:
        """Coordinates about the individual that the stage before ended with; None: the first."""
        raise TypeError(f"{type(self).__name__} has no stages")

    def around(self, about: Members) -> Stage | None:
        """Coordinates of every number about a population of one; None where there are none."""
        return self.stage(len(self.stages) - 1, about) if self.stages else None

    def empty(self) -> Members:
        """One individual of each structure that nobody has tried."""

    def fresh(self, tree: Integers, rng: np.random.Generator) -> Members:
        """First individuals with the given structures."""

    def informed(self, tree: Integers, rng: np.random.Generator) -> Members | None:
        """The same of what is known of the machine; None where ``fresh`` is all there is."""
        return None

    def laws(self) -> Any | None:
        """Laws of few numbers that the individuals can follow; None: there are none.

        They are searched before the individuals are, see ``hierarchical.laws.LinearLaws``.
        """
        return None

    def mutated(self, population: Members, step: Floats, rng: np.random.Generator) -> Members:
        """The individuals changed by relative steps (n,)."""

    def blended(self, one: Members, other: Members, share: Floats) -> Members:
        """``one`` moved by ``share`` (n,) of the way to ``other``."""

    def nudged(self, population: Members, rng: np.random.Generator) -> Members:
        """The individuals with a number a millionth off."""

    def gains(self, population: Members) -> Gains:
        """The controllers' gains as ``simulate`` wants them, individuals in the trailing axis."""

    def notation(self, structure: int) -> str:
        """A structure as people read it; of a single one the name of the kind."""
        return str(self.settings.kind)

    def record(self, individual: Members) -> Json:
        """A population of one as the controller of a design file."""


def some(rng: np.random.Generator, shape: tuple[int, ...], share: Floats | float) -> Floats:
    """Normal numbers in a ``share`` of all places, 0 elsewhere."""
    return np.asarray((rng.random(shape) < share) * rng.standard_normal(shape))


def taken(population: AnyPopulation, chosen: Integers | Mask | slice) -> AnyPopulation:
    """The individuals that an index array, a mask or a slice chooses."""
    return _mapped(lambda array: array[chosen], population)


def joined(*populations: AnyPopulation) -> AnyPopulation:
    """Populations one after the other."""
    return _mapped(lambda *parts: np.concatenate(parts), *populations)


def replaced(population: AnyPopulation, places: Integers, by: AnyPopulation) -> AnyPopulation:
    """The population with other individuals at some places."""

    def changed(array: Any, values: Any) -> Any:
        array = array.copy()
        array[places] = values
        return array

    return _mapped(changed, population, by)


def _mapped(function: Callable[..., Any], *trees: Any) -> Any:
    """``function`` of the arrays that stand at the same place in tuples of tuples."""
    first = trees[0]
    if not isinstance(first, tuple):
        return function(*trees)
    parts = [_mapped(function, *children) for children in zip(*trees, strict=True)]
    return type(first)(*parts) if hasattr(first, "_fields") else tuple(parts)
