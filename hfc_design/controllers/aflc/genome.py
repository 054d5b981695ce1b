"""Genome of an adaptive fuzzy controller: that of an flc, plus bounds of the adaptation."""

import numpy as np

from hfc_design.controllers.aflc.law import AdaptiveGains, Rates
from hfc_design.controllers.flc import genome as flc
from hfc_design.core.numbers import Floats, Json


class AflcGenome(flc.FuzzyGenome):
    """Operations of a search on ``FuzzyTables`` that adapt."""

    def gains(self, population: flc.FuzzyTables) -> AdaptiveGains:
        """Return the gains of the population for the simulator."""
        steps = (np.full(len(population.tree), step) for step in self.start.law_gains().rates[:3])
        rates = Rates(*steps, *self.overlaps(population).T)
        return AdaptiveGains(super().gains(population), rates, self.sectors(population.share))

    def record(self, individual: flc.FuzzyTables) -> Json:
        """Return the record of kind ``aflc``: the start with the searched values replaced."""
        record = super().record(individual)
        sectors = self.sectors(individual.share)
        limits = {key: float(limit[0]) for key, limit in sectors._asdict().items()}
        error, change = self.overlaps(individual)[0].tolist()
        least = {"error": error, "error_change": change}
        record["adaptation"] |= {"stable_range": limits, "smallest_overlap": least}
        return record

    def smallest_gap(self) -> Floats:
        """Return the smallest distances (2,) of centres: two steps of the adaptation, or more."""
        rates = self.start.adaptation
        return np.maximum(super().smallest_gap(), (2.0 * rates.k_a, 2.0 * rates.k_b))

    def overlaps(self, population: flc.FuzzyTables) -> Floats:
        """Return the smallest overlaps (n, 2) of error terms and of change terms [BLU]."""
        overlaps = []
        for side, terms in enumerate(self.triangles(population.joints)):
            distance, left, right = np.moveaxis(population.joints[:, self.side == side], -1, 0)
            # Rounding must not make an overlap larger than the distance of two centres.
            whole = np.diff(terms[:, 1], axis=0).min(axis=0)
            overlaps.append(np.minimum(((right - left) * distance).min(axis=-1), whole))
        return np.stack(overlaps, axis=-1)
