"""Genome of a controller that consists of other controllers: their genomes side by side."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from hfc_design.controllers.genome import Genome, Members, Stage, taken
from hfc_design.controllers.kind import Target, kinds
from hfc_design.core.numbers import Floats, Gains, Integers, Own
from hfc_design.core.records import UserError

#: Type of ``Genome.stages``.
Stages: TypeAlias = tuple[tuple[float, bool], ...]
#: Largest number of combinations of structures; each combination is an island of a search.
MOST = 20_000


class ProductPopulation(NamedTuple):
    """n individuals; the first dimension of every array counts the individuals."""

    tree: Integers  # (n,) number of the combination of structures of all parts
    parts: tuple[Members, ...]  # the population of each part


class ProductGenome(Genome):
    """Operations of a search on ``ProductPopulation``; the genome of each kind adds ``record``.

    Raises:
        UserError: the structures of the parts have too many combinations.
    """

    def __init__(self, settings: Own, target: Target, parts: Sequence[Any], key: str):
        super().__init__(settings, target)
        #: The genome of each part.
        self.parts = parts
        self.counts = [genome.structures for genome in parts]
        self.stages = _together([genome.stages for genome in parts])
        self.structures = math.prod(self.counts)  # number of combinations
        if self.structures > MOST:
            most = f"at most {MOST} structures together (got {self.structures})"
            raise UserError(f"controller.{key}: must have {most}; give fewer inputs")

    def stage(self, number: int, about: ProductPopulation | None) -> Stage:
        """Return a stage with the coordinates of all parts in a row, all with the smallest step."""
        before = about.parts if about is not None else (None,) * len(self.parts)
        numbers = [min(number, len(genome.stages) - 1) for genome in self.parts]
        each = self.each("stage", numbers, before)
        step = min(stage.step for stage in each)
        wider = np.concatenate([np.full(len(stage.start), stage.step / step) for stage in each])
        ends = np.cumsum([len(stage.start) for stage in each])[:-1]

        def members(points: Floats, tree: Integers) -> ProductPopulation:
            parts = np.split(wider * points, ends, axis=1)
            rows = zip(each, parts, self.trees(tree), strict=True)
            return ProductPopulation(tree, tuple(one.members(*at) for one, *at in rows))

        return Stage(np.concatenate([stage.start for stage in each]) / wider, step, members)

    def trees(self, tree: Integers) -> tuple[Integers, ...]:
        """Return for each part its structures (n,) in the combinations ``tree`` (n,)."""
        return np.unravel_index(tree, self.counts)

    def each(self, what: str, *parts: Any, shared: tuple[Any, ...] = ()) -> tuple[Any, ...]:
        """Call the method ``what`` of every part with its element of ``parts``, then ``shared``."""
        every = zip(self.parts, *parts, strict=True)
        return tuple(getattr(genome, what)(*args, *shared) for genome, *args in every)

    def empty(self) -> ProductPopulation:
        """Return one individual of each combination of structures."""
        tree = np.arange(self.structures)
        return ProductPopulation(tree, tuple(map(taken, self.each("empty"), self.trees(tree))))

    def fresh(self, tree: Integers, rng: np.random.Generator) -> ProductPopulation:
        """Return first individuals with the given combinations of structures (n,)."""
        return ProductPopulation(tree, self.each("fresh", self.trees(tree), shared=(rng,)))

    def mutated(
        self, population: ProductPopulation, step: Floats, rng: np.random.Generator
    ) -> ProductPopulation:
        """Return the individuals with random changes; ``step`` (n,) is their relative size."""
        parts = self.each("mutated", population.parts, shared=(step, rng))
        return population._replace(parts=parts)

    def blended(
        self, one: ProductPopulation, other: ProductPopulation, share: Floats
    ) -> ProductPopulation:
        """Return the individuals ``one``, moved by ``share`` (n,) of the way to ``other``."""
        return one._replace(parts=self.each("blended", one.parts, other.parts, shared=(share,)))

    def nudged(self, population: ProductPopulation, rng: np.random.Generator) -> ProductPopulation:
        """Return the individuals with some numbers of each part changed by about a millionth."""
        return population._replace(parts=self.each("nudged", population.parts, shared=(rng,)))

    def gains(self, population: ProductPopulation) -> Gains:
        """Return the gains of each part."""
        return self.each("gains", population.parts)


def _together(each: Sequence[Stages]) -> Stages:
    """Return as many stages as the part with most stages has; () if any part has none.

    Parts with fewer stages repeat their last one. Structures compete if those of any part do.
    """
    if not all(each):
        return ()
    longest = max(each, key=len)
    now = [[stages[min(k, len(stages) - 1)] for stages in each] for k in range(len(longest))]
    shares = (share for share, _ in longest)
    return tuple((x, any(compete for _, compete in y)) for x, y in zip(shares, now, strict=True))


class WrapperGenome(ProductGenome):
    """Genome of a controller around inner ones: their genome, and that of its own gains."""

    def __init__(self, settings: Any, target: Target, outer: Genome):
        inner = kinds().get(settings.inner.kind).genome(settings.inner, target)
        super().__init__(settings, target, [inner, outer], "inner")

    def notation(self, structure: int) -> str:
        """Return the notation of the structure of the inner controller."""
        return str(self.parts[0].notation(structure))
