"""Sections of the report page of a cross-coupled controller."""

from hfc_design.controllers.cross_coupled.record import CrossCoupledDesign
from hfc_design.controllers.kind import ReportContext
from hfc_design.core.tables import Table
from hfc_design.plotting.section import Section

ABOUT = (
    "The command of each axis is the sum of its axis controller, the feed-forward of the "
    "reference velocity, and its share of the command against the contour error, along "
    "the normal of the path."
)
CAPTION = "Gains on the contour error, positive to the left of the motion, and fed forward."


def sections(record: CrossCoupledDesign, shown: ReportContext) -> list[Section]:
    """Return the gains with units, then the sections of the inner controllers."""
    position, command = shown.units["error"], shown.units["command"]
    units = (f"{command}/{position}", f"{command}/({position} s)", f"{command} s/{position}")
    names = ("contour error, k_p", "its integral, k_i", "its rate, k_d")
    gains = zip(names, dict(record.contour).values(), units, strict=True)
    rows = [[name, f"{gain:.6g}", unit] for name, gain, unit in gains]
    for axis, gain in record.feed_forward.items():
        rows.append([f"velocity of {axis}, fed forward", f"{gain:.6g}", units[-1]])
    listing = Table(CAPTION, ["gain on", "value", "unit"], rows)
    inner = record.inner.sections(shown)
    return [Section("Cross-coupling", ABOUT, listing, []), *inner]
