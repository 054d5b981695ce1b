"""Genome of a control law whose gains are a few numbers."""

from typing import Any, NamedTuple

import numpy as np

from hfc_design.controllers.gains.law import PD, PID, Law, Range
from hfc_design.controllers.genome import Floats, Integers, Mask, taken
from hfc_design.controllers.hierarchical.genome import some
from hfc_design.controllers.kinds import Controller, of_law


class GainVectors(NamedTuple):
    """n individuals; every array carries them in its leading axis."""

    tree: Integers  # (n,) 0: there is one structure
    places: Floats  # (n, gains) of each gain in its range, 0 to 1

    def take(self, chosen: Integers | Mask | slice) -> "GainVectors":
        """The individuals that an index array, a mask or a slice chooses."""
        return taken(self, chosen)


class GainsGenome(NamedTuple):
    """What a search can do with ``GainVectors``."""

    law: Law
    sample_time: float  # [s]

    @property
    def controller(self) -> Controller:
        """The law."""
        return of_law(self.law, self.sample_time)

    @property
    def structures(self) -> int:
        """One."""
        return 1

    def empty(self) -> GainVectors:
        """One individual in the middle of all ranges."""
        return GainVectors(np.zeros(1, int), np.full((1, len(self.law.ranges)), 0.5))

    def fresh(self, tree: Integers, rng: np.random.Generator) -> GainVectors:
        """Anywhere in the ranges."""
        return GainVectors(tree, rng.random((len(tree), len(self.law.ranges))))

    def mutated(
        self, population: GainVectors, step: Floats, rng: np.random.Generator
    ) -> GainVectors:
        """Move some of the gains."""
        places = population.places
        return _allowed(population, places + 0.5 * step[:, None] * some(rng, places.shape, 0.7))

    def blended(self, one: GainVectors, other: GainVectors, share: Floats) -> GainVectors:
        """On a straight line between the places."""
        return _allowed(one, one.places + share[:, None] * (other.places - one.places))

    def nudged(self, population: GainVectors, rng: np.random.Generator) -> GainVectors:
        """Other gains by a millionth of their ranges."""
        off = 1e-6 * rng.standard_normal(population.places.shape)
        return _allowed(population, population.places + off)

    def gains(self, population: GainVectors) -> Any:
        """The law's record of gains, each (n,)."""
        ranges = self.law.ranges
        pairs = zip(ranges, population.places.T, strict=True)
        return type(ranges)(*(_between(pair, place) for pair, place in pairs))

    def record(self, individual: GainVectors) -> dict[str, Any]:
        """The law's kind and gains, without its sample time."""
        own = "gains" if self.law.name not in (PD.name, PID.name) else self.law.name
        found = self.gains(individual)._asdict()
        return {"kind": self.law.name, own: {name: float(x[0]) for name, x in found.items()}}


def _allowed(population: GainVectors, places: Floats) -> GainVectors:
    return population._replace(places=np.clip(places, 0.0, 1.0))


def _between(pair: Range, place: Floats) -> Floats:
    """The gain at a place of its range: by its logarithm where the range is above zero."""
    low, high = pair
    if low > 0.0:
        return np.asarray(low * (high / low) ** place)
    return low + place * (high - low)
