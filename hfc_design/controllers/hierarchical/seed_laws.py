"""Simple laws from which the search for a hierarchy starts, and their translation to rule tables.

A law has a PD, gains on signals, a gain on the change of velocities from sample to sample (as if
the machine were heavier) and a constant command. All but the PD is limited like the root's output.
A search of these few numbers takes seconds. Then ``SeedLaws.laid`` translates laws to tables of
trees, where the search continues; no design file contains such a law.
"""

from typing import Any, NamedTuple

import numpy as np

from hfc_design.controllers.controller import AxisLaw, PerAxis, Signals
from hfc_design.controllers.hierarchical.law import PREVIOUS
from hfc_design.controllers.hierarchical.linear_tables import linear_chain, passthrough
from hfc_design.controllers.linear import regulator
from hfc_design.controllers.linear.law import ERRORS
from hfc_design.controllers.linear.lq_genome import LqGenome
from hfc_design.controllers.linear.record import LqrSettings
from hfc_design.core.numbers import Floats, Integers, Memory, Scalar, Xp, clipped, total
from hfc_design.stability.nominal import nominal

#: Sums of the slopes of an inner unit, in shares of its largest consequent: values tried in first
#: tables, and limits. A large sum saturates early: the terms of the unit that reads the output end
#: at 1. A small sum needs large consequents in the following units, which are limited too. The
#: largest consequent of a plane is 1.41 times the sum.
REACH, ENDS = (0.2, 0.4, 0.7, 1.0), (0.02, 3.0)
#: Range of the constant command of first laws, in shares of the command at which laws saturate.
OFFSET = (5e-4, 0.15)
#: Gain on the change of a velocity from sample to sample: range in first laws, in shares of kd;
#: share of first laws that have such a gain; largest gain, in multiples of that with which a change
#: as large as the velocity's range commands the limit.
INERTIA, WITH_INERTIA, MOST_INERTIA = (0.1, 30.0), 0.7, 20.0
TINY = 1e-9
#: A signal counts as a velocity if no more than this share of it differs from the error's rate.
SAME = 1e-6
#: Factors on all gains of a law before first tables are made of it, and limits of the ranges of the
#: inputs, in shares of the largest signals: only trials show which values are good.
SHARES, UNIVERSE = (1.0, 1.0, 0.6, 0.3), (0.7, 3.0)


class Laws(NamedTuple):
    """Population of n laws; the first axis of every array counts the laws."""

    tree: Integers  # (n,) 0: they have no structure
    numbers: Floats  # (n, size) kp, kd, gains on signals, on the change, the constant


class LawGains(NamedTuple):
    """Gains of laws for ``simulate``."""

    kp: Scalar
    kd: Scalar
    signals: Any  # (signals, n)
    change: Scalar
    constant: Scalar


class Structure(NamedTuple):
    """Structure of a law: signals, velocities (name, factor), and the limit of all but the PD."""

    signals: tuple[str, ...]
    velocities: tuple[tuple[str, float], ...]
    largest: float


class SeedLaws:
    """Operations of a search on ``Laws``; UserError: the drive is not linearised or regulated."""

    def __init__(self, genome: Any):
        self.genome = genome  # the ``HierarchicalGenome`` of the tables
        target = genome.target
        model = nominal(target.machine.drives[0], target.parameters[0], target.sample_time)
        seen = {name: model.outputs[name] for name in genome.names if name in model.outputs}
        rate = model.outputs["error_rate"]
        #: Velocities read now and a sample later, as multiples of the error's rate.
        self.velocities: dict[str, float] = {}
        for name, row in seen.items():
            share = float(row @ rate / (rate @ rate))
            alike = np.linalg.norm(row - share * rate) <= SAME * np.linalg.norm(row)
            if alike and f"{PREVIOUS}{name}" in genome.names:
                self.velocities[name] = share
        known = model._replace(outputs={**{name: model.outputs[name] for name in ERRORS}, **seen})
        signals = regulator.measured(known, None, target.machine.name).names[len(ERRORS) :]
        self.search = LqGenome(LqrSettings(kind="lqr", signals=signals), target)
        self.largest = genome.bounds.root_limit * genome.settings.output_scale
        scale = dict(zip(self.search.states.names, self.search.scale, strict=True))
        #: Approximate sizes (size - 2,) of the numbers after kp and kd.
        self.units = np.array(
            [*(scale[name] for name in signals), scale["error_rate"], 0.01 * self.largest]
        )

        twice = [genome.scales[genome.names.index(name)] for name in self.velocities]
        #: Largest gain on the change: with larger gains, tables have steps instead of slopes.
        self.most = MOST_INERTIA * self.largest * max(twice, default=0.0)

    @property
    def signals(self) -> tuple[str, ...]:
        """Names of the signals with a gain."""
        return self.search.signals

    def fresh(self, count: int, rng: np.random.Generator) -> Laws:
        """Return regulators of random weights, with a random gain on the change and constant."""
        gains = self.search.gains(self.search.fresh(np.zeros(count, int), rng))
        with_it = rng.random(count) < WITH_INERTIA
        change = gains.kd * between(rng, INERTIA, count) * with_it
        constant = self.largest * between(rng, OFFSET, count) * rng.choice([-1.0, 1.0], count)
        rows = () if gains.signals is None else gains.signals
        numbers = np.stack([gains.kp, gains.kd, *rows, change, constant], axis=1)
        # If the weights have no regulator, all gains are 0: the axis diverges or stands still.
        return Laws(np.zeros(count, int), np.nan_to_num(numbers))

    def points(self, laws: Laws) -> Floats:
        """Return coordinates (n, size): logarithms of kp and kd, arcsinh of the other numbers."""
        gains = np.log(np.maximum(laws.numbers[:, :2], TINY))
        return np.concatenate([gains, np.arcsinh(laws.numbers[:, 2:] / self.units)], axis=1)

    def laws(self, points: Floats) -> Laws:
        """Return the laws with the coordinates ``points`` (n, size), see the method ``points``."""
        gains, others = np.exp(np.clip(points[:, :2], -21.0, 21.0)), points[:, 2:]
        numbers = np.concatenate([gains, self.units * np.sinh(np.clip(others, -21, 21))], axis=1)
        numbers[:, -2] = np.clip(numbers[:, -2], -self.most, self.most)
        return Laws(np.zeros(len(points), int), numbers)

    def gains(self, laws: Laws) -> LawGains:
        """Return the gains of the laws for ``simulate``."""
        kp, kd, *signals, change, constant = laws.numbers.T
        rows = np.array(signals).reshape(len(signals), len(kp))
        return LawGains(kp, kd, rows, change, constant)

    def controller(self) -> PerAxis:
        """Return a controller that applies such a law to every axis, with the first axis' limit."""
        velocities = tuple((name, 1.0 / share) for name, share in self.velocities.items())
        structure = Structure(self.signals, velocities, self.largest)
        target = self.genome.target
        limit = next(iter(target.limits.values()))
        law = AxisLaw(_sample, _memory, target.sample_time, limit, structure)
        return PerAxis("linear law of few numbers", (law,) * len(target.machine.axes))

    def ways(self, laws: Laws, rng: np.random.Generator) -> Floats:
        """Return points (n, size + 2) for ``laid``: laws times random factors, random ranges."""
        count = len(laws.tree)
        share = rng.choice(SHARES, (count, 1))
        points = self.points(laws._replace(numbers=share * laws.numbers))
        wide, inner_range = between(rng, UNIVERSE, count), rng.choice(REACH, count)
        return np.column_stack([points, np.log(wide), np.log(inner_range)])

    def laid(self, points: Floats, tree: Integers, sizes: Floats) -> Any:
        """Return ``Hierarchies`` on trees (n,) whose tables approximate laws.

        ``points`` (n, size + 2) are the coordinates of laws, followed by two logarithms: that of
        the ranges of inputs, in shares of ``sizes`` (inputs,), the largest magnitudes of the inputs
        under such a law; and that of the sum of an inner unit's slopes (see ``REACH``).
        """
        genome, count = self.genome, len(tree)
        names, inputs = genome.names, len(genome.names)
        kp, kd, *signals, change, constant = self.laws(points[:, :-2]).numbers.T
        slopes = np.zeros((count, inputs))
        for name, gain in zip(self.signals, signals, strict=True):
            slopes[:, names.index(name)] = gain
        for name, size in self.velocities.items():
            slope = change / size / len(self.velocities)
            slopes[:, names.index(name)] += slope
            slopes[:, names.index(f"{PREVIOUS}{name}")] -= slope
        most = genome.bounds.scale_range
        low, high = np.array(genome.scales) / most, np.array(genome.scales) * most
        wide, inner_range = np.exp(points[:, -2:].T)
        scales = 1.0 / np.maximum(wide[:, None] * sizes, TINY)
        scales = np.clip(scales, low, high)
        for name in self.velocities:  # both readings of a change need the same scale
            pair = [names.index(name), names.index(f"{PREVIOUS}{name}")]
            if low[pair].max() <= high[pair].min():
                one = np.clip(scales[:, pair[:1]], low[pair].max(), high[pair].min())
                scales[:, pair] = one
        inner_range = genome.bounds.inner_limit * np.clip(inner_range, *ENDS)[:, None]
        output = genome.settings.output_scale
        sources = genome.sources[tree].astype(int)
        level = np.repeat(inner_range, genome.units, axis=1), passthrough(genome.settings)
        tables = linear_chain(sources, slopes / scales / output, *level)
        tables[:, -1] += (constant / output)[:, None, None]
        gains = np.maximum(np.stack([kp, kd], axis=1), TINY)
        limited = np.clip(tables, -genome.limit, genome.limit)
        return type(genome.empty())(tree, gains, scales, limited)


def _memory(law: AxisLaw, zero: Scalar) -> tuple[Memory, ...]:
    """Return the memory before the first sample: every velocity is zero."""
    return tuple(zero for _ in law.structure.velocities)


def _sample(
    xp: Xp, law: AxisLaw, gains: LawGains, memory: tuple[Scalar, ...], signals: Signals
) -> tuple[Scalar, tuple[Scalar, ...], None]:
    """Return the command, the velocities to remember, and no parts."""
    structure: Structure = law.structure
    fed = [gain * signals[x] for x, gain in zip(structure.signals, gains.signals, strict=True)]
    now = tuple(signals[name] for name, _ in structure.velocities)
    pairs = zip(structure.velocities, now, memory, strict=True)
    count = max(len(now), 1)
    changes = [factor / count * gains.change * (new - old) for (_, factor), new, old in pairs]
    largest, whole = structure.largest, total([gains.constant, *fed, *changes])
    bent = clipped(xp, whole, -largest, largest)
    return gains.kp * signals["error"] + gains.kd * signals["error_rate"] + bent, now, None


def between(
    rng: np.random.Generator, ends: tuple[float, float], shape: int | tuple[int, ...]
) -> Floats:
    """Return random numbers between two ends, uniform in their logarithms."""
    low, high = np.log(ends)
    return np.asarray(np.exp(rng.uniform(low, high, shape)))
