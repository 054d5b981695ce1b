"""Law and gains of the PD controller with which fuzzy ones are compared. Never imports JAX."""

from typing import NamedTuple

from hfc_design.controllers.controller import AxisLaw, Signals
from hfc_design.controllers.gains import kind_of_gains
from hfc_design.controllers.kind import input_ranges
from hfc_design.core.numbers import Scalar, Xp


class PdGains(NamedTuple):
    """Gains of LL eq. 6."""

    kp: Scalar  # gain on the error [command/error]
    kd: Scalar  # gain on the rate of the error [command s/error]


def initial_memory(law: AxisLaw, zero: Scalar) -> tuple[()]:
    """Return an empty memory."""
    return ()


def sample(
    xp: Xp, law: AxisLaw, gains: PdGains, memory: tuple[()], signals: Signals
) -> tuple[Scalar, tuple[()], None]:
    """Command ``kp e + kd de/dt`` (LL eq. 6).

    It is returned [V] together with the empty memory and None for its parts.
    """
    return gains.kp * signals["error"] + gains.kd * signals["error_rate"], memory, None


#: Search ranges for the C-axis, the same as those of the PD of a hierarchy.
RANGES = PdGains(kp=(100.0, 10_000.0), kd=(30.0, 3_000.0))
KIND = kind_of_gains(
    "pd",
    RANGES,
    sample,
    initial_memory,
    tells=True,
    plants=("c-axis",),
    summary="proportional-derivative: v = kp e + kd de/dt",
    input_range=lambda record, limit: input_ranges(
        {"error": record.pd.kp, "error_rate": record.pd.kd}, limit
    ),
)
