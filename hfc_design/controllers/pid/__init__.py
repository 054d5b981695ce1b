"""The proportional-integral-derivative controller of a feed drive.

Its law, its gains and its templates; never imports JAX.
"""

from pathlib import Path
from typing import NamedTuple

from hfc_design.controllers.controller import AxisLaw, Signals, held
from hfc_design.controllers.gains import kind_of_gains
from hfc_design.controllers.kind import Template
from hfc_design.core.scalars import Xp
from hfc_design.core.shapes import Json, Own, Scalar


class PidGains(NamedTuple):
    """Gains on an error in BLU: one individual, or a population in the trailing axis."""

    k_p: Scalar  # [units/BLU]
    k_i: Scalar  # [units/(BLU s)]
    k_d: Scalar  # [units s/BLU]


class PidMemory(NamedTuple):
    """What the controller remembers; zero before the first sample."""

    error: Scalar  # e(k-1) [BLU]
    sum: Scalar  # of all errors so far [BLU]


class PidParts(NamedTuple):
    """What the command is made of."""

    proportional: Scalar
    integral: Scalar
    derivative: Scalar

    def command(self) -> Scalar:
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
    if law.limit is None:
        return found, PidMemory(error, whole)
    kept = held(xp, law.limit, found.command(), memory.sum, whole)
    return found._replace(integral=gains.k_i * law.sample_time * kept), PidMemory(error, kept)


def _st(record: Own) -> Json:
    kp, ki, kd = dict(record.pid).values()
    return {
        "constants": {"kp": kp, "ki": ki, "kd": kd, "sample_time": record.sample_time_s},
        "remembered": ["previous_error", "error_sum"],
        "within": ["new_sum"],
    }


HERE = (Path(__file__).parent / "templates",)
#: On a feed drive.
RANGES = PidGains(k_p=(0.1, 20.0), k_i=(0.0, 50.0), k_d=(0.0, 1.0))
KIND = kind_of_gains(
    "pid",
    RANGES,
    pid,
    summary="proportional-integral-derivative on an error in BLU",
    reads=lambda record: ["error"],
    c=Template(HERE, lambda record: {"gains": record.pid, "integrates": True}),
    st=Template(HERE, _st),
)
