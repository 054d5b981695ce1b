"""Sections of the report page of dynamic compensation."""

from hfc_design.controllers.dynamic_compensation.record import CompensationDesign
from hfc_design.controllers.kind import ReportContext
from hfc_design.core.tables import Table
from hfc_design.plotting.section import Section

ABOUT = (
    "To the command of its controller each axis adds one in proportion to its error, to "
    "the excess of the length of all errors over a dead zone, and to the speed along the "
    "path (Lin & Gai 2009, eq. 3 to 6). The length adds mm and deg."
)


def sections(record: CompensationDesign, shown: ReportContext) -> list[Section]:
    """Return the gains with units, then the sections of the inner controllers."""
    rows = [["dead zone, e_max", f"{record.dead_zone:.6g}", "units of the errors"]]
    along = ", ".join(axis.upper() for axis in record.path_axes) or "all axes"
    speed = f"programmed speed, v, of {along}"
    rows.append([speed, f"{record.programmed_speed:.6g}", "units of the errors/s"])
    for (axis, gain), drive in zip(record.k_p.items(), shown.machine.drives, strict=True):
        unit = f"{drive.units['command']}/{drive.units['error']}"
        rows.append([f"gain of {axis.upper()}, k_p", f"{gain:.6g}", unit])
    listing = Table("Compensation of the tracking error.", ["number", "value", "unit"], rows)
    inner = record.inner.sections(shown)
    return [Section("Dynamic compensation", ABOUT, listing, []), *inner]
