"""Genome of a controller that consists of others: their genomes side by side."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from hfc_design.controllers.genome import Genome, Members, Stage, taken
from hfc_design.controllers.kind import Target, kinds
from hfc_design.core.numbers import Floats, Gains, Integers, Own
from hfc_design.core.records import UserError

#: ``Genome.stages``.
Stages: TypeAlias = tuple[tuple[float, bool], ...]
#: Structures of all parts together, at most; each is an island of a search.
MOST = 20_000


class ProductPopulation(NamedTuple):
    """n individuals; every array carries them in its leading axis."""

    tree: Integers  # (n,) the structures of all parts as one number
    parts: tuple[Members, ...]  # the population of each part


class ProductGenome(Genome):
    """Operations of a search on ``ProductPopulation``; each kind adds the controller that it makes.

    Raises:
        UserError: the parts have too many structures together.
    """

    def __init__(self, settings: Own, target: Target, parts: Sequence[Any], key: str):
        super().__init__(settings, target)
        #: The genome of each part.
        self.parts = parts
        self.counts = [genome.structures for genome in parts]
        self.stages = _together([genome.stages for genome in parts])
        self.structures = math.prod(self.counts)  # every combination
        if self.structures > MOST:
            raise UserError(
                f"controller.{key}: must have at most {MOST} structures together (got "
                f"{self.structures}); give fewer inputs"
            )

    def stage(self, number: int, about: ProductPopulation | None) -> Stage:
        """Coordinates of every part in its stage, in a row, scaled to the smallest of steps."""
        parts = about.parts if about is not None else (None,) * len(self.parts)
        numbers = [min(number, len(genome.stages) - 1) for genome in self.parts]
        each = self.each("stage", numbers, parts)
        step = min(stage.step for stage in each)
        wider = np.concatenate([np.full(len(stage.start), stage.step / step) for stage in each])
        ends = np.cumsum([len(stage.start) for stage in each])[:-1]

        def members(points: Floats, tree: Integers) -> ProductPopulation:
            part_points = zip(
                each, np.split(wider * points, ends, axis=1), self.trees(tree), strict=True
            )
            return ProductPopulation(tree, tuple(one.members(*at) for one, *at in part_points))

        return Stage(np.concatenate([stage.start for stage in each]) / wider, step, members)

    def trees(self, tree: Integers) -> tuple[Integers, ...]:
        """The structure of each part, (n,)."""
        return np.unravel_index(tree, self.counts)

    def each(self, what: str, *parts: Any, shared: tuple[Any, ...] = ()) -> tuple[Any, ...]:
        """Call the method ``what`` of every part's genome with own and shared arguments."""
        every = zip(self.parts, *parts, strict=True)
        return tuple(getattr(genome, what)(*args, *shared) for genome, *args in every)

    def empty(self) -> ProductPopulation:
        """One individual of each combination."""
        tree = np.arange(self.structures)
        return ProductPopulation(tree, tuple(map(taken, self.each("empty"), self.trees(tree))))

    def fresh(self, tree: Integers, rng: np.random.Generator) -> ProductPopulation:
        """First individuals with the given structures."""
        return ProductPopulation(tree, self.each("fresh", self.trees(tree), shared=(rng,)))

    def mutated(
        self, population: ProductPopulation, step: Floats, rng: np.random.Generator
    ) -> ProductPopulation:
        """The individuals changed by relative steps (n,)."""
        parts = self.each("mutated", population.parts, shared=(step, rng))
        return population._replace(parts=parts)

    def blended(
        self, one: ProductPopulation, other: ProductPopulation, share: Floats
    ) -> ProductPopulation:
        """``one`` moved by ``share`` (n,) of the way to ``other``."""
        return one._replace(parts=self.each("blended", one.parts, other.parts, shared=(share,)))

    def nudged(self, population: ProductPopulation, rng: np.random.Generator) -> ProductPopulation:
        """The individuals with some numbers of each part changed by about a millionth."""
        return population._replace(parts=self.each("nudged", population.parts, shared=(rng,)))

    def gains(self, population: ProductPopulation) -> Gains:
        """The gains of each part."""
        return self.each("gains", population.parts)


def _together(each: Sequence[Stages]) -> Stages:
    """The stages of the part that has the most, none where a part has none.

    Others stay in their last one; structures compete where those of any part do.
    """
    if not all(each):
        return ()
    longest = max(each, key=len)
    now = [[stages[min(k, len(stages) - 1)] for stages in each] for k in range(len(longest))]
    shares = (share for share, _ in longest)
    return tuple((x, any(compete for _, compete in y)) for x, y in zip(shares, now, strict=True))


class WrapperGenome(ProductGenome):
    """Genome of a controller around others: its parts are ``inner``, and numbers of its own."""

    def __init__(self, settings: Any, target: Target, outer: Genome):
        inner = kinds().get(settings.inner.kind).genome(settings.inner, target)
        super().__init__(settings, target, [inner, outer], "inner")

    def notation(self, structure: int) -> str:
        """Notation of the controller inside."""
        return str(self.parts[0].notation(structure))
