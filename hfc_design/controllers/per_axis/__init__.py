"""A controller of its own for every axis, of any kinds, with gains of its own."""

from typing import Any

from hfc_design.controllers.controller import PerAxis
from hfc_design.controllers.kind import Kind, Limits, Shown, kinds, later
from hfc_design.controllers.per_axis.record import PerAxisDesign, PerAxisSettings
from hfc_design.core.records import UserError


def _controller(record: PerAxisDesign, limits: Limits) -> PerAxis:
    if tuple(record.axes) != tuple(limits):
        raise UserError(
            f"controller.axes: are {', '.join(record.axes)}; the machine has {', '.join(limits)}"
        )
    laws = (kinds().get(own.kind).law(own, limits[axis]) for axis, own in record.axes.items())
    return PerAxis("per-axis", tuple(laws), own_gains=True)


def _sections(record: PerAxisDesign, shown: Shown) -> list[Any]:
    """Those of each axis, with its name before their titles."""
    found = []
    for axis, own in record.axes.items():
        told = kinds().get(own.kind).sections(own, shown.of(axis))
        found += [section._replace(title=f"{axis.upper()}: {section.title}") for section in told]
    return found


KIND = Kind(
    name="per-axis",
    summary="a controller of its own for every axis of a machine",
    record=PerAxisDesign,
    settings=PerAxisSettings,
    gains=PerAxisDesign.gains,
    controller=_controller,
    genome=later("hfc_design.controllers.per_axis.genome", "PerAxisGenome"),
    axes=lambda record: record.axes,
    sections=_sections,
)
