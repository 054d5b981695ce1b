"""Genome of a fuzzy controller that adapts: that of the flc, and the rectangle it may not leave."""

from functools import partial
from typing import Any

import numpy as np

from hfc_design.controllers.aflc.law import AdaptiveGains, Rates, aflc
from hfc_design.controllers.aflc.record import AflcSettings
from hfc_design.controllers.controller import Controller
from hfc_design.controllers.flc import genome as flc
from hfc_design.controllers.flc.genome import FuzzyGenome, FuzzyTables, alike
from hfc_design.controllers.kind import Target, per_axis
from hfc_design.core.shapes import Floats


class AflcGenome(FuzzyGenome):
    """What a search can do with ``FuzzyTables`` that adapt."""

    @property
    def controller(self) -> Controller:
        """The adaptive controller."""
        return per_axis(self.start.kind, partial(aflc, self.start.sample_time_s), self.target)

    def gains(self, population: FuzzyTables) -> AdaptiveGains:
        """The population as the simulator wants it."""
        steps = alike(tuple(self.start.gains().rates[:3]), len(population.tree))
        rates = Rates(*steps, *_overlaps(population).T)
        return AdaptiveGains(super().gains(population), rates, self.sectors(population.share))

    def record(self, individual: FuzzyTables) -> dict[str, Any]:
        """Kind ``aflc``: as the start but for what was searched."""
        record = super().record(individual)
        sectors = self.sectors(individual.share)
        limits = {"k1_max": float(sectors.k1_max[0]), "k2_max": float(sectors.k2_max[0])}
        error, change = _overlaps(individual)[0].tolist()
        record["adaptation"]["stable_range"] = limits
        record["adaptation"]["smallest_overlap"] = {"error": error, "error_change": change}
        return record

    def smallest_gap(self) -> Floats:
        """(2,) with room for the steps of the adaptation."""
        rates = self.start.adaptation
        return np.maximum(super().smallest_gap(), (2.0 * rates.k_a, 2.0 * rates.k_b))


def genome_of(settings: AflcSettings, target: Target) -> FuzzyGenome:
    """The genome of the scenario's adaptive controller."""
    return flc.genome_of(settings, target, AflcGenome)


def _overlaps(population: FuzzyTables) -> Floats:
    """(n, 2) the least that two neighbours overlap [BLU]; adapting terms keep to it."""
    distance, left, right = np.moveaxis(population.joints, -1, 0)
    return np.asarray(((right - left) * distance).min(axis=-1))
