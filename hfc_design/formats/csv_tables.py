"""Rule tables for a spreadsheet: one file a unit, and a manifest of how they are wired."""

from hfc_design.files.design import Design
from hfc_design.formats.writing import Format, csv_text, rule_base


def tables(design: Design) -> dict[str, str]:
    """A table a file, and ``manifest.csv``."""
    found = rule_base(design).tables(design.controller)
    return {name: csv_text(rows) for name, rows in found.items()}


FORMATS = (Format("csv", "a folder with one labelled rule table a unit, and manifest.csv", tables),)
