"""What a polish needs of a scenario: what is ranked, on which machines, with which derivatives."""

from itertools import product

import numpy as np

from hfc_design.controllers.genome import Population, taken
from hfc_design.core.numbers import Floats, Integers
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.verdict import Ensemble
from hfc_design.runs.problem import final_problem
from hfc_design.search.polish import Polishable, Quadratic
from hfc_design.simulation import population as simulate
from hfc_design.simulation.traces import RECORDED, Traces, motion_slopes

#: Doubles of an individual on a single machine, a millionth off: a lucky one has worse ones.
DOUBLES = 7
#: Of many machines a step tries the nominal one, some on which the design that it began with
#: passes with least to spare, and some at random; it is linearised on a few of these.
HARD, RANDOM, LINEARISED = 8, 7, 3
#: Individuals of a step on one machine and on many; with what there is they fill the lanes. Of
#: these so many are judged as the result is.
PROPOSED, JUDGED = (127, 63), (4, 2)
#: Residuals below a share of the largest one weigh no more; the share is drawn for every step
#: between these powers of ten, since what is stuck at one may go on at another.
SMALLEST = (-6.0, -2.0)


class PolishTask:
    """A scenario as what a polish of ``individual`` needs of it."""

    def __init__(self, scenario: Scenario, individual: Population):
        self._final = final_problem(scenario)
        self._parts = self._final.parts
        self._many = self._parts.machines.size > 1
        self._ensemble = self._parts.ensemble or Ensemble((1.0,))
        if self._many:
            self._hard = self._final.nearest_to_breaking(individual, HARD)

    @property
    def task(self) -> Polishable:
        """For the polish."""
        derived = self.quadratic if self._final.has_derivative else None
        sizes = (PROPOSED[self._many], JUDGED[self._many])
        return Polishable(self._final.genome, self.worth, self.screened, derived, *sizes)

    def worth(self, population: Population) -> Floats:
        """(n, 1) rank on all machines; on a single one (n, 2) its own and that of its worst double.

        The one place that says what a polish has to make better.
        """
        if self._many:  # every one on every machine: a bound by the best is the worth of another
            return self._final.rank_on(population, np.arange(self._parts.machines.size))[:, None]
        rank = self._final.rank_of_finalists(population)
        each = taken(population, np.repeat(np.arange(len(rank)), DOUBLES))
        doubles = self._final.genome.nudged(each, np.random.default_rng(0))
        lowest = self._final.rank_of_finalists(doubles).reshape(-1, DOUBLES).min(axis=1)
        return np.stack([rank, np.minimum(rank, lowest)], axis=1)

    def screened(self, population: Population, rng: np.random.Generator) -> Floats:
        """(n,) rank on some machines."""
        return self._final.rank_on(population, self._some(rng))

    def _some(self, rng: np.random.Generator) -> Integers:
        if not self._many:
            return np.zeros(1, int)
        drawn = 1 + rng.permutation(self._parts.machines.size - 1)[:RANDOM]
        return np.unique(np.concatenate([[0], self._hard, drawn]))

    def quadratic(self, individual: Population, rng: np.random.Generator) -> Quadratic | None:
        """Normal equations of the cost of all motions of a few machines about a population of one.

        None where a motion or its derivative is not finite, or nothing weighs.
        """
        smallest = 10.0 ** rng.uniform(*SMALLEST)
        machines = np.append(0, rng.permutation(self._some(rng)[1:])[: LINEARISED - 1])
        shares = self._ensemble.shares(self._parts.machines.size)
        total: Quadratic | None = None
        for machine, motion in product(machines, range(len(self._parts.motions))):
            if not shares[machine, motion]:
                continue
            found = self._of_motion(individual, int(machine), motion, smallest)
            if found is None:
                return None
            own = Quadratic(*(shares[machine, motion] * x for x in found))
            total = own if total is None else Quadratic(*map(np.add, total, own))
        return total

    def _of_motion(
        self, individual: Population, machine: int, motion: int, smallest: float
    ) -> Quadratic | None:
        """Iteratively reweighted least squares: a residual weighs as much as the cost follows it.

        Steps of encoders and converters are left out: their derivative is 0, so that the loop
        would look open.
        """
        loop, machines, motions, _ = self._parts
        loop, own = loop.smooth, machines.take(np.array([machine]))
        samples, gains = motions[motion], self._final.genome.gains(individual)
        precision = np.float32 if self._many else np.float64
        found = simulate.jacobians(loop, own, samples, gains, RECORDED, precision)
        change = tuple(np.diff(x, axis=0, prepend=0.0 * x[:1]) for x in found["command"])
        residuals = [*found.values(), change]
        merit, slopes = motion_slopes(loop, samples, Traces(*(x for x, _ in residuals)))
        cost = -1.0 if merit <= 0.0 else -1.0 / merit**2
        size = residuals[0][1].shape[1]
        normal, downhill = np.zeros((2, size, size)), np.zeros(size)
        for (value, jacobian), slope in zip(residuals, slopes, strict=True):
            floor = max(smallest * np.abs(value).max(), np.finfo(float).tiny)
            weight = np.maximum(cost * slope * np.sign(value), 0.0)
            weight = weight / np.maximum(np.abs(value), floor)
            if not weight.any():
                continue
            # As if it were a square, and as if it could change its sign near 0 at no cost.
            bent = weight * value**2 / (value**2 + floor**2)
            ways = [jacobian.T @ (jacobian * one[:, None]) for one in (weight, bent)]
            normal = normal + np.stack(ways)
            downhill = downhill + jacobian.T @ (weight * value)
        finite = np.isfinite(normal).all() and np.isfinite(downhill).all()
        return Quadratic(normal, downhill) if finite and downhill.any() else None
