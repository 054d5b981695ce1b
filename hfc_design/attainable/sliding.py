"""Bounds of friction from the speed: a spindle that moves one way is not pushed on by its friction.

A motion is either no better than the known one, or its errors have a smaller sum. For the latter a
linear programme finds the least momentum at a sample, and its multipliers prove it. Where the speed
is proven to have one sign, the bristles follow: ``dz/dt >= omega (1 - sigma_0 z / T_c)`` where it
is positive (LL eq. 1f, 1g), so that they stop pushing the spindle, and soon brake it.
"""

from typing import NamedTuple

import numpy as np

from hfc_design.attainable.certificate import Bounds, certified
from hfc_design.attainable.linear_model import MOMENTUM, LinearModel, Sampled
from hfc_design.attainable.linear_program import LinearProgram
from hfc_design.attainable.reachable import Reachable
from hfc_design.core.numbers import Floats


class Case(NamedTuple):
    """Motions whose sum of errors is less than a budget."""

    machine: LinearModel
    one: Sampled
    moved: Floats  # (steps + 1, 5) states without voltage and bristles
    errors: Floats  # (steps,) of these states, at the end of each sample
    reachable: Reachable
    bounds: Bounds
    budget: float
    start: float = 0.0  # initial deflection of the bristles [rad]

    def first(self, steps: int) -> "Case":
        """Return the first ``steps`` samples."""
        reached = Reachable(*(x[:steps] for x in self.reachable))
        moved, bounds = self.moved[: steps + 1], Bounds(*(x[:steps] for x in self.bounds))
        errors = self.errors[:steps]
        return self._replace(moved=moved, errors=errors, reachable=reached, bounds=bounds)


def slowest(case: Case, solver: LinearProgram, step: int, sign: float) -> float:
    """Return a lower bound of ``sign`` times the momentum after ``step`` samples; -inf: unknown."""
    solution = solver.least_state(MOMENTUM, step, sign, case.budget)
    if solution is None or not solution.budget > 0.0:
        return -np.inf
    multipliers = np.clip(solution.multipliers, -solution.budget, solution.budget)
    momentum = np.zeros(len(case.errors))
    momentum[step - 1] = sign
    proof = certified(case.machine, case.one, case.errors, multipliers, case.bounds, momentum)
    return sign * case.moved[step, MOMENTUM] + proof.bound - solution.budget * case.budget


def speeds(
    case: Case, solver: LinearProgram, steps: list[int], signs: Floats
) -> tuple[Floats, Floats]:
    """Return bounds of the spindle's speed in each sample, lowest and highest, (samples,) [rad/s].

    They are computed at ``steps``: the lowest where ``signs`` is positive, otherwise the highest.
    Between two of these the momentum differs from the line through both by at most a bound that
    depends on its second derivative.
    """
    machine, reached = case.machine, case.reachable.speed
    low, high = -reached, reached.copy()
    least = [slowest(case, solver, step, sign) for step, sign in zip(steps, signs, strict=True)]
    for k in range(len(steps) - 1):
        part, sign = slice(steps[k], steps[k + 1]), signs[k]
        if sign != signs[k + 1]:
            continue
        time = (steps[k + 1] - steps[k]) * case.one.time
        momentum = min(least[k], least[k + 1]) - time**2 / 8.0 * case.reachable.bending[part].max()
        bent = case.bounds.high[part] if sign > 0 else -case.bounds.low[part]
        speed = (momentum - machine.damping * bent.max()) / machine.inertia
        if sign > 0:
            low[part] = np.maximum(low[part], speed)
        else:
            high[part] = np.minimum(high[part], -speed)
    return low, high


def bent(case: Case, low: Floats, high: Floats) -> Bounds:
    """Return bounds of the bristles in each sample, for speeds between ``low`` and ``high``."""
    below = _lowest(case, low, high, case.start)
    above = -_lowest(case, -high, -low, -case.start)
    lowest, highest = np.maximum(case.bounds.low, below), np.minimum(case.bounds.high, above)
    return Bounds(case.bounds.voltage, lowest, highest)


def _lowest(case: Case, low: Floats, high: Floats, start: float) -> Floats:
    """Return the lowest deflection in each sample, (samples,), for speeds ``low`` to ``high``."""
    machine, z, time = case.machine, start, case.one.time
    lowest = np.empty(len(low))
    for k in range(len(low)):
        before, back = z, -machine.steady(high[k])
        if low[k] > 0.0 and z < 0.0:
            z = min(z + time * low[k], 0.0)
        elif low[k] > 0.0:
            z = max(z, _relaxed(z, machine.sliding, time * low[k]))
        elif high[k] < 0.0 and z < back:
            z = _relaxed(z, back, -time * high[k])
        else:
            z = min(z, 0.0) + time * low[k]
            z = max(z, back) if high[k] < 0.0 else z
        z = max(z, -case.reachable.bristles[k])
        lowest[k] = min(before, z)
    return lowest


def _relaxed(z: float, steady: float, way: float) -> float:
    """Return the deflection after a ``way`` that bends bristles from ``z`` towards ``steady``."""
    return steady + (z - steady) * float(np.exp(-way / abs(steady)))
