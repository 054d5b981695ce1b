"""The PD law that every fuzzy one is measured against. Never imports JAX."""

from typing import Any, NamedTuple

from hfc_design.controllers.controller import AxisLaw, Signals
from hfc_design.core.scalars import Scalar, Xp


class PdGains(NamedTuple):
    """Gains of LL eq. 6."""

    kp: Any  # [V/rad]
    kd: Any  # [V s/rad]


class PdParts(NamedTuple):
    """What the command is made of."""

    proportional: Any
    derivative: Any

    def command(self) -> Any:
        """The sum (LL eq. 6)."""
        return self.proportional + self.derivative


def pd(sample_time: float, limit: float | None = None) -> AxisLaw:
    """The law of kind ``pd``; it remembers nothing."""
    return AxisLaw(parts, initial_memory, sample_time, limit)


def initial_memory(law: AxisLaw, zero: Scalar) -> tuple[()]:
    """Nothing."""
    return ()


def parts(
    xp: Xp, law: AxisLaw, gains: PdGains, memory: tuple[()], signals: Signals
) -> tuple[PdParts, tuple[()]]:
    """``kp e + kd de/dt`` [V] (LL eq. 6)."""
    return PdParts(gains.kp * signals["error"], gains.kd * signals["error_rate"]), memory
