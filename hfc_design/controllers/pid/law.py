"""The PID controller of a feed drive and its pole placement. Never imports JAX."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from hfc_design.controllers.controller import AxisLaw, Signals, held
from hfc_design.core.scalars import Scalar, Xp


class PidGains(NamedTuple):
    """Gains on an error in BLU: one individual, or a population in the trailing axis."""

    k_p: Any  # [units/BLU]
    k_i: Any  # [units/(BLU s)]
    k_d: Any  # [units s/BLU]


class PidMemory(NamedTuple):
    """What the controller remembers; zero before the first sample."""

    error: Any  # e(k-1) [BLU]
    sum: Any  # of all errors so far [BLU]


class PidParts(NamedTuple):
    """What the command is made of."""

    proportional: Any
    integral: Any
    derivative: Any

    def command(self) -> Any:
        """The sum."""
        return self.proportional + self.integral + self.derivative


def pid(sample_time: float, limit: float | None = None) -> AxisLaw:
    """The law of kind ``pid``."""
    return AxisLaw(parts, initial_memory, sample_time, limit)


def initial_memory(law: AxisLaw, zero: Scalar) -> PidMemory:
    """Memory before the first sample: the axis stood on its reference."""
    return PidMemory(zero, zero)


def parts(
    xp: Xp, law: AxisLaw, gains: PidGains, memory: PidMemory, signals: Signals
) -> tuple[PidParts, PidMemory]:
    """``u = K_P e + K_I T sum(e) + K_D (e(k) - e(k-1)) / T`` [units], with ``error`` [BLU]."""
    error = signals["error"]
    whole = memory.sum + error
    rate = (error - memory.error) / law.sample_time
    found = PidParts(gains.k_p * error, gains.k_i * law.sample_time * whole, gains.k_d * rate)
    kept = held(xp, law.limit, found.command(), memory.sum, whole)
    return found._replace(integral=gains.k_i * law.sample_time * kept), PidMemory(error, kept)


def pid_by_pole_placement(
    gain: float, time_constant: float, poles: Sequence[complex]
) -> tuple[float, float, float]:
    """``(k_p, k_i, k_d)`` that give the drive K/(s (tau s + 1)) three closed-loop ``poles`` [1/s].

    ``gain`` is K [BLU/s per unit], ``time_constant`` tau [s]. The gains stand one each in the
    coefficients of ``tau s^3 + (1 + K k_d) s^2 + K k_p s + K k_i``, so the match is exact.

    Raises:
        ValueError: there are not three poles, a complex one has no conjugate, or K or tau is 0.
    """
    if len(poles) != 3 or not gain or not time_constant:
        raise ValueError("three poles, a gain and a time constant are needed")
    wanted = time_constant * np.poly(np.asarray(poles, complex))
    if np.abs(wanted.imag).max() > 1e-9 * np.abs(wanted).max():
        raise ValueError(f"poles {list(poles)}: a complex pole needs its conjugate")
    _, second, first, last = wanted.real
    return float(first / gain), float(last / gain), float((second - 1.0) / gain)


def damped_poles(damping: float, bandwidth: float, fast: float) -> tuple[complex, ...]:
    """A pair with a ``damping`` ratio and a frequency ``bandwidth`` [1/s], and ``-fast`` [1/s]."""
    pair = np.roots([1.0, 2.0 * damping * bandwidth, bandwidth**2])
    return (*(complex(pole) for pole in pair), complex(-fast))
