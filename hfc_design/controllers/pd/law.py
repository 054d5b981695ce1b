"""The PD law that every fuzzy one is measured against. Never imports JAX."""

from typing import Any, NamedTuple


class PdGains(NamedTuple):
    """Gains of LL eq. 6."""

    kp: Any  # [V/rad]
    kd: Any  # [V s/rad]


def law(gains: Any, signals: dict[str, Any]) -> Any:
    """``kp e + kd de/dt`` [V] (LL eq. 6)."""
    return gains.kp * signals["error"] + gains.kd * signals["error_rate"]
