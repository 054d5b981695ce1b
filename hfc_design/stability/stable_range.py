"""Gains that keep a sampled feed drive under fuzzy control stable: JK04 section 3, eq. 18-22.

JK split the command into u_1(e), inside the sector [0, K_1], and u_2(e, de), inside [0, K_2],
and apply Jury and Lee's theorem without a multiplier. Multiplied out from G(z) of eq. 19, their
g_3..g_0 of eq. 22 come out as printed, but in eq. 21, h_1 and h_0 the real part of G needs
(1 - a)(1 + b) x where (1 + a)(1 - b) x is printed. The difference is not small. The printed
range goes beyond what a linear controller can do; by the right sign the theorem allows K_1 up
to ``k1_theorem`` and no K_2 above 0 at all, because the integrator makes |G| grow without bound
towards z = 1 and condition (ii) cannot hold there.

``StableRange`` therefore is the published range, to which JK's adaptation keeps, cut off where the
linear loop becomes unstable (for T/tau below about 0.9 this bound is the smaller one). It is a
design rule, no proof: in the last percent of K_1 a K_2 that changes with the state can still make
the loop unstable. For smaller K_1 no such table was found for JK's drive.

Everything depends on K_0 K_1, K_0 K_2 and T/tau only. The polynomials are written in
y = 1 - x = 1 - cos(omega T), from 0 to 2, because they almost vanish near x = 1.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike
from scipy.special import hyp1f1

from hfc_design.core.numbers import Floats, within
from hfc_design.core.records import UserError
from hfc_design.stability.sectors import stationary

#: Allowed T/tau: slower sampling sees no dynamics, faster sampling is continuous control.
RATIO = (1e-3, 50.0)
#: Allowed gain times sample time [BLU/unit], far beyond every drive.
TRAVEL = (1e-12, 1e12)
Y_END = 2.0


class StableRange(NamedTuple):
    """JK04 fig. 4 for one drive, cut off at the linear limit. Gains in unit/BLU.

    G(z) = k0 (z + a)/((z - 1)(z - b)) is the drive behind its zero-order hold (JK04 eq. 19).
    """

    k0: float  # K_0 [BLU/unit]
    a: float  # [1]; 0 < b < a < 1
    b: float  # [1]
    k1_bound: float  # every K_1 of the range is smaller than this
    k1_printed: float  # below it condition (i) holds as printed (JK04 eq. 21)
    k1_linear: float  # where the linear loop u = K_1 e becomes unstable
    k1_theorem: float  # what the theorem allows with the real part of G as it is, at K_2 = 0

    def k2_printed(self, k1: ArrayLike) -> Floats:
        """Return the K_2 below which condition (ii) holds as printed (JK04 eq. 22).

        ``k1`` is a number or an array; the result has the same shape, and is 0 where condition (i)
        does not hold. It falls with K_1: its value at the end of an interval is safe for all of it.
        """
        given = np.asarray(k1, dtype=np.float64)
        bounds = [_k2_bound(self, x) if 0.0 < x < self.k1_printed else 0.0 for x in given.flat]
        return np.array(bounds).reshape(given.shape)

    def k2(self, k1: ArrayLike) -> Floats:
        """Return the upper bound of K_2 in the range at ``k1``; 0 outside the range."""
        return np.where(np.asarray(k1) < self.k1_bound, self.k2_printed(k1), 0.0)

    def contains(self, k1: float, k2: float) -> bool:
        """True if sectors [0, k1] and [0, k2] lie in the range; false for nan and infinity."""
        return 0.0 <= k2 < float(self.k2(k1))


def stable_range(gain: float, time_constant: float, sample_time: float) -> StableRange:
    """Return the range of a drive K/(s (tau s + 1)) (JK04 eq. 18-20). It is never empty.

    ``gain`` is K in (BLU/s)/unit; ``time_constant`` tau and ``sample_time`` T are in s. JK04 prints
    K_0 as a quotient by 1/tau, which is a product with tau.

    Raises:
        UserError: a value is not positive and finite, T/tau or K T are out of range.
    """
    given = {"gain": gain, "time constant": time_constant, "sample time": sample_time}
    for name, value in given.items():
        if not (math.isfinite(value) and value > 0.0):
            raise UserError(f"{name} = {value}: must be a finite number greater than 0")
    ratio, travel = sample_time / time_constant, gain * sample_time
    for name, value, unit, (low, high) in (
        ("sample time / time constant", ratio, "", RATIO),
        ("gain * sample time", travel, " BLU/unit", TRAVEL),
    ):
        if not within(low, value, high):
            raise UserError(f"{name} = {value:g}{unit}: must be between {low:g} and {high:g}")
    # r - 1 + exp(-r) = r^2/2 M(1, 3, -r) and 1 - (1 + r) exp(-r) = r^2/2 M(2, 3, -r), without
    # the cancellation (Kummer's function M).
    lag = float(hyp1f1(1.0, 3.0, -ratio))
    zero = float(hyp1f1(2.0, 3.0, -ratio))
    k0, a, b = travel * ratio / 2.0 * lag, zero / lag, math.exp(-ratio)
    # The point x = 1 is a pole of the printed expression; its limit there is minus infinity.
    real, weight = _real_part(a, b), _weight(b)
    places = [*stationary(-real, weight, Y_END), Y_END]
    printed = float(1.0 / (k0 * max(-real(y) / weight(y) for y in places)))
    # The poles solve z^2 + (K_0 K_1 - 1 - b) z + b + a K_0 K_1 = 0 and meet the unit circle as a
    # pair, where the last coefficient is 1. No sector [0, K_1] can reach further.
    linear = (1.0 - b) / (a * k0)
    # With (1 - a)(1 + b) in eq. 21 the numerator vanishes at x = 1 too, the quotient is monotone
    # and largest there.
    theorem = 2.0 * (1.0 - b) ** 2 / (k0 * (1.0 + 3.0 * a + b - a * b))
    return StableRange(k0, a, b, min(printed, linear), printed, linear, theorem)


def _k2_bound(gain_range: StableRange, k1: float) -> float:
    """Return the least h/g over those y in [0, 2] where g is positive, as it always is at y = 0."""
    k0, a, b = gain_range[:3]
    kappa = k0 * k1
    h = 4.0 * (_weight(b) + kappa * _real_part(a, b))
    square = Polynomial([(1.0 + a) ** 2, -2.0 * a])  # |z + a|^2
    rest = Polynomial([0.0, (1.0 + a) * (1.0 - b), a * b - 1.0 - 4.0 * a, 2.0 * a])
    g = k0 * (kappa * square - 8.0 * rest)
    places = [0.0, *stationary(h, g, Y_END), Y_END]
    return float(min(h(y) / g(y) for y in places if g(y) > 0.0))


def _real_part(a: float, b: float) -> Polynomial:
    """Return the bracket of eq. 21 as printed, in y; with the corrected sign it is 0 at y = 0."""
    return Polynomial([2.0 * (a - b), -4.0 * a - (1.0 + a) * (1.0 - b), 2.0 * a])


def _weight(b: float) -> Polynomial:
    """Return |z - 1|^2 |z - b|^2 on the unit circle, in y: minus the denominator of eq. 21."""
    return Polynomial([0.0, 2.0 * (1.0 - b) ** 2, 4.0 * b])
