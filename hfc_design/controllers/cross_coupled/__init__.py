"""Axis controllers of any kind with a common controller of the contour error (Koren 1980)."""

from hfc_design.controllers.cross_coupled.record import CrossCoupledDesign, CrossCoupledSettings
from hfc_design.controllers.kind import Kind, later

KIND = Kind(
    name="cross-coupled",
    summary="a PID on the contour error beside axis controllers of any kind (Koren 1980)",
    record=CrossCoupledDesign,
    settings=CrossCoupledSettings,
    gains=CrossCoupledDesign.gains,
    controller=CrossCoupledDesign.controller,
    genome=later("hfc_design.controllers.cross_coupled.genome", "CrossCoupledGenome"),
    sections=later("hfc_design.controllers.cross_coupled.section", "sections"),
)
