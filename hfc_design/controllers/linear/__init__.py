"""Linear controllers with feed-forward: PID tuned by a search, and optimal regulators.

All have one law. Of ``pid+ff`` every gain is searched; of ``lqr`` and ``lqi`` weights are, and the
gains follow from them and from the linearised drive.
"""

from math import pi
from typing import Any

from hfc_design.controllers.controller import AxisLaw
from hfc_design.controllers.kind import Explain, Kind, later
from hfc_design.controllers.linear.code import shares
from hfc_design.controllers.linear.law import initial_memory, sample
from hfc_design.controllers.linear.record import (
    LinearDesign,
    LqiDesign,
    LqiSettings,
    LqrDesign,
    LqrSettings,
    PidDesign,
    PidSettings,
)
from hfc_design.core.numbers import Json


def _of_gains(gains: dict[str, float]) -> Json:
    """By hand the filter may be given by its time constant, ``derivative_s`` [s]."""
    if not gains.get("derivative_s"):
        return gains
    hz = 1.0 / (2.0 * pi * gains["derivative_s"])
    return {"derivative_hz": hz} | {k: x for k, x in gains.items() if k != "derivative_s"}


def _kind(name: str, summary: str, record: type[LinearDesign], settings: Any, genome: Any) -> Kind:
    return Kind(
        name=name,
        summary=summary,
        record=record,
        settings=settings,
        gains=LinearDesign.gains,
        law=lambda own, limit: AxisLaw(
            sample, initial_memory, own.sample_time_s, limit, own.structure
        ),
        genome=genome,
        reads=LinearDesign.reads,
        reach=LinearDesign.reach,
        connecting=LinearDesign.connecting,
        of_gains=_of_gains,
        explain=Explain(
            signals=lambda record: (record.reads(), []),
            remember=lambda memory, readings: memory,  # nothing of it is a reading
            shown=lambda record, parts: {"units": [], "parts": shares(record, parts)},
        ),
        sections=later(f"{HERE}.section", "sections"),
    )


HERE = "hfc_design.controllers.linear"
_PID, _LQ = later(f"{HERE}.genome", "PidGenome"), later(f"{HERE}.lq_genome", "LqGenome")
_OPTIMAL = "optimal state feedback with"
KINDS = (
    _kind("pid+ff", "PID with filter and feed-forward", PidDesign, PidSettings, _PID),
    _kind("lqr", f"{_OPTIMAL} feed-forward", LqrDesign, LqrSettings, _LQ),
    _kind("lqi", f"{_OPTIMAL} integral and feed-forward", LqiDesign, LqiSettings, _LQ),
)
