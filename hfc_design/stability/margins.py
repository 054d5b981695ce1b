"""Poles and margins of a linear sampled loop, opened at its command. Never imports JAX."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from scipy.linalg import matrix_balance

from hfc_design.core.numbers import Floats, Json, Mask

#: Key in ``[constraints]`` -> the number of ``report`` that it limits, whether a larger value is
#: worse, and the allowed range of the limit.
ASKED = {
    "sensitivity": ("sensitivity", True, (1.0, 100.0)),
    "gain_margin": ("gain_up", False, (1.0, 1e6)),
    "phase_margin_deg": ("phase_deg", False, (0.0, 180.0)),
    "delay_margin_samples": ("delay_samples", False, (0.0, 1e4)),
    "bandwidth_hz": ("bandwidth_hz", False, (0.0, 1e6)),
    "closed_loop_peak": ("closed_loop_peak", True, (1.0, 100.0)),
    "compliance": ("compliance", True, (0.0, 1e12)),
}
#: Those of ``ASKED`` that are goals rather than margins: shown only where a scenario names them.
GOALS = ("bandwidth_hz", "closed_loop_peak", "compliance")
#: Unit and meaning of each of ``ASKED``.
MEANT = {
    "sensitivity": ("1", "largest sensitivity Ms of the linearised loop, |1 / (1 + L)|"),
    "gain_margin": ("1", "smallest factor upwards on the gain that the linearised loop tolerates"),
    "phase_margin_deg": ("deg", "smallest lag that the linearised loop tolerates"),
    "delay_margin_samples": ("samples", "smallest additional delay that it tolerates"),
    "bandwidth_hz": ("Hz", "lowest frequency where |L / (1 + L)| of it falls to -3 dB"),
    "closed_loop_peak": ("1", "its largest |L / (1 + L)|, Mt"),
    "compliance": ("error/load", "its largest |position / load|, over all frequencies"),
}
#: Largest singular value of ``a - 1`` that counts as 0 and so shows an integrator. The poles do not
#: show it: by rounding, two or three integrators in series have theirs at 1 +- 1e-8 or 1e-5.
INTEGRATES = 1e-9
#: Factor of a gain margin, up or down, beyond which it comes from the rounding of 0 or infinity.
NO_MARGIN = 1e5
#: Initial frequencies, as shares of half the sampling frequency.
FREQUENCIES = np.geomspace(1e-6, 1.0, 601)
#: Initial frequencies on either side of a pole near the unit circle, in units of its distance to
#: the circle: the range where the loop is large may be a thousandth of its frequency wide.
BESIDE = np.concatenate([way * np.geomspace(0.03, 30.0, 25) for way in (-1.0, 1.0)])
#: Number of refinements between two frequencies, and the places of the new ones.
CLOSER, BETWEEN = 5, np.linspace(0.0, 1.0, 21)[1:-1]
#: Cosine of a turn between two frequencies below which the loop has gone half around, past a pole.
HALF = -0.999
#: Size of a closed loop at the end of its band: -3 dB.
BAND = 10.0**-0.15


class OpenLoop(NamedTuple):
    """Open loop ``x(k+1) = a x + b u``; the controller's answer is ``c x``: u if it is closed."""

    a: Floats  # (states, states) drive and controller
    b: Floats  # (states,)
    c: Floats  # (states,)

    def reduced(self) -> "OpenLoop":
        """Return the loop without constant states that are uncontrollable or unobservable.

        Examples are a rule that does not fire, or the initial deflection of bristles: such a state
        is no part of the loop, and its pole of 1 does not settle.
        """
        observable = self._heard()
        turned = OpenLoop(observable.a.T, observable.c, observable.b)._heard()
        return OpenLoop(turned.a.T, turned.c, turned.b)

    def _heard(self) -> "OpenLoop":
        a, units = balanced(self.a)
        b, c = self.b / units, self.c * units
        seen = c / (np.abs(c).max() or 1.0)
        _, sizes, rows = np.linalg.svd(np.vstack([a - np.eye(len(a)), seen]))
        basis = rows[sizes > INTEGRATES * max(float(sizes[0]), 1.0)].T
        return OpenLoop(basis.T @ a @ basis, basis.T @ b, basis.T @ c)

    def transfer(self, angle: Floats) -> Floats:
        """Return L(z) at ``z = exp(i angle)``, complex; the sensitivity is 1 / (1 + L)."""
        return np.asarray(1.0 / self.sensitivity()(np.asarray(angle)) - 1.0)

    def poles(self) -> tuple[Any, Any]:
        """Return the poles of the open and of the closed loop, complex."""
        a, units = balanced(self.a)
        fed_back = np.outer(self.b / units, self.c * units)
        return np.asarray(np.linalg.eigvals(a)), np.asarray(np.linalg.eigvals(a + fed_back))

    def sensitivity(self) -> Callable[[Floats], Floats]:
        """Return 1 / (1 + L) as a function of angles, complex, from open and closed poles."""
        before, after = self.poles()

        def at(angle: Floats) -> Floats:
            z = np.exp(1j * angle)[..., None]
            with np.errstate(divide="ignore", invalid="ignore"):
                return np.asarray(np.prod((z - before) / (z - after), axis=-1))

        return at


class Margins(NamedTuple):
    """Margins of a loop to self-sustained oscillation; None: no change of that kind causes it."""

    stable: bool
    gain_up: float | None  # factor on the loop gain
    gain_down: float | None  # factor below 1
    phase_deg: float | None  # lag
    delay_samples: float | None
    delay_ms: float | None
    sensitivity: float  # largest |1 / (1 + L)|, Ms
    sensitivity_hz: float  # of the largest one
    closed_loop_peak: float  # largest |L / (1 + L)|, Mt
    disk: float  # of gain and phase together: 2 / largest |(1 - L) / (1 + L)|
    crossover_hz: float | None  # highest frequency at which |L| is 1
    bandwidth_hz: float | None  # at which |L / (1 + L)| first falls to -3 dB
    slowest_pole: float  # largest magnitude of a closed pole


def margins(loop: OpenLoop, every: float) -> Margins:
    """Return margins of a loop, sampled ``every`` [s]; factors that make it stable count too."""
    loop = loop.reduced()
    before, after = loop.poles()
    slowest = float(np.abs(after).max(initial=0.0))
    at = loop.sensitivity()
    angles, s = _looked_at(at, np.concatenate([before, after]), _of_a_loop)
    values = sampled_margins(angles, every, s)
    factors = np.array([values["gain_up"], values["gain_down"]])
    if np.linalg.svd(loop.a - np.eye(len(loop.b)))[1][-1:].sum() > INTEGRATES:
        with np.errstate(divide="ignore"):
            factors = np.append(factors, 1.0 / (1.0 - (1.0 / at(np.zeros(1))).real))
    factors = factors[(factors > 1.0 / NO_MARGIN) & (factors < NO_MARGIN)]
    values["gain_up"] = factors[factors > 1.0].min(initial=np.inf)
    values["gain_down"] = factors[factors < 1.0].max(initial=-np.inf)
    values["delay_ms"] = 1e3 * every * values["delay_samples"]
    known: Json = {key: float(x) if np.isfinite(x) else None for key, x in values.items()}
    return Margins(stable=slowest < 1.0, slowest_pole=slowest, **known)


def sampled_margins(angles: Floats, every: float, s: Any, whole: bool = True) -> dict[str, Floats]:
    """Return margins of loops from their sensitivity ``s`` (..., angles), see ``Margins``.

    nan: there is none between the angles; ``whole``: the last one is pi.
    """
    with np.errstate(all="ignore"):
        factors, unity, lags = crossings(angles, 1.0 / s - 1.0)
        factors = factors if whole else factors[..., :-1]
        sizes, closed = np.abs(s), np.abs(1.0 - s)
        crossed, share = between(np.log(closed / BAND))
        hertz = angles / (2.0 * np.pi * every)
        least, most = partial(np.fmin.reduce, axis=-1), partial(np.fmax.reduce, axis=-1)
        return {
            "gain_up": least(np.where(factors > 1.0, factors, np.nan)),
            "gain_down": most(np.where(factors < 1.0, factors, np.nan)),
            "phase_deg": least(np.degrees(np.minimum(lags, 2.0 * np.pi - lags))),
            "delay_samples": least(lags / unity),
            "sensitivity": most(sizes),
            "sensitivity_hz": hertz[np.where(sizes >= 0.0, sizes, 0.0).argmax(-1)],
            "closed_loop_peak": most(closed),
            "disk": 2.0 / most(np.abs(2.0 * s - 1.0)),
            "crossover_hz": most(unity) / (2.0 * np.pi * every),
            "bandwidth_hz": least(np.where(crossed, _place(hertz, share), np.nan)),
        }


def crossings(angles: Floats, loop: Floats) -> tuple[Floats, Floats, Floats]:
    """Return gain factors, crossover angles and lags of loops (..., angles); nan where none is.

    They are sought between neighbouring angles: factors that lead a loop through -1 (also at the
    last angle, pi), angles where its magnitude is 1, and lags that lead it to -1 there [rad].
    """
    with np.errstate(all="ignore"):
        turn = loop[..., 1:] / loop[..., :-1]
        crossed, share = between(np.log(np.abs(loop)))
        unity = np.where(crossed, _place(angles, share), np.nan)
        lags = (np.angle(loop[..., :-1] * turn**share) + np.pi) % (2.0 * np.pi)
        crossed, share = between(loop.imag)
        real = loop.real[..., :-1] + share * np.diff(loop.real)
        real = np.where(crossed & (turn.real > HALF * np.abs(turn)), real, np.nan)
        factors = -1.0 / np.concatenate([real, loop.real[..., -1:]], axis=-1)
    return factors, unity, np.where(np.isnan(unity), np.nan, lags)


def swung(loop: Any, damping: float, share: float) -> Floats:
    """Return how near a mode at each angle leads a loop to -1: 1 reaches it, 0 or less never does.

    The mode multiplies the loop by ``1 + share s^2 / (s^2 + 2 d w s + w^2)``: near w the term
    beside 1 goes around a circle through 0 and ``i share / 2 d``, in which ``-(1 + 1 / L)`` may not
    lie.
    """
    off = 1.0 + 1.0 / loop
    return np.asarray(-share / (2.0 * damping) * off.imag / np.abs(off) ** 2)


def between(part: Floats) -> tuple[Mask, Floats]:
    """Return whether a part changes sign before the next angle, and at which share of the way."""
    crossed = (part[..., :-1] > 0.0) != (part[..., 1:] > 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = part[..., :-1] / (part[..., :-1] - part[..., 1:])
    return crossed, np.clip(share, 0.0, 1.0)


def _place(angles: Floats, share: Floats) -> Floats:
    """Return angles at shares of the ways between neighbouring angles."""
    return np.asarray(angles[:-1] * (angles[1:] / angles[:-1]) ** share)


def largest(loop: OpenLoop) -> tuple[float, float]:
    """Return the largest ``c x`` for sines of u in a closed loop, and that for the slowest sine."""
    loop, few = loop.reduced(), np.exp(1j * np.pi * FREQUENCIES[::60])
    matrices = few[:, None, None] * np.eye(len(loop.b)) - loop.a
    size = np.abs(np.linalg.solve(matrices, loop.b[:, None].astype(complex))[..., 0] @ loop.c).max()
    if not size > 0.0:
        return 0.0, 0.0
    one = loop._replace(c=-loop.c / size)

    def answer(s: Floats) -> "Parts":
        with np.errstate(divide="ignore", invalid="ignore"):  # infinite if nothing holds the axis
            return (), (size * np.abs(1.0 / s - 1.0),)

    _, s = _looked_at(one.sensitivity(), np.concatenate(one.poles()), answer)
    (magnitudes,) = answer(s)[1]
    return float(np.nanmax(magnitudes)), float(magnitudes[0])


def balanced(a: Floats) -> tuple[Floats, Floats]:
    """Return a step's matrix in state units that balance it, and these units (states,).

    In the units of the drive (metres beside radians), or with one part far stiffer than the others,
    elements that are not 0 may be as small beside the largest singular value as rounding errors.
    """
    with np.errstate(invalid="ignore"):  # of a matrix that is not finite
        even, (units, _) = matrix_balance(a, permute=False, separate=True)
    return np.asarray(even, float), np.asarray(units, float)


#: Quantities whose changes of sign are sought, and quantities whose maximum is sought.
Parts: TypeAlias = tuple[Sequence[Floats], Sequence[Floats]]


def _of_a_loop(s: Floats) -> Parts:
    loop = 1.0 / s - 1.0
    crossed = loop.imag, np.log(np.abs(loop)), np.log(np.abs(1.0 - s) / BAND)
    return crossed, (np.abs(s), np.abs(2.0 * s - 1.0), np.abs(1.0 - s))


def _looked_at(
    at: Callable[[Floats], Floats], poles: Floats, sought: Callable[[Floats], Parts]
) -> tuple[Floats, Floats]:
    """Return angles and sensitivities there, finer where ``sought`` parts change sign or peak."""
    turning = poles[(poles.imag > 0.0) & (np.abs(poles) > 0.5)]
    near_poles = np.angle(turning)[:, None] + np.abs(1.0 - np.abs(turning))[:, None] * BESIDE
    angles = np.unique(np.concatenate([np.pi * FREQUENCIES, near_poles.ravel()]))
    angles = angles[(angles > 0.0) & (angles <= np.pi)]
    s = at(angles)
    for _ in range(CLOSER):
        wanted = np.zeros(len(angles) - 1, bool)
        with np.errstate(divide="ignore", invalid="ignore"):
            crossed, peaks = sought(s)
        for part in crossed:
            wanted |= between(part)[0]
        for part in peaks:
            k = int(np.nanargmax(part))
            wanted[max(k - 1, 0) : k + 1] = True
        low, wide = angles[:-1][wanted], np.diff(angles)[wanted]
        more = np.setdiff1d(low[:, None] + wide[:, None] * BETWEEN, angles)
        angles, s = np.append(angles, more), np.append(s, at(more))
        order = np.argsort(angles)
        angles, s = angles[order], s[order]
    return angles, s
