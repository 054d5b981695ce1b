"""Compensation of the tracking errors of a machine beside any controller (Lin & Gai 2009)."""

from pathlib import Path

from hfc_design.controllers.dynamic_compensation.record import (
    CompensationDesign,
    CompensationSettings,
)
from hfc_design.controllers.inner import INSIDE, OuterDesign
from hfc_design.controllers.kind import Kind, Template, later, remembered
from hfc_design.controllers.per_axis import learnt
from hfc_design.core.numbers import Json, Memory


def _learnt(
    record: CompensationDesign, axes: tuple[str, ...], memory: Memory
) -> CompensationDesign | None:
    """With what is inside as it has become: its memory is all there is."""
    inner = learnt(record.inner, axes, memory)
    return record.model_copy(update={"inner": inner}) if inner else None


def _c(record: CompensationDesign) -> Json:
    axes = list(record.k_p)
    return {
        "k_p": list(record.k_p.values()),
        "dead_zone": record.dead_zone,
        "speed": record.programmed_speed,
        "along": [axes.index(axis) for axis in record.path_axes or axes],
        "own": [],
        "root": True,
    }


KIND = Kind(
    name="dynamic-compensation",
    no_rules="rule tables are but inside it, in its axes' controllers; c and fmu hold all of it",
    summary="any controllers, and beside them what the length of all errors asks for (Lin & Gai)",
    record=CompensationDesign,
    settings=CompensationSettings,
    gains=CompensationDesign.gains,
    controller=CompensationDesign.controller,
    genome=later("hfc_design.controllers.dynamic_compensation.genome", "CompensationGenome"),
    learnt=_learnt,
    inside=INSIDE,
    structure=OuterDesign.structure,
    reads=lambda record: list(dict.fromkeys(["error", "reference_rate", *record.inner_reads()])),
    reach=CompensationDesign.reach,
    saved=remembered(lambda record: []),
    c=Template((Path(__file__).parent / "templates",), _c),
    sections=later("hfc_design.controllers.dynamic_compensation.section", "sections"),
)
