"""Genome of a controller whose gains are a few numbers."""

from typing import Any, NamedTuple

import numpy as np

from hfc_design.controllers.gains import GainsSettings, Range
from hfc_design.controllers.genome import Genome, Stage, some, taken
from hfc_design.controllers.kind import Target, kinds
from hfc_design.core.numbers import Floats, Gains, Integers, Json

#: Initial standard deviation of a distribution, as a share of each range.
STEP = 0.08


class GainVectors(NamedTuple):
    """n individuals; the first dimension of every array counts the individuals."""

    tree: Integers  # (n,) all 0, because there is only one structure
    places: Floats  # (n, gains) place of each gain in its range, from 0 (low) to 1 (high)


class Searched(NamedTuple):
    """Searched number: its range, its initial value, and the scale of the range."""

    low: float
    high: float
    start: float
    bend: float | None = None  # curvature of a sinh scale; None: log scale if low > 0, else linear

    def value(self, place: Floats) -> Floats:
        """Return the value at a place in the range, from 0 to 1."""
        if self.bend is not None:
            return self.high * np.sinh(self.bend * (2.0 * place - 1.0)) / np.sinh(self.bend)
        return _between((self.low, self.high), place)

    def place(self, value: Any) -> Floats:
        """Return the place of a value in the range, from 0 to 1: the inverse of ``value``."""
        if self.bend is not None:
            share = np.arcsinh(value / self.high * np.sinh(self.bend)) / self.bend
            return np.clip(0.5 * (share + 1.0), 0.0, 1.0)
        inside = np.clip(value, self.low, self.high)
        if self.low == self.high:
            return np.zeros_like(inside)
        if self.low > 0.0:
            return np.asarray(np.log(inside / self.low) / np.log(self.high / self.low))
        return np.asarray((inside - self.low) / (self.high - self.low))


class GainsGenome(Genome):
    """Operations of a search on ``GainVectors``."""

    #: In a subclass: the searched numbers, by name, in the order of the first places.
    searched: dict[str, Searched]

    def __init__(self, settings: GainsSettings, target: Target):
        super().__init__(settings, target)
        self.ranges = settings.searched()

    def empty(self) -> GainVectors:
        """Return one individual in the middle of all ranges."""
        return GainVectors(np.zeros(1, int), np.full((1, len(self.ranges)), 0.5))

    def fresh(self, tree: Integers, rng: np.random.Generator) -> GainVectors:
        """Return individuals with random gains, uniform on the scales of the ranges."""
        return GainVectors(tree, rng.random((len(tree), len(self.ranges))))

    def mutated(
        self, population: GainVectors, step: Floats, rng: np.random.Generator
    ) -> GainVectors:
        """Return the individuals with about 70 % of the gains moved at random, by ``step`` (n,)."""
        places = population.places
        return _allowed(population, places + 0.5 * step[:, None] * some(rng, places.shape, 0.7))

    def blended(self, one: GainVectors, other: GainVectors, share: Floats) -> GainVectors:
        """Return ``one`` with its places moved by ``share`` (n,) of the way to ``other``."""
        return _allowed(one, one.places + share[:, None] * (other.places - one.places))

    def nudged(self, population: GainVectors, rng: np.random.Generator) -> GainVectors:
        """Return the individuals with gains changed by about a millionth of their ranges."""
        off = 1e-6 * rng.standard_normal(population.places.shape)
        return _allowed(population, population.places + off)

    stages = ((1.0, False),)

    def stage(self, number: int, about: GainVectors | None) -> Stage:
        """Return a stage of all places; it starts at ``about``, or at ``empty`` if that is None."""
        first = taken(self.empty(), slice(1)) if about is None else about

        def members(points: Floats, tree: Integers) -> GainVectors:
            return GainVectors(tree, np.clip(points, 0.0, 1.0))

        return Stage(first.places[0], STEP, members)

    def values(self, population: GainVectors) -> dict[str, Floats]:
        """Return the numbers in ``searched``, each (n,)."""
        pairs = zip(self.searched.items(), population.places.T, strict=False)
        return {name: one.value(place) for (name, one), place in pairs}

    def gains(self, population: GainVectors) -> Gains:
        """Return the gains as the kind's NamedTuple, each (n,)."""
        pairs = zip(self.ranges, population.places.T, strict=True)
        return type(self.ranges)(*(_between(pair, place) for pair, place in pairs))

    def record(self, individual: GainVectors) -> Json:
        """Return the record of a population of one, without the sample time."""
        gains = self.gains(individual)._asdict()
        kind = self.settings.kind
        gains_record = kinds().get(kind).of_gains({name: float(x[0]) for name, x in gains.items()})
        return {"kind": kind, **gains_record}


def _allowed(population: GainVectors, places: Floats) -> GainVectors:
    return population._replace(places=np.clip(places, 0.0, 1.0))


def _between(pair: Range, place: Floats) -> Floats:
    """Return the gain at a place in its range, on a logarithmic scale if the range is above 0."""
    low, high = pair
    if low > 0.0:
        return np.asarray(low * (high / low) ** place)
    return low + place * (high - low)
