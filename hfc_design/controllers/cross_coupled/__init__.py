"""Axis controllers of any kind with a common controller of the contour error (Koren 1980)."""

from pathlib import Path

from hfc_design.controllers.cross_coupled.law import CrossMemory
from hfc_design.controllers.cross_coupled.record import CrossCoupledDesign, CrossCoupledSettings
from hfc_design.controllers.inner import INSIDE, OuterDesign
from hfc_design.controllers.kind import STARTED, Kind, Member, Template, later, remembered
from hfc_design.controllers.per_axis import learnt
from hfc_design.core.numbers import Json


def _learnt(
    record: CrossCoupledDesign, axes: tuple[str, ...], memory: CrossMemory
) -> CrossCoupledDesign | None:
    """With what is inside as it has become."""
    inner = learnt(record.inner, axes, memory.inner)
    return record.model_copy(update={"inner": inner}) if inner else None


def _c(record: CrossCoupledDesign) -> Json:
    velocity = list(record.feed_forward.values())
    return {
        "contour": record.contour,
        "velocity": velocity,
        "own": ["started", "error", "integral"],
    }


def _reads(record: CrossCoupledDesign) -> list[str]:
    own = ["error", *(["reference_rate"] if record.feed_forward else [])]
    return list(dict.fromkeys([*own, *record.inner_reads()]))


def _past(record: CrossCoupledDesign) -> list[Member]:
    error = Member("error", what="contour error of the sample before")
    return [STARTED, error, Member("integral")]


KIND = Kind(
    name="cross-coupled",
    no_rules="rule tables are but inside it, in its axes' controllers; c and fmu hold all of it",
    summary="a PID on the contour error beside axis controllers of any kind (Koren 1980)",
    record=CrossCoupledDesign,
    settings=CrossCoupledSettings,
    gains=CrossCoupledDesign.gains,
    controller=CrossCoupledDesign.controller,
    genome=later("hfc_design.controllers.cross_coupled.genome", "CrossCoupledGenome"),
    learnt=_learnt,
    inside=INSIDE,
    structure=OuterDesign.structure,
    path=True,
    reads=_reads,
    reach=CrossCoupledDesign.reach,
    saved=remembered(_past),
    c=Template((Path(__file__).parent / "templates",), _c),
    sections=later("hfc_design.controllers.cross_coupled.section", "sections"),
)
