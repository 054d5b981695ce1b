"""Compensation of the tracking errors of a machine beside any controller (Lin & Gai 2009)."""

from hfc_design.controllers.dynamic_compensation.record import (
    CompensationDesign,
    CompensationSettings,
)
from hfc_design.controllers.kind import Kind, later
from hfc_design.controllers.per_axis import learnt
from hfc_design.core.numbers import Memory


def _learnt(
    record: CompensationDesign, axes: tuple[str, ...], memory: Memory
) -> CompensationDesign | None:
    """With what is inside as it has become: its memory is all there is."""
    inner = learnt(record.inner, axes, memory)
    return record.model_copy(update={"inner": inner}) if inner else None


KIND = Kind(
    name="dynamic-compensation",
    summary="any controllers, and beside them what the length of all errors asks for (Lin & Gai)",
    record=CompensationDesign,
    settings=CompensationSettings,
    gains=CompensationDesign.gains,
    controller=CompensationDesign.controller,
    genome=later("hfc_design.controllers.dynamic_compensation.genome", "CompensationGenome"),
    learnt=_learnt,
    sections=later("hfc_design.controllers.dynamic_compensation.section", "sections"),
)
