"""Genome of a fuzzy hierarchy that blends two linear laws; a search has three stages.

The first stage varies the weights of two optimal regulators, and the share of the second law in
each term of one input of the tree. The second varies gains and shares, the third everything.
"""

from typing import Any, NamedTuple

import numpy as np

from hfc_design.controllers.gains.genome import STEP
from hfc_design.controllers.genome import Genome, Stage
from hfc_design.controllers.hierarchical.genome import HierarchicalGenome
from hfc_design.controllers.hierarchical.law import HierarchicalGains
from hfc_design.controllers.hierarchical.linear_genome import (
    EVERYTHING,
    FAR,
    FREE,
    LinearHierarchies,
    LinearHierarchyGenome,
)
from hfc_design.controllers.hierarchical.linear_tables import passthrough
from hfc_design.controllers.hierarchical.record import HierarchicalSettings
from hfc_design.controllers.kind import Target
from hfc_design.core.numbers import Floats, Integers, Json

#: First shares of the second law in the middle term of a tree's first input and the next three.
SHARES = np.array([1.0, 0.0, 0.0, 1.0])
#: Keys of a linear law whose values both laws have.
SAME = ("coulomb_width", "width", "expected_load", "frequency_rad_s")


class ScheduledHierarchies(NamedTuple):
    """Population of n individuals; the first axis of every array counts the individuals."""

    tree: Integers  # (n,)
    first: LinearHierarchies  # hierarchy, and the law where the root's scaled output is 0
    second: Floats  # (n, 2 + ...) kp, kd and ``linear`` of the law where that output is 1


class ScheduledGenome(Genome):
    """Operations of a search on ``ScheduledHierarchies``."""

    stages = ((0.12, True), (0.35, False), (0.5, False))

    def __init__(self, settings: HierarchicalSettings, target: Target):
        super().__init__(settings, target)
        self.on_one = LinearHierarchyGenome(settings, target)
        self.structures = self.on_one.structures
        self.leading = self.on_one.fuzzy.sources.min(axis=(1, 2))  # (trees,) first inputs
        self.passing = passthrough(settings)

    def empty(self) -> ScheduledHierarchies:
        """Return one individual for each tree, in their order; both laws are the same regulator."""
        return _alike(self.on_one.empty())

    def fresh(self, tree: Integers, rng: np.random.Generator) -> ScheduledHierarchies:
        """Return individuals with two equal laws."""
        return _alike(self.on_one.fresh(tree, rng))

    def mutated(
        self, population: ScheduledHierarchies, step: Floats, rng: np.random.Generator
    ) -> ScheduledHierarchies:
        """Mutate both laws and the hierarchy."""
        factors = np.exp(0.25 * step[:, None] * rng.standard_normal(population.second.shape))
        first = self.on_one.mutated(population.first, step, rng)
        return population._replace(first=first, second=population.second * factors)

    def blended(
        self, one: ScheduledHierarchies, other: ScheduledHierarchies, share: Floats
    ) -> ScheduledHierarchies:
        """Interpolate gains linearly, the rest as ``LinearHierarchyGenome``."""
        second = one.second + share[:, None] * (other.second - one.second)
        first = self.on_one.blended(one.first, other.first, share)
        return ScheduledHierarchies(one.tree, first, second)

    def nudged(
        self, population: ScheduledHierarchies, rng: np.random.Generator
    ) -> ScheduledHierarchies:
        """Change kp and kd of the first law by about a millionth."""
        return population._replace(first=self.on_one.nudged(population.first, rng))

    def gains(self, population: ScheduledHierarchies) -> HierarchicalGains:
        """Return the gains for ``simulate``; the root multiplies the second law less the first."""
        population = self._even(population)
        first, other = self.on_one.gains(population.first), self.on_one.gains(_second(population))
        assert first.linear is not None
        assert other.linear is not None
        difference = _change(other.linear._asdict(), first.linear._asdict()) | {"filters": ()}
        return first._replace(scheduled=type(first.linear)(**difference))

    def record(self, individual: ScheduledHierarchies) -> Json:
        """Return the record; its law ``scheduled`` is the second law less the first."""
        individual = self._even(individual)
        near, far = self.on_one.record(individual.first), self.on_one.record(_second(individual))
        one, other = (x["linear"] | x["pd"] for x in (near, far))
        return near | {"scheduled": _change(other, one)}

    def _even(self, population: ScheduledHierarchies) -> ScheduledHierarchies:
        """Return the population with even tables: the same output if all inputs change sign."""
        fuzzy, inputs = population.first.fuzzy, len(self.on_one.fuzzy.names)
        tables, places = fuzzy.consequents.copy(), np.arange(49).reshape(7, 7)
        for tree in np.unique(fuzzy.tree):
            members = np.flatnonzero(fuzzy.tree == tree)
            for k, unit in enumerate(self.on_one.fuzzy.trees[tree]):  # outputs of units are even
                turned = tuple(way for way, x in enumerate((unit.row, unit.column)) if x < inputs)
                half = np.minimum(places, np.flip(places, turned))
                tables[members, k] = tables[members, k].reshape(-1, 49)[:, half]
        first = population.first._replace(fuzzy=fuzzy._replace(consequents=tables))
        return population._replace(first=first)

    def notation(self, structure: int) -> str:
        """Return the text of the hierarchy's tree: nested pairs (column input, row input)."""
        return self.on_one.notation(structure)

    def stage(self, number: int, about: ScheduledHierarchies | None) -> Stage:
        """Return stage 0 (weights, shares), 1 (gains, shares) or 2 (gains, scales and tables)."""
        if number == 0 or about is None:
            return self._regulators()
        around, size = about, 2 + about.first.linear.shape[1]
        if number == 1:
            before = self._shares(around.first)

            def two(points: Floats, tree: Integers) -> ScheduledHierarchies:
                first = self.on_one.moved(around.first, tree, points, None)
                second = _scaled(around.second, points[:, size : 2 * size])
                shares = before + points[:, 2 * size : 2 * size + len(SHARES)]
                return ScheduledHierarchies(tree, self._sharing(first, shares, points), second)

            return Stage(np.zeros(2 * size + len(SHARES) + 1), FREE, two)

        def all_of_it(points: Floats, tree: Integers) -> ScheduledHierarchies:
            first = self.on_one.moved(around.first, tree, points, points[:, 2 * size :])
            second = _scaled(around.second, points[:, size : 2 * size])
            return ScheduledHierarchies(tree, first, second)

        fuzzy = around.first.fuzzy
        further = fuzzy.scales[0].size + fuzzy.consequents[0].size
        return Stage(np.zeros(2 * size + further), EVERYTHING, all_of_it)

    def _regulators(self) -> Stage:
        """Return stage 0: its points are the weights of two regulators, the shares and a scale."""
        places = self.on_one.regulator.empty().places[0]
        size = len(places)

        def members(points: Floats, tree: Integers) -> ScheduledHierarchies:
            one, other = points[:, :size], points[:, size : 2 * size]
            both = self.on_one.regulated(one, tree), self.on_one.regulated(other, tree)
            # The second law, at rest, gets the larger ki; with it a slow axis would stick and slip.
            more = both[0].linear[:, :1] > both[1].linear[:, :1]
            first = self.on_one.regulated(np.where(more, other, one), tree)
            second = self.on_one.regulated(np.where(more, one, other), tree)
            shares = SHARES + points[:, 2 * size : 2 * size + len(SHARES)]
            shared = self._sharing(first, shares, points)
            return ScheduledHierarchies(tree, shared, _law(second))

        return Stage(np.concatenate([places, places, np.zeros(len(SHARES) + 1)]), STEP, members)

    def _shares(self, first: LinearHierarchies) -> Floats:
        """Return the shares (4,) of the second law in the tables of the first individual."""
        units, way = self.on_one.fuzzy.trees[first.tree[0]], self.leading[first.tree[0]]
        k = next(k for k, unit in enumerate(units) if way in (unit.column, unit.row))
        table = first.fuzzy.consequents[0, k]
        known = table[0] if units[k].column == way else table[:, 0]
        return np.asarray(known[3:] * self.settings.output_scale)

    def _sharing(
        self, first: LinearHierarchies, shares: Floats, points: Floats
    ) -> LinearHierarchies:
        """Return individuals whose tables give ``shares`` (n, 4) by the first input alone."""
        fuzzy = first.fuzzy
        both = shares[:, [3, 2, 1, 0, 1, 2, 3]] / self.settings.output_scale
        tables = np.stack([self._tables(int(t), x) for t, x in zip(first.tree, both, strict=True)])
        scales = fuzzy.scales.copy()
        each = np.arange(len(scales)), self.leading[first.tree]
        scales[each] *= np.exp(np.clip(points[:, -1], -FAR, FAR))
        return first._replace(fuzzy=fuzzy._replace(scales=scales, consequents=tables))

    def _tables(self, tree: int, shares: Floats) -> Floats:
        """Return the tables (units, 7, 7) of a tree: the reader of its first input has ``shares``.

        The units from there to the root pass them on; all others give the mean of their inputs.
        """
        tables, inputs, first = [], len(self.on_one.fuzzy.names), self.leading[tree]
        way = first
        for k, unit in enumerate(self.on_one.fuzzy.trees[tree]):
            known = shares if way == first else self.passing
            if unit.column == way:
                table = np.tile(known, (7, 1))
            elif unit.row == way:
                table = np.tile(known[:, None], (1, 7))
            else:
                tables.append(0.5 * self.passing + 0.5 * self.passing[:, None])
                continue
            tables.append(table)
            way = inputs + k
        return np.stack(tables)


def _change(far: Any, near: Any) -> Any:
    """Return the numbers of ``far`` less those of ``near``, except those of the keys ``SAME``."""
    if isinstance(near, dict):
        return {k: x if k in SAME else _change(far[k], x) for k, x in near.items()}
    if isinstance(near, list | tuple):
        return type(near)(_change(*pair) for pair in zip(far, near, strict=True))
    return None if near is None else far - near


def _alike(first: LinearHierarchies) -> ScheduledHierarchies:
    """Return individuals whose second law equals the first."""
    return ScheduledHierarchies(first.tree, first, _law(first))


def _law(first: LinearHierarchies) -> Floats:
    """Return the gains (n, 2 + ...) of the first law: kp, kd and the columns of ``linear``."""
    return np.concatenate([first.fuzzy.gains, first.linear], axis=1)


def _second(population: ScheduledHierarchies) -> LinearHierarchies:
    """Return the hierarchies with the second law in place of the first."""
    first, second = population.first, population.second
    return first._replace(linear=second[:, 2:], fuzzy=first.fuzzy._replace(gains=second[:, :2]))


def _scaled(second: Floats, logarithms: Floats) -> Floats:
    return np.asarray(second[:1] * np.exp(np.clip(logarithms, -FAR, FAR)))


def genome_of(settings: HierarchicalSettings, target: Target) -> Genome:
    """Return the genome of a hierarchy that is added to a PD or a linear law, or blends laws."""
    if settings.linear is None:
        return HierarchicalGenome(settings, target)
    kind = ScheduledGenome if settings.schedules else LinearHierarchyGenome
    return kind(settings, target)
