"""Proof by multipliers: a lower bound of sum |e|, with rounding included.

For any multipliers ``l(k)`` within +-1, ``sum |e(k)| >= sum l(k) e(k)``. The right side is linear
in voltage and bristles. Its least value is found sample by sample: the voltage is at a limit, and
the bristles are at one of their bounds. How the multipliers were found does not matter.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from hfc_design.attainable.linear_model import ANGLE, MOMENTUM, STATES, LinearModel, Sampled
from hfc_design.core.numbers import Floats

#: Rounding error of one operation on float64.
ROUNDING = float(np.finfo(np.float64).eps)

#: Least weight of a state as a share of the largest weight.
LEAST_SIZE = 1e-9


class Bounds(NamedTuple):
    """Bounds in each sample, all (steps,)."""

    voltage: Floats  # largest magnitude [V]
    low: Floats  # of the bristles' deflection, anywhere within the sample [rad]
    high: Floats


class Certified(NamedTuple):
    """A lower bound and its parts [rad]."""

    bound: float  # with both allowances already subtracted
    rounding: float  # allowance for float64
    between: float  # allowance for what the bristles do within a sample


def certified(
    machine: LinearModel,
    one: Sampled,
    errors: Floats,
    multipliers: Floats,
    bounds: Bounds,
    momentum: Floats | None = None,
) -> Certified:
    """Return a lower bound of ``sum l(k) e(k) + sum m(k) p(k)``, k = 1 ... steps, of all motions.

    These are within ``bounds``. ``multipliers`` is l (steps,); within +-1, and without m, it makes
    a bound of ``sum |e(k)|``. ``errors`` (steps,) are without voltage and bristles. ``momentum`` is
    m (steps,) [rad / (N m s)], for the part of the momentum p that voltage and bristles cause.
    """
    duals = np.nan_to_num(multipliers)
    back = _adjoint(one, duals, momentum)
    gain = back @ one.voltage
    pushed = np.abs(gain) * bounds.voltage
    starts, ends = back @ (one.a @ machine.bristle), back @ machine.bristle
    # Largest reduction of the sum by the bristles at a moment: effect of a radian times a bound.
    worst = [np.maximum(x * bounds.low, x * bounds.high) for x in (starts, ends)]
    bent = 0.5 * one.time * (worst[0] + worst[1])
    between = _between(machine, one, back, bounds)
    value = float(duals @ errors - pushed.sum() - bent.sum())
    rounding = _rounding(machine, one, back, float(np.abs(duals) @ np.abs(errors)), bounds)
    return Certified(value - between - rounding, rounding, between)


def _adjoint(one: Sampled, multipliers: Floats, momentum: Floats | None) -> Floats:
    """Return how much a unit of each state at the end of a sample reduces the sum, (steps, 5)."""
    back = np.empty((len(multipliers), STATES))
    x = np.zeros(STATES)
    for k in range(len(multipliers) - 1, -1, -1):
        x = x @ one.a
        x[ANGLE] += multipliers[k]
        if momentum is not None:
            x[MOMENTUM] -= momentum[k]
        back[k] = x
    return back


def _between(machine: LinearModel, one: Sampled, back: Floats, bounds: Bounds) -> float:
    """Return a bound of the error of the trapezoidal rule for the contribution of the bristles.

    The contribution is a convex function of its density in time. The density differs from the line
    through its ends by at most ``h^2/8`` times its largest second derivative, its mean by two
    thirds of that.
    """
    curved = np.abs(back @ machine.a @ machine.a)
    largest = curved @ (expm(np.abs(machine.a) * one.time) @ np.abs(machine.bristle))
    deflections = np.maximum(np.abs(bounds.low), np.abs(bounds.high))
    return float(one.time**3 / 12.0 * (largest @ deflections))


def _rounding(
    machine: LinearModel, one: Sampled, back: Floats, given: float, bounds: Bounds
) -> float:
    """Return a bound of rounding errors of float64; exponentials are exact to a few last digits.

    It uses coordinates in which the powers of the machine's matrix amplify little. The rounding
    error of a step then grows at most by the largest of these powers.
    """
    size = np.abs(back).max(axis=0)
    if not size.any():
        return 0.0  # every multiplier is zero, and nothing was added
    size = np.maximum(size, LEAST_SIZE * size.max())
    a = one.a.T * size / size[:, None]  # matrix of the adjoint, in units of its largest values
    power, growth = np.eye(STATES), 1.0
    for _ in range(len(back)):
        power = a @ power
        growth = max(growth, float(np.linalg.norm(power, np.inf)))
    each = 64.0 * ROUNDING * growth * (float(np.linalg.norm(np.abs(a), np.inf)) + 1.0)
    off = len(back) * each * size  # error of every adjoint
    deflection_sum = np.maximum(np.abs(bounds.low), np.abs(bounds.high)).sum()
    by_voltage = float(off @ np.abs(one.voltage)) * bounds.voltage.sum()
    density = np.abs(machine.bristle) + np.abs(one.a @ machine.bristle)
    by_bristles = float(off @ density) * one.time * deflection_sum
    total = given + float(np.abs(back @ one.voltage) @ bounds.voltage)
    total += one.time * deflection_sum * float((np.abs(back) @ density).max())
    return by_voltage + by_bristles + len(back) * 64.0 * ROUNDING * total
