"""Genome of a controller of its own for every axis: that of each, side by side."""

from typing import Any, NamedTuple

import numpy as np

from hfc_design.controllers.controller import Controller, PerAxis
from hfc_design.controllers.genome import Genome, Members, taken
from hfc_design.controllers.kind import Target
from hfc_design.controllers.per_axis.record import PerAxisSettings, kinds
from hfc_design.core.records import UserError
from hfc_design.core.shapes import Floats, Gains, Integers, Json, Mask

#: Structures of all axes together, at most; each is an island of a search.
MOST = 20_000


class SideBySide(NamedTuple):
    """n individuals; every array carries them in its leading axis."""

    tree: Integers  # (n,) the structures of all axes as one number
    axes: tuple[Members, ...]  # the population of each axis

    def take(self, chosen: Integers | Mask | slice) -> "SideBySide":
        """The individuals that an index array, a mask or a slice chooses."""
        return taken(self, chosen)


class PerAxisGenome(NamedTuple):
    """What a search can do with ``SideBySide``."""

    names: tuple[str, ...]
    axes: tuple[Genome, ...]

    @property
    def controller(self) -> Controller:
        """The law of each axis."""
        controllers: list[Any] = [genome.controller for genome in self.axes]
        laws = tuple(law for controller in controllers for law in controller.laws)
        return PerAxis("per-axis", laws, own_gains=True)

    @property
    def structures(self) -> int:
        """Every combination of those of the axes."""
        return int(np.prod([genome.structures for genome in self.axes]))

    def _trees(self, tree: Integers) -> tuple[Integers, ...]:
        """The structure of each axis, (n,)."""
        return np.unravel_index(tree, [genome.structures for genome in self.axes])

    def _each(self, tree: Integers, what: str, *arguments: Any) -> SideBySide:
        """``what`` every axis' genome makes of its share of the arguments."""
        parts = zip(self.axes, *arguments, strict=True)
        return SideBySide(tree, tuple(getattr(genome, what)(*own) for genome, *own in parts))

    def _all(self, value: Any) -> tuple[Any, ...]:
        return (value,) * len(self.axes)

    def empty(self) -> SideBySide:
        """One individual of each combination."""
        tree = np.arange(self.structures)
        pairs = zip(self.axes, self._trees(tree), strict=True)
        return SideBySide(tree, tuple(genome.empty().take(own) for genome, own in pairs))

    def fresh(self, tree: Integers, rng: np.random.Generator) -> SideBySide:
        """First individuals with the given structures."""
        return self._each(tree, "fresh", self._trees(tree), self._all(rng))

    def mutated(self, population: SideBySide, step: Floats, rng: np.random.Generator) -> SideBySide:
        """The individuals changed by relative steps (n,)."""
        steps = self._all(step)
        return self._each(population.tree, "mutated", population.axes, steps, self._all(rng))

    def blended(self, one: SideBySide, other: SideBySide, share: Floats) -> SideBySide:
        """``one`` moved by ``share`` (n,) of the way to ``other``."""
        return self._each(one.tree, "blended", one.axes, other.axes, self._all(share))

    def nudged(self, population: SideBySide, rng: np.random.Generator) -> SideBySide:
        """Every axis with a number a millionth off."""
        return self._each(population.tree, "nudged", population.axes, self._all(rng))

    def gains(self, population: SideBySide) -> tuple[Gains, ...]:
        """The gains of each axis."""
        pairs = zip(self.axes, population.axes, strict=True)
        return tuple(genome.gains(own) for genome, own in pairs)

    def notation(self, structure: int) -> str:
        """The structure of each axis."""
        trees = (int(own[0]) for own in self._trees(np.array([structure])))
        each = zip(self.names, self.axes, trees, strict=True)
        return ", ".join(f"{name}: {genome.notation(own)}" for name, genome, own in each)

    def record(self, individual: SideBySide) -> Json:
        """The record of each axis."""
        each = zip(self.names, self.axes, individual.axes, strict=True)
        return {
            "kind": "per-axis",
            "axes": {name: genome.record(own) for name, genome, own in each},
        }


def genome_of(settings: PerAxisSettings, target: Target) -> PerAxisGenome:
    """The genomes of the axes' kinds.

    Raises:
        UserError: together they have too many structures.
    """
    parts = []
    for k, own in enumerate(settings.axes.values()):
        parts.append(kinds().get(own.kind).genome(own, target.of(k)))
    genome = PerAxisGenome(tuple(settings.axes), tuple(parts))
    if genome.structures > MOST:
        raise UserError(
            f"controller.axes: have {genome.structures} structures together; allowed are {MOST}: "
            "give fewer inputs"
        )
    return genome
