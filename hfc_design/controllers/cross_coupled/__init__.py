"""Axis controllers of any kind with a common controller of the contour error (Koren 1980)."""

from hfc_design.controllers.cross_coupled.law import CrossMemory
from hfc_design.controllers.cross_coupled.record import CrossCoupledDesign, CrossCoupledSettings
from hfc_design.controllers.kind import Kind, later
from hfc_design.controllers.per_axis import learnt


def _learnt(
    record: CrossCoupledDesign, axes: tuple[str, ...], memory: CrossMemory
) -> CrossCoupledDesign | None:
    """With what is inside as it has become."""
    inner = learnt(record.inner, axes, memory.inner)
    return record.model_copy(update={"inner": inner}) if inner else None


KIND = Kind(
    name="cross-coupled",
    summary="a PID on the contour error beside axis controllers of any kind (Koren 1980)",
    record=CrossCoupledDesign,
    settings=CrossCoupledSettings,
    gains=CrossCoupledDesign.gains,
    controller=CrossCoupledDesign.controller,
    genome=later("hfc_design.controllers.cross_coupled.genome", "CrossCoupledGenome"),
    learnt=_learnt,
    sections=later("hfc_design.controllers.cross_coupled.section", "sections"),
)
