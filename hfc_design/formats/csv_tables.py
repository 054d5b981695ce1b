"""Rule tables for a spreadsheet: one file a unit, and a manifest of how they are wired."""

import csv
import io
from pathlib import Path

from hfc_design.controllers.rules import Rows
from hfc_design.files.design import Design
from hfc_design.formats.format import Format
from hfc_design.formats.units import rule_base
from hfc_design.formats.writing import write_folder


def write(design: Design, path: Path) -> None:
    """Write the folder ``path`` with a table a file and ``manifest.csv``.

    Raises:
        UserError: the design has no rule tables.
        RunError: the folder cannot be written.
    """
    tables = rule_base(design).tables(design.controller)
    write_folder(path, {name: csv_text(rows) for name, rows in tables.items()})


def csv_text(rows: Rows) -> str:
    """Rows as CSV."""
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerows(rows)
    return buffer.getvalue()


FORMATS = (Format("csv", "a folder with one labelled rule table a unit, and manifest.csv", write),)
