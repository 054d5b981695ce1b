"""First individuals that know the drive: optimal regulators, laid down as rule tables.

A table whose consequents lie on a plane makes nearly a linear function of its two inputs; units
along a tree add up to one of all inputs. The regulators are those of the nominal drive, whose gains
on error and rate go to the PD beside the hierarchy and whose other gains go into its tables.
"""

from typing import TYPE_CHECKING

import numpy as np

from hfc_design.controllers.hierarchical import tree as hierarchy
from hfc_design.controllers.hierarchical.law import PREVIOUS, memberships
from hfc_design.controllers.hierarchical.record import HierarchicalSettings, layout_of
from hfc_design.controllers.linear import regulator
from hfc_design.controllers.linear.law import ERRORS
from hfc_design.controllers.linear.lq_genome import LqGenome
from hfc_design.controllers.linear.record import LqrSettings
from hfc_design.core.numbers import ARRAYS, Floats, Integers
from hfc_design.core.records import UserError
from hfc_design.stability.nominal import nominal

if TYPE_CHECKING:
    from hfc_design.controllers.hierarchical.genome import HierarchicalGenome, Hierarchies

#: Sums of the slopes of an inner unit, in shares of its largest consequent, between which they are
#: drawn. Its output is not clamped, but the terms of the unit that reads it end at 1: a large sum
#: bends early. Consequents of a plane go up to 1.41 times the sum.
REACH = (0.125, 0.7)
#: Constant command, in shares of the largest that the root may say.
OFFSET = (5e-4, 0.15)
#: Gain on the change of a velocity from sample to sample, in shares of kd, and how many have one.
INERTIA, WITH_INERTIA = (0.1, 30.0), 0.7
#: Standard deviation of the consequents about their plane.
NOISE = 0.02
#: Share of a signal that may differ from the error's rate, so that it counts as a velocity.
SAME = 1e-6


class Regulators:
    """Laws that a hierarchy can begin with.

    Raises:
        UserError: the drive cannot be linearised, or no regulator of it was found.
    """

    def __init__(self, genome: "HierarchicalGenome"):
        self.genome = genome
        target = genome.target
        model = nominal(target.machine.drives[0], target.parameters[0], target.sample_time)
        seen = {name: model.outputs[name] for name in genome.names if name in model.outputs}
        rate = model.outputs["error_rate"]
        #: Velocities that are read twice -> how much of the error's rate they are.
        self.velocities: dict[str, float] = {}
        for name, row in seen.items():
            share = float(row @ rate / (rate @ rate))
            alike = np.linalg.norm(row - share * rate) <= SAME * np.linalg.norm(row)
            if alike and f"{PREVIOUS}{name}" in genome.names:
                self.velocities[name] = share
        known = model._replace(outputs={**{name: model.outputs[name] for name in ERRORS}, **seen})
        signals = regulator.measured(known, None, target.machine.name).names[len(ERRORS) :]
        self.search = LqGenome(LqrSettings(kind="lqr", signals=signals), target)

    def fresh(self, tree: Integers, rng: np.random.Generator) -> "Hierarchies":
        """Regulators of random weights on the given trees."""
        genome, count = self.genome, len(tree)
        names, inputs = genome.names, len(genome.names)
        found = self.search.gains(self.search.fresh(np.zeros(count, int), rng))
        law = np.zeros((count, inputs))
        rows = () if found.signals is None else found.signals
        for name, row in zip(self.search.signals, rows, strict=True):
            law[:, names.index(name)] = row
        inertia = found.kd * _between(rng, INERTIA, count) * (rng.random(count) < WITH_INERTIA)
        for name, share in self.velocities.items():
            change = inertia / share / len(self.velocities)
            law[:, names.index(name)] += change
            law[:, names.index(f"{PREVIOUS}{name}")] -= change
        bounds = genome.bounds
        spread = np.log(bounds.scale_range) * rng.uniform(-1, 1, (count, inputs))
        scales = np.array(genome.scales) * np.exp(spread)
        if bounds.scale_range > 1.0:  # a change of two readings whose universes end at one value
            for name in self.velocities:
                scales[:, names.index(f"{PREVIOUS}{name}")] = scales[:, names.index(name)]
        reach = bounds.inner_limit * _between(rng, REACH, (count, inputs - 1))
        # Weights for which there is no regulator leave a PD alone.
        slopes = np.nan_to_num(law / scales / genome.settings.output_scale)
        sources = hierarchy.all_sources(inputs)[tree].astype(int)
        tables = along(sources, slopes, reach, passing(genome.settings))
        offset = bounds.root_limit * _between(rng, OFFSET, count) * rng.choice([-1.0, 1.0], count)
        tables[:, -1] += offset[:, None, None]
        tables += NOISE * rng.standard_normal(tables.shape)
        ranges = (found.kp, bounds.kp_range), (found.kd, bounds.kd_range)
        gains = [np.nan_to_num(gain).clip(low, high) for gain, (low, high) in ranges]
        limited = np.clip(tables, -genome.limit, genome.limit)
        return type(genome.empty())(tree, np.stack(gains, axis=1), scales, limited)


def along(sources: Integers, slopes: Floats, reach: Floats, levels: Floats) -> Floats:
    """Tables (n, units, 7, 7) that make ``slopes`` (n, inputs) of the scaled inputs of n trees.

    ``sources`` (n, units, 2) are those of the trees, ``levels`` (7,) the consequents that pass on
    what a unit reads. An inner unit's slopes sum up to its ``reach`` (n, units); what it lacks of
    the law the unit makes good that reads it.
    """
    count, units = sources.shape[:2]
    each = np.arange(count)
    tables = np.empty((count, units, len(levels), len(levels)))
    for k in range(units):
        column, row = (slopes[each, source] for source in sources[:, k].T)
        size = np.ones(count)
        if k < units - 1:
            whole = np.abs(column) + np.abs(row)
            # A unit of which the law asks nothing passes on a mean, and nobody listens yet.
            idle = whole == 0.0
            size = np.where(idle, 1.0, whole / reach[:, k])
            slopes = np.column_stack([slopes, np.where(idle, 0.0, size)])
            column, row = (np.where(idle, 0.5 * reach[:, k], x) for x in (column, row))
        rises = (column / size)[:, None] * levels, (row / size)[:, None] * levels
        tables[:, k] = rises[0][:, None, :] + rises[1][:, :, None]
    return tables


def passing(settings: HierarchicalSettings) -> Floats:
    """(7,) consequents of which a unit makes the value that it reads, as nearly as seven can."""
    u = np.linspace(-1.0, 1.0, 401)
    shares = np.array(memberships(ARRAYS, layout_of(settings).terms, u))
    return np.asarray(np.linalg.lstsq((shares / shares.sum(axis=0)).T, u, rcond=None)[0])


def regulators_for(genome: "HierarchicalGenome") -> Regulators | None:
    """Laws for the nominal drive; None where it has none."""
    try:
        return Regulators(genome)
    except UserError:
        return None


def _between(
    rng: np.random.Generator, ends: tuple[float, float], shape: int | tuple[int, ...]
) -> Floats:
    """Numbers between two ends, evenly by their logarithms."""
    low, high = np.log(ends)
    return np.asarray(np.exp(rng.uniform(low, high, shape)))
