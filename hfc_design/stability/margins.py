"""Poles and margins of a linear sampled loop, opened at its command. Never imports JAX."""

from itertools import pairwise
from math import ceil
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from hfc_design.core.numbers import Floats

#: A singular value of ``a - 1`` so near to 0 is an integrator's. Its poles do not tell: those of
#: two or three in a row are found at 1 +- 1e-8 or 1e-5, by their last bits.
INTEGRATES = 1e-9
#: A gain margin beyond that, either way, is of a response that is 0 or infinite but for rounding.
NO_MARGIN = 1e9
#: Frequencies that are looked at, in shares of half the sampling frequency.
FREQUENCIES = np.geomspace(1e-7, 1.0, 4001)
#: The same on either side of a resonance, in shares of its frequency: where the loop is large there
#: may be a thousandth of it wide.
BESIDE = np.geomspace(1e-7, 0.1, 121)


class OpenLoop(NamedTuple):
    """``x(k+1) = a x + b u``, and what the controller answers: ``c x`` instead of u."""

    a: Floats  # (states, states) drive and controller
    b: Floats  # (states,)
    c: Floats  # (states,)
    about: str = ""  # what it is of, where that is not all of a linear controller
    resonances: tuple[float, ...] = ()  # angles at which it is infinite, those above 0

    def transfer(self, angle: Floats) -> Floats:
        """L(z) at ``z = exp(i angle)``, complex; the closed loop is 1 / (1 + L)."""
        z = np.exp(1j * np.asarray(angle))
        matrices = z[:, None, None] * np.eye(len(self.b)) - self.a
        answers = np.linalg.solve(
            matrices, np.broadcast_to(self.b[:, None], (*z.shape, *self.b.shape, 1))
        )
        return np.asarray(-(answers[..., 0] @ self.c))

    def delayed(self, samples: float) -> "OpenLoop":
        """The loop whose command acts so many samples later: ``L(z) z^-samples``.

        Of a part of a sample in the mean over it.
        """
        a, b, c = self.a, self.b, self.c
        for k in range(ceil(samples)):  # another state: the command of the sample before
            size, late = len(b), min(samples - k, 1.0)
            a = np.block([[a, late * b[:, None]], [np.zeros((1, size + 1))]])
            b, c = np.append((1.0 - late) * b, 1.0), np.append(c, 0.0)
        waits = f"With the delay of {samples:g} sample{'s' * (samples > 1)} that the drive has"
        about = ". ".join(filter(None, (self.about, waits if samples else "")))
        return OpenLoop(a, b, c, about, self.resonances)

    def angles(self) -> list[Floats]:
        """Angles to look at, in pieces between which the loop is infinite."""
        each = [angle * (1.0 + way * BESIDE) for angle in self.resonances for way in (-1.0, 1.0)]
        whole = np.unique(np.concatenate([np.pi * FREQUENCIES, *each]))
        whole = whole[(whole <= np.pi) & ~np.isin(whole, self.resonances)]
        return np.split(whole, np.searchsorted(whole, self.resonances))


class Margins(NamedTuple):
    """How far a loop is from where it oscillates by itself; None: nothing of that kind does it."""

    stable: bool
    poles: list[complex]  # of the closed loop, the slowest first
    gain_up: float | None  # factor on the loop gain
    gain_down: float | None  # factor below 1
    phase: float | None  # lag [deg]
    delay: float | None  # samples


def margins(loop: OpenLoop) -> Margins:
    """Margins of a loop; of one that is not stable, factors that would make it so count too."""
    poles = np.linalg.eigvals(loop.a + np.outer(loop.b, loop.c))
    poles = poles[np.argsort(-np.abs(poles), kind="stable")]
    pieces = [(angles, loop.transfer(angles)) for angles in loop.angles()]

    def crossings(of: str) -> list[float]:
        """Angles at which a part of the response changes its sign."""
        found = []
        for angles, response in pieces:
            for k, (left, right) in enumerate(pairwise(_parts(response, of))):
                if np.isfinite([left, right]).all() and (left < 0.0) != (right < 0.0):
                    ends = {float(angles[k]): left, float(angles[k + 1]): right}
                    found.append(_crossing(loop, of, ends))
        return found

    real = [*crossings("imag"), np.pi]  # at pi it always is
    if np.linalg.svd(loop.a - np.eye(len(loop.b)))[1][-1] > INTEGRATES:
        real.append(0.0)
    sizes = -loop.transfer(np.array(real)).real
    factors = [1.0 / x for x in sizes if 1.0 / NO_MARGIN < x < NO_MARGIN]
    unity = crossings("log")
    lags = np.angle(loop.transfer(np.array(unity)), deg=True) + 180.0 if unity else np.empty(0)
    ahead = lags % 360.0  # what a delay may still turn it, one way only
    off = np.minimum(ahead, 360.0 - ahead)
    waits = np.radians(ahead) / np.array(unity) if unity else np.empty(0)
    return Margins(
        bool(np.abs(poles[0]) < 1.0),
        poles.tolist(),
        min((float(x) for x in factors if x > 1.0), default=None),
        max((float(x) for x in factors if x < 1.0), default=None),
        float(off.min()) if unity else None,
        float(waits.min()) if unity else None,
    )


def _parts(response: Floats, of: str) -> Floats:
    return np.asarray(response.imag if of == "imag" else np.log(np.abs(response)))


def _crossing(loop: OpenLoop, of: str, ends: dict[float, float]) -> float:
    """Angle between two ``ends`` at which a part changes its sign.

    By the values that it was seen to have there: found alone, one near 0 may have another sign.
    """

    def part(angle: float) -> float:
        if angle in ends:
            return ends[angle]
        return float(_parts(loop.transfer(np.array([angle])), of)[0])

    return float(brentq(part, min(ends), max(ends)))
