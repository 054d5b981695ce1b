"""Control laws whose gains are a few numbers: PD, PID, a user's own. Never imports JAX."""

from collections.abc import Callable
from math import isfinite
from typing import Any, NamedTuple

from hfc_design.controllers.pd import law as pd
from hfc_design.controllers.pid import law as pid
from hfc_design.core.plugins import Group

Range = tuple[float, float]


class Law(NamedTuple):
    """A control law as pure functions of scalars, and where its gains are searched::

        memory = law.initial_memory(0.0)
        command, memory = law.step(sample_time, gains, memory, signals)

    ``ranges`` is a NamedTuple of (low, high), ``gains`` one of the same class with numbers. A
    range above zero is searched by its logarithm, any other one on a straight line. ``signals``
    holds ``error``, ``error_rate`` and the plant's readings.
    """

    name: str  # the ``kind`` of a controller in a file
    ranges: Any
    initial_memory: Callable[[Any], Any]
    step: Callable[[float, Any, Any, dict[str, Any]], tuple[Any, Any]]


def range_fault(pair: Any) -> str | None:
    """What is wrong with a range, in a line; None if nothing is."""
    numbers = isinstance(pair, tuple) and all(isinstance(end, int | float) for end in pair)
    if not numbers or len(pair) != 2 or not all(map(isfinite, pair)):
        return f"{pair!r} is no tuple of two finite numbers"
    return None if pair[0] < pair[1] else f"{pair!r} has to be (low, high)"


def _fault(law: Law) -> str | None:
    if not getattr(law.ranges, "_fields", ()):
        return "ranges has to be a NamedTuple of (low, high)"
    for name, pair in law.ranges._asdict().items():
        if fault := range_fault(pair):
            return f"ranges.{name}: {fault}"
    return None


#: On the C-axis [V/rad, V s/rad]; the ranges are those of ``RaceSettings``.
PD = Law(
    "pd",
    pd.PdGains(kp=(100.0, 10_000.0), kd=(30.0, 3_000.0)),
    lambda zero: (),
    lambda sample_time, gains, memory, signals: (pd.law(gains, signals), memory),
)
#: On a feed drive, an error in BLU: units/BLU, units/(BLU s), units s/BLU.
PID = Law(
    "pid",
    pid.PidGains(k_p=(0.1, 20.0), k_i=(0.0, 50.0), k_d=(0.0, 1.0)),
    pid.initial_memory,
    pid.step,
)
LAWS: Group[Law] = Group(
    "controller",
    Law,
    "hfc_design.controllers.kinds",
    {law.name: law for law in (PD, PID)},
    frozenset({"pd", "pid", "pd+hierarchical-fuzzy", "flc", "aflc", "soflc"}),
    _fault,
)
