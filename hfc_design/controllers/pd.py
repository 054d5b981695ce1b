"""The PD controller that every fuzzy one is measured against."""

from typing import Any, NamedTuple

from hfc_design.controllers.controller import Controller


class PdGains(NamedTuple):
    """Gains of LL eq. 6."""

    kp: Any  # [V/rad]
    kd: Any  # [V s/rad]


def law(gains: Any, signals: dict[str, Any]) -> Any:
    """``kp e + kd de/dt`` [V] (LL eq. 6)."""
    return gains.kp * signals["error"] + gains.kd * signals["error_rate"]


def pd() -> Controller:
    """The controller of kind ``pd``; it remembers nothing."""
    return _PD


_PD = Controller(
    "pd", lambda zero: (), lambda gains, memory, signals: (law(gains, signals), memory)
)
