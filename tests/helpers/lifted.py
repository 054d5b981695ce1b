"""Laws and designs as controllers of machines with so many axes."""

from hfc_design.controllers.controller import PerAxis
from hfc_design.files.loop_setup import population_of_one


def every_axis(kind, law, axes=1):
    """The controller with the same law on each axis."""
    return PerAxis(kind, (law,) * axes)


def controller_of(design, axes=("axis",)):
    """The controller of a design without limits, and its gains for a population of one."""
    kind, record = design.kind, design.controller
    controller = kind.controller_of(record, dict.fromkeys(axes))
    return controller, population_of_one(record.law_gains())
