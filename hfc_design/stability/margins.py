"""Poles and margins of a linear sampled loop, opened at its command. Never imports JAX."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import matrix_balance

from hfc_design.core.numbers import Floats

#: What a scenario may ask of its loops -> the number of ``loop_report``, whether more of it is
#: worse, and between what it has to lie.
ASKED = {
    "sensitivity": ("sensitivity", True, (1.0, 100.0)),
    "gain_margin": ("gain_up", False, (1.0, 1e6)),
    "phase_margin_deg": ("phase_deg", False, (0.0, 180.0)),
    "delay_margin_samples": ("delay_samples", False, (0.0, 1e4)),
}
#: A singular value of ``a - 1`` so near to 0 is an integrator's. Its poles do not tell: those of
#: two or three in a row are found at 1 +- 1e-8 or 1e-5, by their last bits.
INTEGRATES = 1e-9
#: A gain margin beyond that, either way, is of a response that is 0 or infinite but for rounding.
NO_MARGIN = 1e5
#: Frequencies that are looked at, in shares of half the sampling frequency.
FREQUENCIES = np.geomspace(1e-6, 1.0, 601)
#: The same on either side of a pole near the unit circle, in its distances from that: where the
#: loop is large there may be a thousandth of its frequency wide.
BESIDE = np.concatenate([way * np.geomspace(0.03, 30.0, 25) for way in (-1.0, 1.0)])
#: How often what is found between two frequencies is sought again, between ever nearer ones.
CLOSER, BETWEEN = 5, np.linspace(0.0, 1.0, 21)
#: The size of a closed loop at the end of its band: -3 dB.
BAND = 10.0**-0.15


class OpenLoop(NamedTuple):
    """``x(k+1) = a x + b u``, and what the controller answers: ``c x`` instead of u."""

    a: Floats  # (states, states) drive and controller
    b: Floats  # (states,)
    c: Floats  # (states,)

    def reduced(self) -> "OpenLoop":
        """Without what stays as it is whatever happens and either hears or says nothing.

        A rule that does not fire, say, or how far bristles were bent to begin with: that is no
        part of the loop, and its pole of 1 does not settle.
        """
        found = self._heard()
        turned = OpenLoop(found.a.T, found.c, found.b)._heard()
        return OpenLoop(turned.a.T, turned.c, turned.b)

    def _heard(self) -> "OpenLoop":
        a, units = balanced(self.a)
        b, c = self.b / units, self.c * units
        seen = c / (np.abs(c).max() or 1.0)
        _, sizes, rows = np.linalg.svd(np.vstack([a - np.eye(len(a)), seen]))
        kept = rows[sizes > INTEGRATES * max(float(sizes[0]), 1.0)].T
        return OpenLoop(kept.T @ a @ kept, kept.T @ b, kept.T @ c)

    def transfer(self, angle: Floats) -> Floats:
        """L(z) at ``z = exp(i angle)``, complex; the closed loop is 1 / (1 + L)."""
        return np.asarray(1.0 / self.sensitivity()(np.asarray(angle)) - 1.0)

    def poles(self) -> tuple[Any, Any]:
        """Of the open and of the closed loop, complex."""
        a, units = balanced(self.a)
        fed_back = np.outer(self.b / units, self.c * units)
        return np.asarray(np.linalg.eigvals(a)), np.asarray(np.linalg.eigvals(a + fed_back))

    def sensitivity(self) -> Callable[[Floats], Floats]:
        """1 / (1 + L) at angles, complex: of the distances from the poles, open over closed."""
        before, after = self.poles()

        def at(angle: Floats) -> Floats:
            z = np.exp(1j * angle)[..., None]
            with np.errstate(divide="ignore", invalid="ignore"):
                return np.asarray(np.prod((z - before) / (z - after), axis=-1))

        return at


class Margins(NamedTuple):
    """How far a loop is from where it oscillates by itself; None: nothing of that kind does it.

    Angles are those of ``z = exp(i angle)``: 2 pi times the frequency, of a sample.
    """

    stable: bool
    poles: list[complex]  # of the closed loop, the slowest first
    gain_up: float | None  # factor on the loop gain
    gain_down: float | None  # factor below 1
    phase: float | None  # lag [deg]
    delay: float | None  # samples
    sensitivity: float  # largest |1 / (1 + L)|, Ms
    peak: float  # angle at which it is
    disk: float  # of gain and phase together: 2 / largest |(1 - L) / (1 + L)|
    bandwidth: float | None  # angle at which |L / (1 + L)| first falls to -3 dB
    crossover: float | None  # largest angle at which |L| falls to 1


def margins(loop: OpenLoop) -> Margins:
    """Margins of a loop; of one that is not stable, factors that would make it so count too."""
    loop = loop.reduced()
    before, after = loop.poles()
    after = after[np.argsort(-np.abs(after), kind="stable")]
    at, angles = loop.sensitivity(), _angles(np.concatenate([before, after]))
    response = at(angles)
    real = [
        *_crossings(at, angles, response, lambda s: (1.0 / s).imag),
        np.pi,
    ]  # at pi it always is
    if np.linalg.svd(loop.a - np.eye(len(loop.b)))[1][-1:].sum() > INTEGRATES:
        real.append(0.0)
    sizes = 1.0 - (1.0 / at(np.array(real))).real
    factors = [1.0 / x for x in sizes if 1.0 / NO_MARGIN < x < NO_MARGIN]
    unity = np.array(_crossings(at, angles, response, lambda s: np.log(np.abs(1.0 / s - 1.0))))
    lags = np.angle(1.0 / at(unity) - 1.0, deg=True) + 180.0
    ahead = lags % 360.0  # what a delay may still turn it, one way only
    off = np.minimum(ahead, 360.0 - ahead)
    closed = _crossings(at, angles, response, lambda s: np.log(np.abs(1.0 - s) / BAND))
    peak = _largest(at, angles, np.abs)
    skew = _largest(at, angles, lambda s: np.abs(2.0 * s - 1.0))
    return Margins(
        bool(np.abs(after[:1]).sum() < 1.0),
        after.tolist(),
        min((float(x) for x in factors if x > 1.0), default=None),
        max((float(x) for x in factors if x < 1.0), default=None),
        float(off.min()) if len(unity) else None,
        float((np.radians(ahead) / unity).min()) if len(unity) else None,
        float(np.abs(at(np.array([peak])))[0]),
        peak,
        float(2.0 / np.abs(2.0 * at(np.array([skew])) - 1.0)[0]),
        min(closed, default=None),
        float(unity.max()) if len(unity) else None,
    )


def largest(loop: OpenLoop) -> tuple[float, float]:
    """Of ``c x`` for a sine of u in a loop that is closed already: the largest, and the slowest."""
    loop, few = loop.reduced(), np.exp(1j * np.pi * FREQUENCIES[::60])
    matrices = few[:, None, None] * np.eye(len(loop.b)) - loop.a
    size = np.abs(np.linalg.solve(matrices, loop.b[:, None].astype(complex))[..., 0] @ loop.c).max()
    if not size > 0.0:
        return 0.0, 0.0
    one = loop._replace(c=-loop.c / size)
    at = one.sensitivity()
    angles = _angles(np.concatenate(one.poles()))
    peak = _largest(at, angles, lambda s: np.abs(1.0 / s - 1.0))
    found = size * np.abs(1.0 / at(np.array([peak, angles[0]])) - 1.0)
    return float(found[0]), float(found[1])


def balanced(a: Floats) -> tuple[Floats, Floats]:
    """A step's matrix with its states in units that make it even, and those units (states,).

    With the units of the drive, metres beside radians, or with one part of it far stiffer than the
    others, what is not 0 lies as deep below the largest singular value as what is only rounding.
    """
    with np.errstate(invalid="ignore"):  # of a matrix that is not finite
        even, (units, _) = matrix_balance(a, permute=False, separate=True)
    return np.asarray(even, float), np.asarray(units, float)


def _angles(poles: Floats) -> Floats:
    """Angles to look at."""
    turning = poles[(poles.imag > 0.0) & (np.abs(poles) > 0.5)]
    beside = np.angle(turning)[:, None] + np.abs(1.0 - np.abs(turning))[:, None] * BESIDE
    whole = np.unique(np.concatenate([np.pi * FREQUENCIES, beside.ravel()]))
    return whole[(whole > 0.0) & (whole <= np.pi)]


#: What of a sensitivity is looked for.
Part = Callable[[Floats], Floats]


def _crossings(
    at: Callable[[Floats], Floats], angles: Floats, response: Floats, part: Part
) -> list[float]:
    """Angles at which a part changes its sign, and not because it is infinite between."""
    with np.errstate(divide="ignore", invalid="ignore"):
        values = part(response)
    finite = np.isfinite(values[:-1]) & np.isfinite(values[1:])
    found = []
    for k in np.flatnonzero(finite & ((values[:-1] < 0.0) != (values[1:] < 0.0))):
        low, high, ends = angles[k], angles[k + 1], values[k : k + 2]
        for _ in range(CLOSER):
            places = low + (high - low) * BETWEEN
            with np.errstate(divide="ignore", invalid="ignore"):
                inside = part(at(places))
            # As they were seen to be: found alone, one near 0 may have another sign.
            inside[0], inside[-1] = ends
            n = int(np.flatnonzero((inside[:-1] < 0.0) != (inside[1:] < 0.0))[0])
            low, high, ends = places[n], places[n + 1], inside[n : n + 2]
        if np.abs(ends).max() <= 2.0 * max(np.abs(values[k : k + 2]).max(), 1e-9):
            found.append(float(low - ends[0] * (high - low) / (ends[1] - ends[0])))
    return found


def _largest(at: Callable[[Floats], Floats], angles: Floats, part: Part) -> float:
    """The angle at which a part is largest."""
    for _ in range(CLOSER):
        k = int(np.nanargmax(part(at(angles))))
        ends = angles[max(k - 1, 0)], angles[min(k + 1, len(angles) - 1)]
        best, angles = (
            float(angles[k]),
            np.append(ends[0] + (ends[1] - ends[0]) * BETWEEN, angles[k]),
        )
        angles.sort()
    return best
