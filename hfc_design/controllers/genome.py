"""Genomes: the interface between a search strategy and the individuals that it varies."""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol, TypeAlias, TypeVar

import numpy as np

from hfc_design.controllers.kind import Target
from hfc_design.core.numbers import Floats, Gains, Integers, Json, Mask, Own


class Population(Protocol):
    """n individuals: a NamedTuple of arrays with the individuals in the leading axis."""

    @property
    def tree(self) -> Integers:
        """(n,) structure of each individual, from 0 on."""


AnyPopulation = TypeVar("AnyPopulation", bound=Population)
#: The individuals of a genome's own kind, a ``Population``.
Members: TypeAlias = Any


class Space(NamedTuple):
    """Individuals as points, so that the derivative of a loop gives a direction to move in."""

    vectors: Callable[[Members], Floats]  # population -> (n, parameters), ordered as ``gains`` are
    from_vectors: Callable[[Floats, Members], Members]  # (points, one of their structure) -> they
    frozen: Mask  # (parameters,) those that stay
    low: Floats  # (parameters,)
    high: Floats  # (parameters,)


class Stage(NamedTuple):
    """Coordinates in which a distribution of individuals moves during a part of a search."""

    start: Floats  # (size,) where it begins
    step: float  # first standard deviation of each
    members: Callable[[Floats, Integers], Members]  # points (n, size), structures (n,) -> they


class Genome(Protocol):
    """Individuals of one kind of controller: how they begin, vary and become a controller.

    It is the base of every kind's genome. A genome whose individuals are also points has a method
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
        """Coordinates about the individual with which the previous stage ended; None: the first."""
        raise TypeError(f"{type(self).__name__} has no stages")

    def around(self, about: Members) -> Stage | None:
        """Coordinates of every number about a population of one; None if there are none."""
        return self.stage(len(self.stages) - 1, about) if self.stages else None

    def empty(self) -> Members:
        """One untried individual of each structure."""

    def fresh(self, tree: Integers, rng: np.random.Generator) -> Members:
        """First individuals with the given structures."""

    def informed(self, tree: Integers, rng: np.random.Generator) -> Members | None:
        """First individuals that use knowledge of the machine; None: only ``fresh`` ones exist."""
        return None

    def laws(self) -> Any | None:
        """Laws with few numbers that the individuals can reproduce; None if there are none.

        They are searched before the individuals, see ``hierarchical.laws.LinearLaws``.
        """
        return None

    def mutated(self, population: Members, step: Floats, rng: np.random.Generator) -> Members:
        """Individuals changed by relative steps (n,)."""

    def blended(self, one: Members, other: Members, share: Floats) -> Members:
        """``one`` moved by ``share`` (n,) of the way to ``other``."""

    def nudged(self, population: Members, rng: np.random.Generator) -> Members:
        """Individuals with some numbers changed by about a millionth."""

    def gains(self, population: Members) -> Gains:
        """Gains of the controllers for ``simulate``, with individuals in the trailing axis."""

    def notation(self, structure: int) -> str:
        """Readable text of a structure; the name of the kind if there is only one."""
        return str(self.settings.kind)

    def record(self, individual: Members) -> Json:
        """Controller of a design file, from a population of one."""


def some(rng: np.random.Generator, shape: tuple[int, ...], share: Floats | float) -> Floats:
    """Normal numbers in a ``share`` of all places, 0 elsewhere."""
    return np.asarray((rng.random(shape) < share) * rng.standard_normal(shape))


def taken(population: AnyPopulation, chosen: Integers | Mask | slice) -> AnyPopulation:
    """Individuals chosen by an index array, a mask or a slice."""
    return _mapped(lambda array: array[chosen], population)


def joined(*populations: AnyPopulation) -> AnyPopulation:
    """Join populations one after the other."""
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
