"""Compensation of the tracking errors of a machine beside any controller (Lin & Gai 2009)."""

from hfc_design.controllers.dynamic_compensation.record import (
    CompensationDesign,
    CompensationSettings,
)
from hfc_design.controllers.kind import Kind, later

KIND = Kind(
    name="dynamic-compensation",
    summary="any controllers, and beside them what the length of all errors asks for (Lin & Gai)",
    record=CompensationDesign,
    settings=CompensationSettings,
    gains=CompensationDesign.gains,
    controller=CompensationDesign.controller,
    genome=later("hfc_design.controllers.dynamic_compensation.genome", "CompensationGenome"),
    sections=later("hfc_design.controllers.dynamic_compensation.section", "sections"),
)
