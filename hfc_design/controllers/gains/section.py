"""What the page shows of a controller that says nothing else of itself: its numbers."""

from hfc_design.controllers.kind import ControllerRecord, Shown
from hfc_design.core.dotted import flat
from hfc_design.core.shapes import Json
from hfc_design.pictures.section import Listing, Section


def sections(record: ControllerRecord, shown: Shown) -> list[Section]:
    """The numbers by their names."""
    own: Json = record.model_dump(exclude={"kind", "sample_time_s"})
    found = {key.rpartition(".")[2]: value for key, value in flat(own).items()}
    rows = [[k, f"{x:.6g}"] for k, x in found.items() if isinstance(x, int | float)]
    listing = Listing(f"Gains of the kind {record.kind}.", ["gain", "value"], rows)
    return [Section("The controller", "", listing, [])]
