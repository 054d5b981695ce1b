"""Compensation of the tracking errors of a machine, added to any controller (Lin & Gai 2009)."""

import numpy as np

from hfc_design.controllers.dynamic_compensation.law import CompensationGains
from hfc_design.controllers.dynamic_compensation.record import (
    CompensationDesign,
    CompensationSettings,
)
from hfc_design.controllers.gains.genome import GainsGenome
from hfc_design.controllers.kind import Target
from hfc_design.controllers.product_genome import ProductPopulation, WrapperGenome
from hfc_design.core.numbers import Json


class CompensationGenome(WrapperGenome):
    """Genome: that of the inner controllers, and of factors on the settings of the compensation."""

    def __init__(self, settings: CompensationSettings, target: Target):
        super().__init__(settings, target, GainsGenome(settings, target))

    def gains(self, population: ProductPopulation) -> CompensationGains:
        """Return the gains of the population for the simulator."""
        inner, shares = self.each("gains", population.parts)
        settings = self.settings
        k_p = tuple(np.stack([gain * shares.k_p for gain in settings.k_p.values()]))
        speed = np.full(len(population.tree), settings.programmed_speed)
        return CompensationGains(inner, k_p, settings.dead_zone * shares.dead_zone, speed)

    def record(self, individual: ProductPopulation) -> Json:
        """Return a record of the inner controllers and of the gains of the compensation."""
        gains, settings = self.gains(individual), self.settings
        pairs = zip(settings.k_p, gains.k_p, strict=True)
        return {
            "kind": settings.kind,
            "inner": self.parts[0].record(individual.parts[0]),
            "k_p": {axis: float(gain[0]) for axis, gain in pairs},
            "dead_zone": float(gains.dead_zone[0]),
            "programmed_speed": settings.programmed_speed,
            "path_axes": list(settings.path_axes),
        }


KIND = CompensationDesign
