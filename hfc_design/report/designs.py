"""Single pictures of a design; its report contains all of them."""

from matplotlib.figure import Figure

from hfc_design.controllers.kind import require
from hfc_design.core.records import UserError, option
from hfc_design.files.design import AnyDesign
from hfc_design.files.loop_setup import load_design
from hfc_design.runtime.explain import axis_of, part


def picture(design: AnyDesign, what: str, unit: str | None = None, axis: str = "") -> Figure:
    """Return a picture of a design as a figure, as ``hfc plot`` draws it.

    ``what`` is "surface", "surface-3d", "terms", "tables" or "tree", if the kind of the controller,
    or of one inside it, has this picture; ``unit`` is the fuzzy unit of a hierarchy, as in
    "unit-1"; default: the root. ``axis`` selects one of a controller whose axes differ. Axes have
    the units of the plant.

    Raises:
        UserError: the kind has no such picture, or there is no such unit or axis.
    """
    shown = part(load_design(design), axis)
    lacks = "it has no fuzzy units to draw; use hfc stability --plot for its loop, or hfc report"
    known = require(shown.kind.pictures, shown, lacks)(shown.controller, axis_of(shown).drive)
    if what not in known:
        raise UserError(f"{shown.name} has no picture {what!r}; available: {', '.join(known)}")
    units = known[what]
    if unit is None:
        unit = [*units][-1]
    if unit not in units:
        has = ", ".join(filter(None, units)) or "no units"
        raise UserError(f"{option('unit', unit)}: {what} of {shown.name} has {has}")
    figure: Figure = units[unit]()
    return figure
