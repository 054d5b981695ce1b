"""Genome of adaptive fuzzy sliding control: eight numbers, and optionally the consequents."""

from typing import Any

import numpy as np

from hfc_design.controllers.fuzzy_sliding.law import Pid, SlidingGains
from hfc_design.controllers.fuzzy_sliding.record import SEARCHED, SlidingSettings, started
from hfc_design.controllers.gains.genome import GainsGenome, GainVectors, Searched
from hfc_design.controllers.genome import Genome
from hfc_design.controllers.kind import Target
from hfc_design.core.numbers import Floats, Integers, Json
from hfc_design.core.records import TERMS, ZR

#: Standard deviation of first consequents about those of the start, as a share of their range.
SPREAD = 0.1
#: Number of searched consequents of a symmetric table; the other ones follow by symmetry.
HALF = TERMS * TERMS // 2


class SlidingGenome(GainsGenome):
    """Operations of a search on ``GainVectors``: those of ``searched`` first, then consequents."""

    def __init__(self, settings: SlidingSettings, target: Target):
        Genome.__init__(self, settings, target)
        self.start = settings.start or started(target)
        height = float(np.abs(self.start.table()).max()) or 1.0
        about = {"largest_consequent": height, **dict(self.start)}
        about |= {**dict(self.start.sliding), **dict(self.start.adaptation)}
        self.searched = {}
        for name, factor in SEARCHED.items():
            first = about[name]
            low, high = settings.ranges.get(name) or (first / factor, first * factor)
            self.searched[name] = Searched(low, high, float(np.clip(first, low, high)))
        #: Consequents (7, 7) of the start, divided by the largest magnitude.
        self.shape: Floats = np.array(self.start.table()) / height
        count = 0 if not settings.consequents else HALF if settings.symmetric else TERMS * TERMS
        self.ranges = (*self.searched, *range(count))  # one element for each searched number

    def empty(self) -> GainVectors:
        """Return one individual, the start."""
        places = [float(one.place(one.start)) for one in self.searched.values()]
        table = 0.5 * (1.0 + self.shape.ravel()[: len(self.ranges) - len(places)])
        return GainVectors(np.zeros(1, int), np.array([[*places, *table]]))

    def fresh(self, tree: Integers, rng: np.random.Generator) -> GainVectors:
        """Return individuals: the start, then points between the start and random ones."""
        count, few = len(tree), len(self.searched)
        places = np.tile(self.empty().places, (count, 1))
        near = rng.random((count, 1))  # share of the way from the start to a random point
        near[:1] = 0.0
        off = rng.random((count, few)) - places[:, :few]
        noise = SPREAD * rng.standard_normal(places[:, few:].shape)
        places += near * np.concatenate([off, noise], axis=1)
        return GainVectors(tree, np.clip(places, 0.0, 1.0))

    def consequents(self, population: GainVectors) -> Floats:
        """Return the initial consequents (7, 7, n) [command]."""
        height = self.values(population)["largest_consequent"]
        shares = 2.0 * population.places[:, len(self.searched) :].T - 1.0
        if len(shares) == HALF:
            shares = np.concatenate([shares, np.zeros((1, len(height))), -shares[::-1]])
        if len(shares) == 0:
            shares = np.repeat(self.shape.reshape(-1, 1), len(height), axis=1)
        return height * shares.reshape(TERMS, TERMS, -1)

    def gains(self, population: GainVectors) -> SlidingGains:
        """Return the gains of the population for the simulator."""
        numbers, one = self.values(population), np.ones(len(population.tree))
        of_error: Any
        of_error, of_rate = self.start.judge()
        if self.start.adaptation.error_dynamics is None:
            of_error = numbers["slope"]
        consequents: Any = self.consequents(population)
        judge: Any = np.stack([of_error * one, of_rate * one])
        pid = self.start.pid
        return SlidingGains(
            ZR / numbers["largest_error"],
            ZR / numbers["largest_error_rate"],
            consequents,
            numbers["slope"],
            numbers["gain"],
            numbers["boundary_layer"],
            numbers["rate"],
            judge,
            numbers["largest_move"],
            Pid(*(one * gain for gain in dict(pid).values())) if pid else None,
        )

    def record(self, individual: GainVectors) -> Json:
        """Return the start's record with the searched values; no learned moves, no sample time."""
        numbers = {name: float(value[0]) for name, value in self.values(individual).items()}
        record: Json = self.start.model_dump()
        for key in ("largest_error", "largest_error_rate"):
            record[key] = numbers[key]
        for part in ("sliding", "adaptation"):
            record[part] |= {key: numbers[key] for key in record[part] if key in numbers}
        record["adaptation"].pop("moves", None)
        record["consequents"] = self.consequents(individual)[..., 0].tolist()
        del record["sample_time_s"]
        return record
