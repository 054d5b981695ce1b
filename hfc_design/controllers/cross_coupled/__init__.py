"""Cross-coupled control: axis controllers of any kind and one contour controller (Koren 1980)."""

from collections import namedtuple

import numpy as np

from hfc_design.controllers.cross_coupled.law import CrossGains
from hfc_design.controllers.cross_coupled.record import CrossCoupledDesign, CrossCoupledSettings
from hfc_design.controllers.gains.genome import GainsGenome
from hfc_design.controllers.kind import Target
from hfc_design.controllers.product_genome import ProductPopulation, WrapperGenome
from hfc_design.core.numbers import Json


class _OwnGenome(GainsGenome):
    """Genome of the gains on the contour error and of the feed-forward gain of each axis."""

    def __init__(self, settings: CrossCoupledSettings, target: Target):
        super().__init__(settings, target)
        ranges = settings.searched()._asdict()
        velocity = ranges.pop("velocity")
        ranges |= {f"velocity_{axis}": velocity for axis in target.machine.axes}
        self.ranges = namedtuple("Ranges", ranges)(**ranges)


class CrossCoupledGenome(WrapperGenome):
    """Genome of a cross-coupled controller: that of the inner controllers, and of its own gains."""

    def __init__(self, settings: CrossCoupledSettings, target: Target):
        super().__init__(settings, target, _OwnGenome(settings, target))

    def gains(self, population: ProductPopulation) -> CrossGains:
        """Return the gains of the population for the simulator."""
        inner, contour_gains = self.each("gains", population.parts)
        k_p, k_i, k_d, *velocity = contour_gains
        return CrossGains(inner, k_p, k_i, k_d, tuple(np.stack(velocity)))

    def record(self, individual: ProductPopulation) -> Json:
        """Return a record of the inner controllers and of the contour and feed-forward gains."""
        inner, contour_genome = self.parts
        contour_gains = contour_genome.gains(individual.parts[1])
        k_p, k_i, k_d, *velocity = (float(gain[0]) for gain in contour_gains)
        return {
            "kind": self.settings.kind,
            "inner": inner.record(individual.parts[0]),
            "contour": {"k_p": k_p, "k_i": k_i, "k_d": k_d},
            "feed_forward": dict(zip(self.target.machine.axes, velocity, strict=True)),
        }


KIND = CrossCoupledDesign
