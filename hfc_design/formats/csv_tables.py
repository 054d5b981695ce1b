"""Rule tables for a spreadsheet: one file a unit, and a manifest of how they are wired."""

from pathlib import Path

from hfc_design.files.design import Design
from hfc_design.formats.format import Format
from hfc_design.formats.writing import csv_text, rule_base, write_folder


def write(design: Design, path: Path) -> None:
    """Write the folder ``path`` with a table a file and ``manifest.csv``."""
    tables = rule_base(design).tables(design.controller)
    write_folder(path, {name: csv_text(rows) for name, rows in tables.items()})


FORMATS = (Format("csv", "a folder with one labelled rule table a unit, and manifest.csv", write),)
