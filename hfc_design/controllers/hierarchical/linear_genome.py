"""Genome of a fuzzy hierarchy that is added to a linear part; a search has three stages.

The first stage varies the weights of an optimal regulator (``linear.lq_genome``), so that every
individual is a sound linear controller. The second varies the gains of this regulator. Until then
the output of the hierarchy is 0. The third varies the tables as well.
"""

from typing import NamedTuple

import numpy as np

from hfc_design.controllers.gains.genome import STEP
from hfc_design.controllers.genome import Genome, Stage, some, taken
from hfc_design.controllers.hierarchical.genome import HierarchicalGenome, Hierarchies
from hfc_design.controllers.hierarchical.law import HierarchicalGains
from hfc_design.controllers.hierarchical.linear_tables import passthrough
from hfc_design.controllers.hierarchical.record import HierarchicalSettings
from hfc_design.controllers.kind import Target
from hfc_design.controllers.linear.law import LinearGains
from hfc_design.controllers.linear.lq_genome import LqGenome
from hfc_design.controllers.linear.record import filters_of
from hfc_design.core.numbers import Floats, Integers, Json
from hfc_design.core.records import UserError

#: Initial standard deviations in the second stage (of logarithms of gains) and in the third.
FREE, EVERYTHING = 0.15, 0.02
#: Logarithm of the largest factor by which a gain may grow or shrink in a stage.
FAR = 4.0
FORWARD = ("velocity", "acceleration", "coulomb", "width", "load")
#: Smallest Coulomb width after blending, in shares of the smaller of two: it must stay above 0.
NARROWEST = 0.01


class LinearHierarchies(NamedTuple):
    """Population of n individuals; the first axis of every array counts the individuals."""

    tree: Integers  # (n,) index into ``HierarchicalGenome.trees``
    #: (n, 1 + signals + 2 x resonators + filters + forward): ki, gains on signals, two gains of
    #: each resonator, numbers of filters, feed-forward gains.
    linear: Floats
    fuzzy: Hierarchies  # hierarchies, with kp and kd


class LinearHierarchyGenome(Genome):
    """Operations of a search on ``LinearHierarchies``."""

    stages = ((0.25, False), (0.25, False), (0.5, True))

    def __init__(self, settings: HierarchicalSettings, target: Target):
        super().__init__(settings, target)
        assert settings.linear is not None
        self.fuzzy = HierarchicalGenome(settings, target)
        try:
            self.regulator = LqGenome(settings.linear, target)
        except UserError as error:
            raise UserError(error.message.replace("controller.", "controller.linear.", 1)) from None
        self.forward = FORWARD if settings.linear.expected_load else FORWARD[:-1]
        self.filters = settings.linear.filters
        turning = 2 * len(settings.linear.resonators)
        #: Ends of the parts of ``LinearHierarchies.linear``.
        self.ends = np.cumsum([1, len(self.regulator.signals), turning, len(self.filters)])
        self.structures = self.fuzzy.structures
        self.idle = _idle(settings, self.fuzzy.units)

    def empty(self) -> LinearHierarchies:
        """Return one individual for each tree, in their order, with the regulator to start from."""
        trees = np.arange(self.structures)
        return self.regulated(np.repeat(self.regulator.empty().places, len(trees), axis=0), trees)

    def fresh(self, tree: Integers, rng: np.random.Generator) -> LinearHierarchies:
        """Return regulators of random weights, with hierarchies that change commands a little."""
        first = self.regulator.fresh(np.zeros(len(tree), int), rng)
        hierarchies = self.regulated(first.places, tree)
        bent = self.fuzzy.mutated(hierarchies.fuzzy, np.full(len(tree), EVERYTHING), rng)
        return hierarchies._replace(fuzzy=bent)

    def mutated(
        self, population: LinearHierarchies, step: Floats, rng: np.random.Generator
    ) -> LinearHierarchies:
        """Multiply some gains by factors; mutate the hierarchy as ``HierarchicalGenome`` does."""
        factors = np.exp(0.5 * step[:, None] * some(rng, population.linear.shape, 0.5))
        fuzzy = self.fuzzy.mutated(population.fuzzy, step, rng)
        return population._replace(linear=population.linear * factors, fuzzy=fuzzy)

    def blended(
        self, one: LinearHierarchies, other: LinearHierarchies, share: Floats
    ) -> LinearHierarchies:
        """Interpolate gains linearly, as some change sign, the rest as ``HierarchicalGenome``."""

        def mixed(a: Floats, b: Floats) -> Floats:
            return np.asarray(a + share[:, None] * (b - a))

        with np.errstate(all="ignore"):  # of logarithms of kp and kd, replaced below
            fuzzy = self.fuzzy.blended(one.fuzzy, other.fuzzy, share)
        fuzzy = fuzzy._replace(gains=mixed(one.fuzzy.gains, other.fuzzy.gains))
        linear = mixed(one.linear, other.linear)
        width = self.ends[-1] + self.forward.index("width")
        narrower = np.minimum(one.linear[:, width], other.linear[:, width])
        linear[:, width] = np.maximum(linear[:, width], NARROWEST * narrower)
        return LinearHierarchies(one.tree, linear, fuzzy)

    def nudged(self, population: LinearHierarchies, rng: np.random.Generator) -> LinearHierarchies:
        """Change kp and kd by about a millionth."""
        return population._replace(fuzzy=self.fuzzy.nudged(population.fuzzy, rng))

    def stage(self, number: int, about: LinearHierarchies | None) -> Stage:
        """Return stage 0 (weights), 1 (gains) or 2 (gains, scales and tables), near ``about``."""
        if number == 0 or about is None:
            return Stage(self.regulator.empty().places[0], STEP, self.regulated)
        around, gains, everything = about, 2 + about.linear.shape[1], number > 1

        def members(points: Floats, tree: Integers) -> LinearHierarchies:
            return self.moved(around, tree, points, points[:, gains:] if everything else None)

        if not everything:
            return Stage(np.zeros(gains), FREE, members)
        further = about.fuzzy.scales[0].size + about.fuzzy.consequents[0].size
        return Stage(np.zeros(gains + further), EVERYTHING, members)

    def gains(self, population: LinearHierarchies) -> HierarchicalGains:
        """Return the gains of the population for ``simulate``."""
        gains = self.fuzzy.gains(population.fuzzy)
        (ki,), signals, turning, _, ahead = np.split(population.linear.T, self.ends)
        nothing = np.zeros(len(population.tree))
        forward = dict(zip(self.forward, ahead, strict=True))
        linear_gains = LinearGains(
            kp=gains.kp,
            ki=ki,
            kd=gains.kd,
            filter_pole=nothing,
            signals=signals if len(signals) else None,
            resonators=turning.reshape(-1, 2, len(ki)) if len(turning) else (),
            filters=tuple(filters_of(self._filters(population), self.regulator.every).values()),
            **{"load": nothing, **forward},
        )
        return gains._replace(linear=linear_gains)

    def notation(self, structure: int) -> str:
        """Return the text of the hierarchy's tree: nested pairs (column input, row input)."""
        return self.fuzzy.notation(structure)

    def record(self, individual: LinearHierarchies) -> Json:
        """Return the ``pd+hierarchical-fuzzy`` record with linear part, without sample time."""
        gains = self.gains(individual).linear
        assert gains is not None
        record = {name: float(x[0]) for name, x in self._filters(individual).items()}
        linear = {"linear": self.regulator.linear_record(gains)}
        return self.fuzzy.record(individual.fuzzy) | record | linear

    def _filters(self, population: LinearHierarchies) -> dict[str, Floats]:
        each = zip(self.filters, np.split(population.linear.T, self.ends)[3], strict=True)
        ranges = self.regulator.searched
        return {name: np.clip(x, ranges[name].low, ranges[name].high) for name, x in each}

    def regulated(self, places: Floats, tree: Integers) -> LinearHierarchies:
        """Return regulators with weights at ``places`` (n, weights), with hierarchies giving 0."""
        count = len(places)
        first = taken(self.regulator.empty(), np.zeros(count, int))
        first = first._replace(places=np.clip(places, 0.0, 1.0))
        gains, values = self.regulator.gains(first), self.regulator.values(first)
        signals = [] if gains.signals is None else [*gains.signals]
        turning = [gain for pair in gains.resonators for gain in pair]
        filters = (values[name] for name in self.filters)
        ahead = (getattr(gains, name) for name in self.forward)
        columns = [gains.ki, *signals, *turning, *filters, *ahead]
        fuzzy = Hierarchies(
            tree,
            np.stack([gains.kp, gains.kd], axis=1),
            np.tile(self.fuzzy.scales, (count, 1)),
            np.tile(self.idle, (count, 1, 1, 1)),
        )
        return LinearHierarchies(tree, np.stack(columns, axis=1), fuzzy)

    def moved(
        self, about: LinearHierarchies, tree: Integers, gains: Floats, further: Floats | None
    ) -> LinearHierarchies:
        """Return ``about``, gains times exp(``gains``), scales and tables moved by ``further``."""
        count, linear = len(gains), about.linear.shape[1]
        factors = np.exp(np.clip(gains[:, : 2 + linear], -FAR, FAR))
        fuzzy = taken(about.fuzzy, np.zeros(count, int))
        fuzzy = fuzzy._replace(tree=tree, gains=fuzzy.gains * factors[:, :2])
        if further is not None:
            inputs = fuzzy.scales.shape[1]
            scales = fuzzy.scales * np.exp(np.clip(further[:, :inputs], -FAR, FAR))
            tables = fuzzy.consequents + further[:, inputs:].reshape(fuzzy.consequents.shape)
            limit = self.fuzzy.limit
            fuzzy = fuzzy._replace(scales=scales, consequents=np.clip(tables, -limit, limit))
        return LinearHierarchies(tree, about.linear[:1] * factors[:, 2:], fuzzy)


def _idle(settings: HierarchicalSettings, units: int) -> Floats:
    """Return tables (units, 7, 7): inner units give the mean of their inputs, the root gives 0."""
    levels = passthrough(settings)
    inner = 0.5 * levels + 0.5 * levels[:, None]
    return np.stack([*([inner] * (units - 1)), np.zeros_like(inner)])
