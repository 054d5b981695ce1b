"""Pictures of what a design is, one at a time; its report has them all."""

from matplotlib.figure import Figure

from hfc_design.controllers.kind import needed
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.machine import PlantSettings
from hfc_design.runtime.explain import part


def picture(design: Design, what: str, unit: str | None = None, axis: str = "") -> Figure:
    """A picture of a design: "surface", "surface-3d", "terms", "tables" or "tree".

    As far as its kind has it, or that of a controller inside. ``unit`` is the fuzzy unit of a
    hierarchy, as in ``unit-1``, the root if none is named; ``axis`` that of a controller whose axes
    differ. Axes have the units of the plant.

    Raises:
        UserError: its kind has no such picture, or there is no such unit or axis.
    """
    own = part(design, axis)
    every = PlantSettings(**own.plant.model_dump()).each()
    drive = next((one for one in every if one.name == own.axis), every[0]).drive
    lacks = "it has no fuzzy units to draw; hfc stability --plot draws its loop, hfc report all"
    found = needed(own.kind.pictures, own, lacks)(own.controller, drive)
    if what not in found:
        raise UserError(f"{own.name} has no picture {what!r}; it has {', '.join(found)}")
    units = found[what]
    if unit is None:
        unit = [*units][-1]
    if unit not in units:
        known = ", ".join(filter(None, units)) or "no units"
        raise UserError(f"--unit {unit}: {what} of {own.name} has {known}")
    figure: Figure = units[unit]()
    return figure
