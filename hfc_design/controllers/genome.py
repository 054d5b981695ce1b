"""Genomes: the interface between a search strategy and the individuals that it varies."""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol, TypeAlias, TypeVar

import numpy as np

from hfc_design.controllers.kind import Target
from hfc_design.core.numbers import Floats, Gains, Integers, Json, Mask, Own


class Population(Protocol):
    """n individuals: a NamedTuple of arrays whose first dimension counts the individuals."""

    @property
    def tree(self) -> Integers:
        """(n,) number of the structure of each individual, from 0 on."""


#: A population, another record whose arrays count the individuals in their first dimension, or
#: such an array.
AnyPopulation = TypeVar("AnyPopulation")
#: A ``Population`` with the arrays that a genome of a certain kind uses.
Members: TypeAlias = Any


class Space(NamedTuple):
    """Individuals as points; derivatives of a loop by the parameters tell how to move a point."""

    vectors: Callable[[Members], Floats]  # population -> points (n, parameters) ordered as gains
    from_vectors: Callable[[Floats, Members], Members]  # (points, one of their tree) -> population
    frozen: Mask  # (parameters,) true for a parameter that must not change
    low: Floats  # (parameters,) lower bounds
    high: Floats  # (parameters,) upper bounds


class Stage(NamedTuple):
    """Coordinates in which a distribution of individuals moves during a part of a search."""

    start: Floats  # (size,) first mean of the distribution
    step: float  # first standard deviation of each coordinate
    members: Callable[[Floats, Integers], Members]  # (points (n, size), trees (n,)) -> population


class Genome(Protocol):
    """Operations of a search on individuals of a kind: it makes, varies and converts them.

    It is the base of every kind's genome. A genome that supports Gauss-Newton steps has a method
    ``space() -> Space``; a genome for strategies that move a distribution has ``stages``.
    """

    settings: Own  # the ``ControllerSettings`` of the kind
    target: Target
    structures: int = 1  # number of structures

    def __init__(self, settings: Own, target: Target):
        self.settings, self.target = settings, target

    #: For each stage: its share of a search, and True if the structures compete in it.
    stages: tuple[tuple[float, bool], ...] = ()

    def stage(self, number: int, about: Members | None) -> Stage:
        """Return a stage around ``about``, result of the previous stage; None: the first stage."""
        raise TypeError(f"{type(self).__name__} has no stages")

    def around(self, about: Members) -> Stage | None:
        """Return the last stage around ``about``, a population of one; None without stages."""
        return self.stage(len(self.stages) - 1, about) if self.stages else None

    def empty(self) -> Members:
        """Return a population with one individual of each structure."""

    def fresh(self, tree: Integers, rng: np.random.Generator) -> Members:
        """Return first individuals, drawn at random, with the given structures (n,)."""

    def informed(self, tree: Integers, rng: np.random.Generator) -> Members | None:
        """Return first individuals made from a model of the machine; None: use ``fresh`` ones."""
        return None

    def laws(self) -> Any | None:
        """Return the genome of simpler laws that individuals can reproduce; None if there are none.

        A search finds good laws first; see ``hierarchical.seed_laws.SeedLaws``.
        """
        return None

    def mutated(self, population: Members, step: Floats, rng: np.random.Generator) -> Members:
        """Return the individuals with random changes; ``step`` (n,) is their relative size."""

    def blended(self, one: Members, other: Members, share: Floats) -> Members:
        """Return the individuals ``one``, moved by ``share`` (n,) of the way to ``other``."""

    def nudged(self, population: Members, rng: np.random.Generator) -> Members:
        """Return the individuals with some numbers changed by about a millionth."""

    def gains(self, population: Members) -> Gains:
        """Return gains for the simulator: arrays whose last dimension counts the individuals."""

    def notation(self, structure: int) -> str:
        """Return a structure as readable text; the name of the kind if it has only one."""
        return str(self.settings.kind)

    def record(self, individual: Members) -> Json:
        """Return the controller of a population of one, as in a design file."""


def some(rng: np.random.Generator, shape: tuple[int, ...], share: Floats | float) -> Floats:
    """Return normal random numbers of a shape; each is kept with probability ``share``, else 0."""
    return np.asarray((rng.random(shape) < share) * rng.standard_normal(shape))


def taken(population: AnyPopulation, chosen: int | Integers | Mask | slice) -> AnyPopulation:
    """Return the individuals chosen by an index array, a mask or a slice; of an index the one."""
    return _mapped(lambda array: array[chosen], population)


def joined(*populations: AnyPopulation) -> AnyPopulation:
    """Return one population with the individuals of several, one population after the other."""
    return _mapped(lambda *parts: np.concatenate(parts), *populations)


def replaced(population: AnyPopulation, places: int | Integers, by: Any) -> AnyPopulation:
    """Return a population with the individuals at the indices ``places`` replaced ``by`` others."""

    def changed(array: Any, values: Any) -> Any:
        array = array.copy()
        array[places] = values
        return array

    return _mapped(changed, population, by)


def _mapped(function: Callable[..., Any], *trees: Any) -> Any:
    """Return nested tuples like ``trees``, with ``function`` of their corresponding arrays."""
    first = trees[0]
    if not isinstance(first, tuple):
        return function(*trees)
    parts = [_mapped(function, *children) for children in zip(*trees, strict=True)]
    return type(first)(*parts) if hasattr(first, "_fields") else tuple(parts)
