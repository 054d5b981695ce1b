"""Genome of a feed drive's fuzzy controller: singletons, terms, integral gain, limit of K_1."""

from functools import cache
from typing import Any, NamedTuple

import jax
import numpy as np

from hfc_design.controllers.flc.law import FlcGains
from hfc_design.controllers.flc.record import SIDES, FuzzySettings, terms_of
from hfc_design.controllers.flc.rules import nearest_labels
from hfc_design.controllers.genome import Genome, Stage, some, taken
from hfc_design.controllers.kind import Target
from hfc_design.controllers.neighbours import Partition
from hfc_design.core.numbers import ARRAYS, Floats, Gains, Integers, Json, Own
from hfc_design.stability.sectors import Rectangle, bounded, inner_edges, middle
from hfc_design.stability.stable_range import StableRange, stable_range

#: Smallest distance of neighbouring centres: of error terms, and of terms of its change [BLU].
SMALLEST_GAP = (1.0, 0.25)
#: Smallest overlap of neighbouring terms, as a share of their centres' distance.
SMALLEST_OVERLAP = 0.1
#: Range of the searched limit of K_1 (see ``stability.sectors``), as a share of ``k1_bound``.
SHARES = (0.1, 0.95)
#: Limit of K_2, as a share of the largest K_2 in the stable range at the limit of K_1.
INSIDE = 0.99
#: Number of K_1 at which the largest K_2 of the stable range is tabulated for interpolation.
POINTS = 200
#: Initial standard deviation of a distribution of all numbers, and the logarithm of the largest
#: factor by which the distance of two centres may grow or shrink in this distribution.
EVERYTHING, FAR = 0.02, 4.0


class FuzzyTables(NamedTuple):
    """Population of n individuals; the first axis of every array counts the individuals.

    A joint describes the overlap of two neighbouring terms: the distance of their centres, the left
    edge of the upper term and the right edge of the lower term. Both edges are measured from the
    lower centre, in shares of this distance.
    """

    tree: Integers  # (n,) 0: there is one structure
    joints: Floats  # (n, joints, 3): those of the error first; distance [BLU], left, right [1]
    singletons: Floats  # (n, error terms, change terms), units of the command
    k_i: Floats  # (n,) [units/(BLU s)]
    share: Floats  # (n,) limit of the table's K_1, as a share of ``StableRange.k1_bound``


class FuzzyGenome(Genome):
    """Operations of a search on ``FuzzyTables``.

    The gains of every table stay in a rectangle [0, K_1] x [0, K_2] inside the narrowest of the
    axes' stable ranges. If the table adapts, it stays in this rectangle too, and no overlap of
    terms gets smaller than the smallest initial one.
    """

    def __init__(self, settings: FuzzySettings, target: Target):
        super().__init__(settings, target)
        drives = list(zip(target.machine.drives, target.parameters, strict=True))
        linear = (drive.linear(parameters) for drive, parameters in drives if drive.linear)
        ranges = (stable_range(k, tau, target.sample_time) for k, tau in linear)
        ends = (drive.largest_commands(parameters) for drive, parameters in drives)
        commands = (abs(end) for pair in ends for end in pair)
        limits = (limit for limit in target.limits.values() if limit is not None)
        self.start: Own = settings.start.on(*drives[0])  # a FuzzyRecord of the kind
        self.terms = tuple(map(len, self.start.table()[:2]))  # number of terms: error, change
        rows, columns = (count - 1 for count in self.terms)
        self.side = np.repeat([0, 1], [rows, columns])  # 0: joint of the error, 1: of its change
        self.mirror = np.r_[rows - 1 : -1 : -1, rows + columns - 1 : rows - 1 : -1]
        self.stable = min(ranges, key=lambda gain_range: gain_range.k1_bound)
        self.largest_command = min(*commands, *limits)  # [unit]

    def empty(self) -> FuzzyTables:
        """Return one individual, the start of the search."""
        table = self.start.table()
        sides = [np.array(terms) for terms in (table.error_terms, table.change_terms)]
        lower = np.concatenate([terms[:-1] for terms in sides])
        upper = np.concatenate([terms[1:] for terms in sides])
        gap = upper[..., 1] - lower[..., 1]
        left, right = upper[..., 0] - lower[..., 1], lower[..., 2] - lower[..., 1]
        individual = FuzzyTables(
            np.zeros(1, int),
            np.stack([gap, left / gap, right / gap], axis=-1)[None],
            np.array([table.singletons]),
            np.array([table.k_i]),
            np.array([0.6]),
        )
        return self._allowed(individual)

    def fresh(self, tree: Integers, rng: np.random.Generator) -> FuzzyTables:
        """Return the start, and variations of it: other widths, heights and gains, and noise."""
        count = len(tree)
        start = taken(self.empty(), np.zeros(count, int))
        near = rng.random(count)  # 0: equal to the start
        near[0] = 0.0
        factor = np.exp(near[:, None] * rng.standard_normal((count, 3)))
        noise = near[:, None, None] * rng.standard_normal(start.singletons.shape)
        joints = start.joints + 0.2 * near[:, None, None] * rng.standard_normal(start.joints.shape)
        joints[..., 0] = start.joints[..., 0] * factor[:, self.side]
        return self._allowed(
            start._replace(
                tree=tree,
                joints=joints,
                singletons=start.singletons * factor[:, 2, None, None] + 4.0 * noise,
                k_i=self.settings.largest_integral_gain * near * rng.random(count) ** 3 + start.k_i,
                share=rng.uniform(*SHARES, count),
            )
        )

    def mutated(
        self, population: FuzzyTables, step: Floats, rng: np.random.Generator
    ) -> FuzzyTables:
        """Move singletons and joints; scale, tilt and shift tables; change gains and limits."""
        count = len(population.tree)
        size = step[:, None, None]
        shape = population.singletons.shape
        each = np.exp(rng.uniform(-np.log(shape[1] * shape[2]), 0.0, (count, 1, 1)))
        rows, columns = (np.linspace(-1.0, 1.0, terms) for terms in self.terms)
        tilt = some(rng, (3, count, 1, 1), 0.2)
        moved = some(rng, shape, each) + tilt[0] * columns + tilt[1] * rows[:, None]
        singletons = population.singletons * np.exp(size * tilt[2])
        joints = population.joints + size * some(rng, population.joints.shape, 0.2)
        widths = some(rng, (count, 2), 0.3)[:, self.side] + some(rng, joints.shape[:2], 0.2)
        joints[..., 0] = population.joints[..., 0] * np.exp(step[:, None] * widths)
        k_i = population.k_i * np.exp(step * some(rng, (count,), 0.3))
        fresh = self.settings.largest_integral_gain * rng.random(count) ** 3
        return self._allowed(
            population._replace(
                joints=joints,
                singletons=singletons + 0.25 * self.largest_command * size * moved,
                k_i=np.where(rng.random(count) < 0.05, fresh, k_i),
                share=population.share + step * some(rng, (count,), 0.3),
            )
        )

    def blended(self, one: FuzzyTables, other: FuzzyTables, share: Floats) -> FuzzyTables:
        """Interpolate every number linearly."""
        pairs = zip(one[1:], other[1:], strict=True)
        arrays = (a + share.reshape(-1, *(1,) * (a.ndim - 1)) * (b - a) for a, b in pairs)
        return self._allowed(FuzzyTables(one.tree, *arrays))

    def nudged(self, population: FuzzyTables, rng: np.random.Generator) -> FuzzyTables:
        """Reduce singletons by up to a millionth."""
        off = 1.0 - 1e-6 * rng.random(population.singletons.shape)
        return population._replace(singletons=population.singletons * off)

    def around(self, about: FuzzyTables) -> Stage:
        """Return a stage: logarithms of centres' distances, and the rest in shares of ranges."""
        heights = self.largest_command
        most = self.settings.largest_integral_gain
        widths, edges = about.joints[0, ..., 0], about.joints[0, ..., 1:]
        ends = np.cumsum([widths.size, edges.size, about.singletons[0].size, 1])

        def members(points: Floats, tree: Integers) -> FuzzyTables:
            parts = np.split(points, ends, axis=1)
            logarithms = np.clip(parts[0], -FAR, FAR).reshape(-1, *widths.shape)
            moved = edges + parts[1].reshape(-1, *edges.shape)
            joints = np.concatenate([(widths * np.exp(logarithms))[..., None], moved], axis=-1)
            table = parts[2].reshape(-1, *about.singletons.shape[1:])
            return self._allowed(
                FuzzyTables(
                    tree,
                    joints,
                    about.singletons + heights * table,
                    about.k_i + most * parts[3][:, 0],
                    about.share + parts[4][:, 0],
                )
            )

        return Stage(np.zeros(int(ends[-1]) + 1), EVERYTHING, members)

    def gains(self, population: FuzzyTables) -> Gains:
        """Return the gains of the population for the simulator."""
        table, count = self.start.table(), len(population.tree)
        given = (table.compensation, table.dead_zone)
        given = jax.tree.map(lambda number: np.full(count, number), given)
        singletons: Any = np.moveaxis(population.singletons, 0, -1)
        error_terms, change_terms = self.triangles(population.joints)
        return FlcGains(error_terms, change_terms, singletons, population.k_i, *given)

    def record(self, individual: FuzzyTables) -> Json:
        """Return the record of the kind: the start with the searched values replaced."""
        record: Json = self.start.model_dump()
        for key, terms in zip(SIDES, self.triangles(individual.joints), strict=True):
            labels = [term["label"] for term in record[key]]
            record[key] = [term.model_dump() for term in terms_of(terms[..., 0].tolist(), labels)]
        table = individual.singletons[0]
        record["rules"] = {"labels": nearest_labels(table.tolist()), "centroids": table.tolist()}
        record["integral_gain"] = float(individual.k_i[0])
        return record

    def _allowed(self, population: FuzzyTables) -> FuzzyTables:
        """Return the nearest individuals with overlapping terms and with numbers within limits."""
        joints, singletons = population.joints.copy(), population.singletons
        if self.settings.symmetric:
            mirrored = joints[:, self.mirror]
            joints[..., 0] = 0.5 * (joints[..., 0] + mirrored[..., 0])
            left = 0.5 * (joints[..., 1] + 1.0 - mirrored[..., 2])
            joints[..., 1], joints[..., 2] = left, 1.0 - left[:, self.mirror]
            singletons = 0.5 * (singletons - singletons[:, ::-1, ::-1])
        least = self.smallest_gap()[self.side]
        gap = np.maximum(joints[..., 0], least)
        half = 0.5 * np.maximum(SMALLEST_OVERLAP, least / (2.0 * gap))
        left, right = np.moveaxis(np.clip(joints[..., 1:], 0.0, 1.0), -1, 0)
        middle = np.clip(0.5 * (left + right), half, 1.0 - half)
        tight = right - left < 2.0 * half
        left, right = np.where(tight, [middle - half, middle + half], [left, right])
        joints = np.stack([gap, left, right], axis=-1)
        share = np.clip(population.share, *SHARES)
        singletons = np.clip(singletons, -self.largest_command, self.largest_command)
        return population._replace(
            joints=joints,
            singletons=_in_sectors(self.sectors(share), self.triangles(joints), singletons),
            k_i=np.clip(population.k_i, 0.0, self.settings.largest_integral_gain),
            share=share,
        )

    def triangles(self, joints: Floats) -> tuple[Any, Any]:
        """Return terms (terms, 3, n) of the error and of its change from joints (n, joints, 3)."""
        error, change = (terms_of_joints(joints[:, self.side == side]) for side in (0, 1))
        return error, change

    def smallest_gap(self) -> Floats:
        """Smallest distances (2,) of neighbouring centres [BLU]."""
        return np.array(SMALLEST_GAP)

    def sectors(self, share: Floats) -> Rectangle:
        """Return limits (n,) of K_1 and K_2; that of K_1 is ``share`` (n,) of ``k1_bound``."""
        k1 = share * self.stable.k1_bound
        return Rectangle(k1, INSIDE * np.interp(k1, *_bounds(self.stable)))


@cache
def _bounds(stable: StableRange) -> tuple[Floats, Floats]:
    """Return evenly spaced K_1 (POINTS,), and the largest K_2 of the stable range at each."""
    k1 = np.linspace(*SHARES, POINTS) * stable.k1_bound
    return k1, stable.k2(k1)


def terms_of_joints(joints: Floats) -> Floats:
    """Return terms (terms, 3, n) of an input from its joints (n, terms - 1, 3).

    The middle term is centred on 0; the outermost edges are infinite.
    """
    gap = joints[..., 0]
    centres = np.cumsum(np.insert(gap, 0, 0.0, axis=-1), axis=-1)
    half = gap.shape[-1] // 2
    centres = centres - centres[..., half : half + 1]
    lower, upper = centres[..., :-1], centres[..., 1:]
    left, right = np.full_like(centres, -np.inf), np.full_like(centres, np.inf)
    # Clipped, so that rounding moves no edge past a centre.
    left[..., 1:] = np.clip(lower + joints[..., 1] * gap, lower, upper)
    right[..., :-1] = np.clip(lower + joints[..., 2] * gap, lower, upper)
    return np.moveaxis(np.stack([left, centres, right], axis=-1), 0, -1)


def _in_sectors(sectors: Rectangle, terms: tuple[Any, Any], singletons: Floats) -> Floats:
    """Return the nearest singletons (n, rows, columns) whose K_1 and K_2 obey ``sectors`` (n,)."""
    table: Any = np.moveaxis(singletons, 0, -1)
    error_terms, change_terms = terms
    row_edges, edges = (inner_edges(*Partition.of(side)[1:]) for side in terms)
    bound = bounded(ARRAYS, sectors, row_edges, edges, table, table)
    zero = middle(error_terms)  # ``bounded`` leaves its row
    rows = [[*(bound(i) if i != zero else table[i])] for i in range(len(row_edges))]
    # The adaptation leaves this row as it is; a search has to bound it by the sector of u_2 too.
    row, none = rows[zero], middle(change_terms)
    for j in range(len(row)):
        most = sectors.k2_max * edges[j]
        low, high = (0.0, most) if j > none else (most, 0.0)
        row[j] = 0.0 * most if j == none else np.clip(row[j], low, high)
    return np.moveaxis(np.array(rows), -1, 0)
