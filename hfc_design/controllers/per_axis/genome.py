"""Genome of a controller of its own for every axis: that of each, side by side."""

import math
from typing import Any, NamedTuple

import numpy as np

from hfc_design.controllers.genome import Genome, Members, taken
from hfc_design.controllers.kind import Target, kinds
from hfc_design.controllers.per_axis import PerAxisSettings
from hfc_design.core.numbers import Floats, Gains, Integers, Json
from hfc_design.core.records import UserError

#: Structures of all axes together, at most; each is an island of a search.
MOST = 20_000


class SideBySide(NamedTuple):
    """n individuals; every array carries them in its leading axis."""

    tree: Integers  # (n,) the structures of all axes as one number
    axes: tuple[Members, ...]  # the population of each axis


class PerAxisGenome(Genome):
    """What a search can do with ``SideBySide``.

    Raises:
        UserError: the axes have too many structures together.
    """

    def __init__(self, settings: PerAxisSettings, target: Target):
        super().__init__(settings, target)
        own = enumerate(settings.axes.values())
        #: The genome of each axis' kind.
        self.axes = [kinds().get(one.kind).genome(one, target.of(k)) for k, one in own]
        self.counts = [genome.structures for genome in self.axes]
        self.structures = math.prod(self.counts)  # every combination
        if self.structures > MOST:
            raise UserError(
                f"controller.axes: have {self.structures} structures together; allowed are "
                f"{MOST}: give fewer inputs"
            )

    def _trees(self, tree: Integers) -> tuple[Integers, ...]:
        """The structure of each axis, (n,)."""
        return np.unravel_index(tree, self.counts)

    def _each(self, what: str, *parts: Any, shared: tuple[Any, ...] = ()) -> tuple[Any, ...]:
        """What the method ``what`` of every axis' genome makes of its parts and what all share."""
        each = zip(self.axes, *parts, strict=True)
        return tuple(getattr(genome, what)(*own, *shared) for genome, *own in each)

    def empty(self) -> SideBySide:
        """One individual of each combination."""
        tree = np.arange(self.structures)
        return SideBySide(tree, tuple(map(taken, self._each("empty"), self._trees(tree))))

    def fresh(self, tree: Integers, rng: np.random.Generator) -> SideBySide:
        """First individuals with the given structures."""
        return SideBySide(tree, self._each("fresh", self._trees(tree), shared=(rng,)))

    def mutated(self, population: SideBySide, step: Floats, rng: np.random.Generator) -> SideBySide:
        """The individuals changed by relative steps (n,)."""
        found = self._each("mutated", population.axes, shared=(step, rng))
        return population._replace(axes=found)

    def blended(self, one: SideBySide, other: SideBySide, share: Floats) -> SideBySide:
        """``one`` moved by ``share`` (n,) of the way to ``other``."""
        return one._replace(axes=self._each("blended", one.axes, other.axes, shared=(share,)))

    def nudged(self, population: SideBySide, rng: np.random.Generator) -> SideBySide:
        """Every axis with a number a millionth off."""
        return population._replace(axes=self._each("nudged", population.axes, shared=(rng,)))

    def gains(self, population: SideBySide) -> tuple[Gains, ...]:
        """The gains of each axis."""
        return self._each("gains", population.axes)

    def notation(self, structure: int) -> str:
        """The structure of each axis."""
        trees = map(int, np.unravel_index(structure, self.counts))
        each = zip(self.settings.axes, self._each("notation", trees), strict=True)
        return ", ".join(f"{axis}: {own}" for axis, own in each)

    def record(self, individual: SideBySide) -> Json:
        """The record of each axis."""
        each = zip(self.settings.axes, self._each("record", individual.axes), strict=True)
        return {"kind": "per-axis", "axes": dict(each)}
