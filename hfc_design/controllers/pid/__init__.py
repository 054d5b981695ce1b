"""Proportional-integral-derivative controller of a feed drive.

This file has the law and the gains. Never imports JAX.
"""

from typing import NamedTuple

from hfc_design.controllers import kind
from hfc_design.controllers.controller import AxisLaw, Signals, held, outside
from hfc_design.controllers.gains import FEEDS, kind_of_gains
from hfc_design.controllers.kind import ControllerRecord
from hfc_design.core.numbers import Own, Scalar, Xp


class PidRecord(ControllerRecord):
    """Fields of a design besides its gains."""

    dead_zone: kind.DeadZone = 0.0  # errors up to this size count as 0 [BLU]


class PidGains(NamedTuple):
    """Gains of one individual on an error in BLU; in a population, arrays over the individuals."""

    k_p: Scalar  # gain on the error [units/BLU]
    k_i: Scalar  # gain on the integral of the error [units/(BLU s)]
    k_d: Scalar  # gain on the rate of the error [units s/BLU]


class PidMemory(NamedTuple):
    """Memory of the controller; zero before the first sample."""

    error: Scalar  # error of the previous sample [BLU]
    sum: Scalar  # sum of all errors so far [BLU]


def initial_memory(law: AxisLaw, zero: Scalar) -> PidMemory:
    """Return the memory before the first sample: the axis at rest on its reference."""
    return PidMemory(zero, zero)


def primed(xp: Xp, law: AxisLaw, gains: PidGains, memory: PidMemory, signals: Signals) -> PidMemory:
    """Return the memory with the present error as the previous one, so that its rate is 0."""
    return memory._replace(error=outside(xp, law.structure, signals["error"]))


def sample(
    xp: Xp, law: AxisLaw, gains: PidGains, memory: PidMemory, signals: Signals
) -> tuple[Scalar, PidMemory, None]:
    """Return ``u = K_P e + K_I T sum(e) + K_D (e(k) - e(k-1)) / T`` [units], new memory, and None.

    e is the error [BLU]; within the dead zone it counts as 0.
    """
    error, every = outside(xp, law.structure, signals["error"]), law.sample_time
    whole = memory.sum + error
    damping = gains.k_d / every * (error - memory.error)
    command = gains.k_p * error + gains.k_i * every * whole + damping
    if law.limit is not None:
        whole = held(xp, law.limit, command, memory.sum, whole)
        command = gains.k_p * error + gains.k_i * every * whole + damping
    return command, PidMemory(error, whole), None


def _ranges(record: Own, limit: float | None) -> dict[str, float]:
    k_p, _, k_d = dict(record.pid).values()
    return kind.input_ranges({"error": k_p, "error_change": k_d / record.sample_time_s}, limit)


#: Search ranges for a feed drive.
RANGES = PidGains(k_p=(0.1, 20.0), k_i=(0.0, 50.0), k_d=(0.0, 1.0))
KIND = kind_of_gains(
    "pid",
    RANGES,
    sample,
    initial_memory,
    structure=lambda record: record.dead_zone or None,
    tells=True,
    prime=primed,
    base=PidRecord,
    plants=FEEDS,
    summary="proportional-integral-derivative on an error in BLU",
    reads=lambda record: ["error"],
    input_range=_ranges,
    connecting=lambda record: [kind.CHANGES, *kind.dead_zone_note(record)],
)
