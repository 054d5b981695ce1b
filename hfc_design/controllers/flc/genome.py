"""Genome of a feed drive's fuzzy controller: singletons, terms, integral gain, its sectors."""

from functools import cache, partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from hfc_design.controllers.controller import Controller
from hfc_design.controllers.flc.law import FlcGains, flc
from hfc_design.controllers.flc.record import LABELS, FuzzyRecord, nearest_labels
from hfc_design.controllers.flc.sectors import ZR, Sectors, bounded
from hfc_design.controllers.flc.settings import FuzzySettings
from hfc_design.controllers.genome import some, taken
from hfc_design.controllers.kind import Target, per_axis
from hfc_design.core.records import TERMS
from hfc_design.core.scalars import ARRAYS
from hfc_design.core.shapes import Floats, Gains, Integers, Json, Own, Triangles
from hfc_design.stability.stable_range import StableRange, stable_range

#: Neighbouring centres of the error and of its change are at least so far apart [BLU].
SMALLEST_GAP = (1.0, 0.25)
#: Neighbouring terms overlap by at least this share of their centres' distance.
SMALLEST_OVERLAP = 0.1
#: K_1 limits between these shares of the stable range's K_1.
SHARES = (0.1, 0.95)
#: Part of the K_2 that the stable range allows at a K_1 limit.
INSIDE = 0.99
#: Places of the range's K_2 bound between which it is interpolated.
POINTS = 200


class FuzzyTables(NamedTuple):
    """n individuals; every array carries them in its leading axis.

    A joint is where two neighbouring terms overlap: the distance of their centres, and from the
    lower centre on, in shares of it, the left edge of the upper term and the right edge of the
    lower one.
    """

    tree: Integers  # (n,) 0: there is one structure
    joints: Floats  # (n, 2, 6, 3): of error and its change; distance [BLU], left, right [1]
    singletons: Floats  # (n, 7, 7), units of the command
    k_i: Floats  # (n,) [units/(BLU s)]
    share: Floats  # (n,) K_1 limit of the table, in shares of the stable range's K_1


class FuzzyGenome(NamedTuple):
    """What a search can do with ``FuzzyTables``.

    Every individual keeps its table in a rectangle [0, K_1] x [0, K_2] of the stable range. Where
    it adapts it stays in this rectangle, and its terms overlap no less than they do at first.
    """

    start: Own  # a FuzzyRecord of the kind
    stable: StableRange
    largest_command: float  # [unit]
    largest_integral_gain: float  # [units/(BLU s)]
    symmetric: bool
    target: Target

    @property
    def controller(self) -> Controller:
        """The start's form of the controller."""
        law = partial(flc, self.start.control_form(), self.start.sample_time_s)
        return per_axis(self.start.kind, law, self.target)

    @property
    def structures(self) -> int:
        """One."""
        return 1

    def empty(self) -> FuzzyTables:
        """One individual, the start."""
        table = self.start.table()
        joints = [_joints(terms) for terms in (table.error_terms, table.change_terms)]
        found = FuzzyTables(
            np.zeros(1, int),
            np.array(joints)[None],
            np.array(table.singletons)[None],
            np.array([table.k_i]),
            np.array([0.6]),
        )
        return self._allowed(found)

    def fresh(self, tree: Integers, rng: np.random.Generator) -> FuzzyTables:
        """The start, and the start with other widths, heights, gains and noise."""
        count = len(tree)
        found = taken(self.empty(), np.zeros(count, int))
        near = rng.random(count)  # 0: as the start
        near[0] = 0.0
        factor = np.exp(near[:, None] * rng.standard_normal((count, 3)))
        noise = near[:, None, None] * rng.standard_normal(found.singletons.shape)
        joints = found.joints + 0.2 * near[:, None, None, None] * rng.standard_normal(
            found.joints.shape
        )
        joints[..., 0] = found.joints[..., 0] * factor[:, :2, None]
        return self._allowed(
            found._replace(
                tree=tree,
                joints=joints,
                singletons=found.singletons * factor[:, 2, None, None] + 4.0 * noise,
                k_i=self.largest_integral_gain * near * rng.random(count) ** 3 + found.k_i,
                share=rng.uniform(*SHARES, count),
            )
        )

    def mutated(
        self, population: FuzzyTables, step: Floats, rng: np.random.Generator
    ) -> FuzzyTables:
        """Move single singletons and joints, scale, tilt and shift the whole."""
        count = len(population.tree)
        size = step[:, None, None]
        each = np.exp(rng.uniform(-np.log(TERMS * TERMS), 0.0, (count, 1, 1)))
        place = np.linspace(-1.0, 1.0, TERMS)
        tilt = some(rng, (3, count, 1, 1), 0.2)
        moved = some(rng, (count, TERMS, TERMS), each) + tilt[0] * place + tilt[1] * place[:, None]
        singletons = population.singletons * np.exp(size * tilt[2])
        joints = population.joints + size[..., None] * some(rng, population.joints.shape, 0.2)
        widths = some(rng, (count, 2, 1), 0.3) + some(rng, (count, 2, TERMS - 1), 0.2)
        joints[..., 0] = population.joints[..., 0] * np.exp(size * widths)
        k_i = population.k_i * np.exp(step * some(rng, (count,), 0.3))
        fresh = self.largest_integral_gain * rng.random(count) ** 3
        return self._allowed(
            population._replace(
                joints=joints,
                singletons=singletons + 0.25 * self.largest_command * size * moved,
                k_i=np.where(rng.random(count) < 0.05, fresh, k_i),
                share=population.share + step * some(rng, (count,), 0.3),
            )
        )

    def blended(self, one: FuzzyTables, other: FuzzyTables, share: Floats) -> FuzzyTables:
        """Every number on a straight line."""
        arrays = (
            a + share.reshape(-1, *(1,) * (a.ndim - 1)) * (b - a)
            for a, b in zip(one[1:], other[1:], strict=True)
        )
        return self._allowed(FuzzyTables(one.tree, *arrays))

    def nudged(self, population: FuzzyTables, rng: np.random.Generator) -> FuzzyTables:
        """Other singletons by a millionth."""
        off = 1.0 - 1e-6 * rng.random(population.singletons.shape)
        return population._replace(singletons=population.singletons * off)

    def gains(self, population: FuzzyTables) -> Gains:
        """The population as the simulator wants it."""
        error_terms, change_terms = (_lanes(_terms(joints)) for joints in by_input(population))
        return FlcGains(
            error_terms,
            change_terms,
            _lanes(population.singletons),
            population.k_i,
            alike(self.start.table().compensation, len(population.tree)),
        )

    def notation(self, structure: int) -> str:
        """There is one."""
        return str(self.start.kind)

    def record(self, individual: FuzzyTables) -> Json:
        """The kind's record: as the start but for what was searched."""
        record: Json = self.start.model_dump()
        keys = ("error_terms", "error_change_terms")
        for key, joints in zip(keys, by_input(individual), strict=True):
            edges = _terms(joints)[0].tolist()
            record[key] = [
                {"label": label, "left": left, "centre": centre, "right": right}
                for label, (left, centre, right) in zip(LABELS, edges, strict=True)
            ]
            record[key][0]["left"] = record[key][-1]["right"] = None
        table = individual.singletons[0]
        record["rules"] = {"labels": nearest_labels(table.tolist()), "centroids": table.tolist()}
        record["integral_gain"] = float(individual.k_i[0])
        return record

    def _allowed(self, population: FuzzyTables) -> FuzzyTables:
        """The nearest individuals whose terms leave no gap and whose tables are in range."""
        joints, singletons = population.joints.copy(), population.singletons
        if self.symmetric:
            mirrored = joints[:, :, ::-1]
            joints[..., 0] = 0.5 * (joints[..., 0] + mirrored[..., 0])
            left = 0.5 * (joints[..., 1] + 1.0 - mirrored[..., 2])
            joints[..., 1], joints[..., 2] = left, 1.0 - left[:, :, ::-1]
            singletons = 0.5 * (singletons - singletons[:, ::-1, ::-1])
        gap = np.maximum(joints[..., 0], self.smallest_gap()[:, None])
        half = 0.5 * np.maximum(SMALLEST_OVERLAP, self.smallest_gap()[:, None] / (2.0 * gap))
        left, right = np.clip(joints[..., 1], 0.0, 1.0), np.clip(joints[..., 2], 0.0, 1.0)
        middle = np.clip(0.5 * (left + right), half, 1.0 - half)
        tight = right - left < 2.0 * half
        joints[..., 0] = gap
        joints[..., 1] = np.where(tight, middle - half, left)
        joints[..., 2] = np.where(tight, middle + half, right)
        limit = self.largest_command
        share = np.clip(population.share, *SHARES)
        error_terms, change_terms = (_lanes(_terms(joints[:, k])) for k in range(2))
        singletons = np.clip(singletons, -limit, limit)
        return population._replace(
            joints=joints,
            singletons=_in_sectors(self.sectors(share), error_terms, change_terms, singletons),
            k_i=np.clip(population.k_i, 0.0, self.largest_integral_gain),
            share=share,
        )

    def smallest_gap(self) -> Floats:
        """(2,) that neighbouring centres are apart [BLU]."""
        return np.array(SMALLEST_GAP)

    def sectors(self, share: Floats) -> Sectors:
        """Limits of tables whose K_1 stays below ``share`` (n,) of the stable range's."""
        k1 = share * self.stable.k1
        places = np.linspace(SHARES[0], SHARES[1], POINTS) * self.stable.k1
        bound = np.interp(k1, places, _bounds(self.stable))
        return Sectors(k1, INSIDE * bound)


def genome_of(
    settings: FuzzySettings, target: Target, genome: type[FuzzyGenome] = FuzzyGenome
) -> FuzzyGenome:
    """The genome of a feed drive's fuzzy controller, inside the narrowest range of the axes."""
    start: FuzzyRecord = settings.start
    drives = list(zip(target.machine.drives, target.parameters, strict=True))
    linear = (drive.linear(own) for drive, own in drives if drive.linear)
    ranges = (stable_range(k, tau, target.sample_time) for k, tau in linear)
    commands = (abs(end) for drive, own in drives for end in drive.largest_commands(own))
    limits = (limit for limit in target.limits.values() if limit is not None)
    return genome(
        start.on(*drives[0]),
        min(ranges, key=lambda found: found.k1),
        min(*commands, *limits),
        settings.largest_integral_gain,
        settings.symmetric,
        target,
    )


@cache
def _bounds(stable: StableRange) -> Floats:
    """(POINTS,) K_2 that the range allows at evenly spaced K_1."""
    return stable.k2(np.linspace(SHARES[0], SHARES[1], POINTS) * stable.k1)


def by_input(population: FuzzyTables) -> tuple[Floats, Floats]:
    """Joints (n, 6, 3) of the error and of its change."""
    return population.joints[:, 0], population.joints[:, 1]


def alike(value: Any, count: int) -> Any:
    """A record of numbers for ``count`` individuals that all have it."""
    if isinstance(value, tuple):
        parts = (alike(part, count) for part in value)
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    return None if value is None else np.full(count, value)


def _lanes(values: Floats) -> Any:
    """The individuals in the trailing axis."""
    return np.moveaxis(values, 0, -1)


def _joints(terms: Triangles) -> list[tuple[float, float, float]]:
    """Joints (6, 3) of terms (7, 3)."""
    found = []
    for lower, upper in pairwise(terms):
        gap = upper[1] - lower[1]
        found.append((gap, (upper[0] - lower[1]) / gap, (lower[2] - lower[1]) / gap))
    return found


def _terms(joints: Floats) -> Floats:
    """Terms (n, 7, 3) of joints (n, 6, 3); ZR is centred on 0, the outermost edges are infinite."""
    gap = joints[..., 0]
    centres = np.concatenate([np.zeros((len(gap), 1)), np.cumsum(gap, axis=1)], axis=1)
    centres = centres - centres[:, ZR : ZR + 1]
    lower, upper = centres[:, :-1], centres[:, 1:]
    left, right = (
        np.clip(lower + joints[..., k] * gap, lower, upper)  # rounding passes no centre
        for k in (1, 2)
    )
    infinite = np.full((len(gap), 1), np.inf)
    left = np.concatenate([-infinite, left], axis=1)
    right = np.concatenate([right, infinite], axis=1)
    return np.stack([left, centres, right], axis=-1)


def _in_sectors(
    sectors: Sectors, error_terms: Triangles, change_terms: Triangles, singletons: Floats
) -> Floats:
    """Singletons (n, 7, 7) moved to the nearest that keep the table in ``sectors`` of (n,)."""
    table = _lanes(singletons)
    rows = bounded(ARRAYS, sectors, error_terms, change_terms, table, table)
    # The adaptation never touches the row of no error; here it has to obey the sector of u_2 too.
    for j in range(TERMS):
        reach = sectors.k2_max * (
            change_terms[j - 1][2] if j > ZR else change_terms[min(j + 1, TERMS - 1)][0]
        )
        low, high = (0.0, reach) if j > ZR else (reach, 0.0)
        rows[ZR][j] = 0.0 * reach if j == ZR else np.clip(rows[ZR][j], low, high)
    return np.moveaxis(np.array(rows), -1, 0)
