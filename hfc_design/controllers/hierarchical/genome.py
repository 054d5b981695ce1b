"""Genome of PD plus a fuzzy hierarchy: structure, consequents, input scales, PD gains."""

from typing import NamedTuple

import numpy as np

from hfc_design.controllers.genome import Genome, Space, some, taken
from hfc_design.controllers.hierarchical import tree as hierarchy
from hfc_design.controllers.hierarchical.law import HierarchicalGains
from hfc_design.controllers.hierarchical.record import HierarchicalSettings, bounds_of
from hfc_design.controllers.hierarchical.seed_laws import SeedLaws
from hfc_design.controllers.kind import Target
from hfc_design.core.numbers import Floats, Integers, Json
from hfc_design.core.records import UserError


class Hierarchies(NamedTuple):
    """Population of n individuals; the first axis of every array counts the individuals."""

    tree: Integers  # (n,) index into ``HierarchicalGenome.trees``
    gains: Floats  # (n, 2): kp [V/rad], kd [V s/rad]
    scales: Floats  # (n, inputs) factors k_1, k_2, ... on the inputs [1/input]
    consequents: Floats  # (n, units, 7, 7), [unit][row term][column term]


class HierarchicalGenome(Genome):
    """Operations of a search on ``Hierarchies``."""

    def __init__(self, settings: HierarchicalSettings, target: Target):
        super().__init__(settings, target)
        self.bounds = bounds_of(target.bounds)
        self.names = [item.name for item in settings.inputs]
        #: Scales in the settings; those of random first individuals are drawn around them.
        self.scales = [item.scale for item in settings.inputs]
        self.trees = hierarchy.trees(len(self.names), settings.used)
        self.sources = hierarchy.all_sources(len(self.names), settings.used)
        self.structures, self.units = self.sources.shape[:2]
        self.centres = np.array([term.centre for term in settings.terms])
        #: Largest absolute consequent of each unit (units, 1, 1); the root comes last.
        self.limit = np.full((self.units, 1, 1), self.bounds.inner_limit)
        self.limit[-1] = self.bounds.root_limit

    def empty(self) -> Hierarchies:
        """Return one individual for each tree, in their order; its gains and tables are 0."""
        inputs, trees = len(self.names), self.structures
        return Hierarchies(
            np.arange(trees),
            np.zeros((trees, 2)),
            np.ones((trees, inputs)),
            np.zeros((trees, self.units, 7, 7)),
        )

    def fresh(self, tree: Integers, rng: np.random.Generator) -> Hierarchies:
        """Return individuals with tilted planes as tables: nearly linear, so rarely unstable."""
        s = self.bounds
        count, inputs = len(tree), len(self.names)
        limit, centres = self.limit, self.centres
        level, column, row = rng.uniform(-1, 1, (3, count, self.units, 1, 1))
        plane = 0.5 * level + 0.7 * column * centres + 0.7 * row * centres[:, None]
        noise = 0.05 * rng.standard_normal((count, self.units, *(2 * centres.shape)))
        low, high = np.log([s.kp_range, s.kd_range]).T
        spread = np.log(s.scale_range) * rng.uniform(-1, 1, (count, inputs))
        return Hierarchies(
            tree,
            np.exp(rng.uniform(low, high, (count, 2))),
            np.array(self.scales) * np.exp(spread),
            np.clip(limit * plane + noise, -limit, limit),
        )

    def laws(self) -> SeedLaws | None:
        """Return simple laws; None if the nominal drive is not linearised or has no regulator."""
        try:
            return SeedLaws(self)
        except UserError:
            return None

    def informed(self, tree: Integers, rng: np.random.Generator) -> Hierarchies | None:
        """Return individuals that approximate random simple laws; None if ``laws`` returns None."""
        laws = self.laws()
        if laws is None:
            return None
        spread = np.log(self.bounds.scale_range) * rng.uniform(-1, 1, (len(tree), len(self.names)))
        sizes = np.exp(spread) / np.array(self.scales)
        return laws.laid(laws.ways(laws.fresh(len(tree), rng), rng), tree, sizes)

    def mutated(
        self, population: Hierarchies, step: Floats, rng: np.random.Generator
    ) -> Hierarchies:
        """Move single consequents, tilt and shift whole tables, change gains and scales."""
        count, units = population.consequents.shape[:2]
        limit, centres = self.limit, self.centres
        cells = population.consequents.shape[1:]
        each = np.exp(rng.uniform(-np.log(np.prod(cells)), 0.0, (count, 1, 1, 1)))
        moved = some(rng, (count, *cells), each)
        table = np.sqrt(limit) * some(rng, (3, count, units, 1, 1), 0.1)
        moved = moved + table[0] + table[1] * centres + table[2] * centres[:, None]
        step = step[:, None]
        scales = population.scales
        if self.bounds.scale_range > 1.0:
            scales = scales * np.exp(0.5 * step * some(rng, scales.shape, 0.2))
        gains = population.gains * np.exp(0.5 * step * some(rng, population.gains.shape, 0.5))
        tables = population.consequents + step[:, :, None, None] * moved
        return Hierarchies(population.tree, gains, scales, np.clip(tables, -limit, limit))

    def blended(self, one: Hierarchies, other: Hierarchies, share: Floats) -> Hierarchies:
        """Interpolate the logarithms of gains and scales, and the consequents themselves."""
        line = share[:, None]
        table = share[:, None, None, None]
        return Hierarchies(
            one.tree,
            one.gains * (other.gains / one.gains) ** line,
            one.scales * (other.scales / one.scales) ** line,
            one.consequents + table * (other.consequents - one.consequents),
        )

    def nudged(self, population: Hierarchies, rng: np.random.Generator) -> Hierarchies:
        """Change PD gains by about a millionth."""
        off = 1.0 + 1e-6 * rng.standard_normal(population.gains.shape)
        return population._replace(gains=population.gains * off)

    def gains(self, population: Hierarchies) -> HierarchicalGains:
        """Return the gains of the population for ``simulate``."""
        sources = self.sources[population.tree]
        return HierarchicalGains(
            kp=population.gains[:, 0],
            kd=population.gains[:, 1],
            scales=population.scales.T,
            sources=np.moveaxis(sources, 0, -1),
            consequents=np.moveaxis(population.consequents, 0, -1),
        )

    def space(self) -> Space:
        """Return the space in which individuals are the points that ``vectors`` returns."""
        _, *arrays = taken(self.empty(), slice(1))

        def point(*values: Floats | float) -> Floats:
            """Return a point (parameters,) with these gains, scales and consequents."""
            pairs = zip(arrays, values, strict=True)
            return np.concatenate([np.broadcast_to(x, a.shape).ravel() for a, x in pairs])

        fixed = point(0.0, self.bounds.scale_range == 1.0, 0.0) > 0.0
        low, high = point(1.0, 1e-6, -self.limit), point(np.inf, np.inf, self.limit)
        return Space(vectors, from_vectors, fixed, low, high)

    def record(self, individual: Hierarchies) -> Json:
        """Return the record of kind ``pd+hierarchical-fuzzy``, without the sample time."""
        tree = self.trees[int(individual.tree[0])]
        sources = self.names + [f"unit-{unit.heap_id}" for unit in tree]
        kp, kd = individual.gains[0].tolist()
        scales = zip(self.names, individual.scales[0].tolist(), strict=True)
        known = self.sources[individual.tree]
        read = {name for k, name in enumerate(self.names) if (known == k).any()}
        return self.settings.model_dump(exclude={"schedules", "used"}) | {
            "pd": {"kp": kp, "kd": kd},
            "inputs": [{"name": name, "scale": x} for name, x in scales if name in read],
            "units": [
                {
                    "id": unit.heap_id,
                    "column_input": sources[unit.column],
                    "row_input": sources[unit.row],
                    "consequents": table.tolist(),
                }
                for unit, table in zip(tree, individual.consequents[0], strict=True)
            ],
        }

    def notation(self, structure: int) -> str:
        """Return the text of a tree: nested pairs (column input, row input)."""
        return hierarchy.notation(self.names, (unit[1:] for unit in self.trees[structure]))


def vectors(population: Hierarchies) -> Floats:
    """Return individuals as points (n, parameters): gains, scales and consequents of each."""
    count = len(population.tree)
    return np.concatenate([array.reshape(count, -1) for array in population[1:]], axis=1)


def from_vectors(parameters: Floats, like: Hierarchies) -> Hierarchies:
    """Return individuals from points (n, parameters), all with the tree of ``like``."""
    count = len(parameters)
    ends = np.cumsum([array[0].size for array in like[1:]])
    parts = zip(np.split(parameters, ends[:-1], axis=1), like[1:], strict=True)
    arrays = (part.reshape(count, *array.shape[1:]) for part, array in parts)
    return Hierarchies(np.repeat(like.tree[:1], count), *arrays)
