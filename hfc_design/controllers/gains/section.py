"""What the page shows of a controller that is a few gains."""

from hfc_design.files.design import Design
from hfc_design.pictures.section import Listing, Section


def sections(design: Design) -> list[Section]:
    """The gains by their names."""
    record = design.controller.model_dump()
    gains = record.get("gains") or record[record["kind"]]
    rows = [[name, f"{value:.6g}"] for name, value in gains.items()]
    listing = Listing(f"Gains of the kind {record['kind']}.", ["gain", "value"], rows)
    return [Section("The controller", "", listing, [])]
