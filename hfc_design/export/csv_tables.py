"""Rule tables for a spreadsheet: one file a unit, and a manifest of how they are wired."""

import csv
import io
from pathlib import Path

from hfc_design.checkpoint import write_whole
from hfc_design.records import RunError, UserError
from hfc_design.rulebase import Design, HierarchicalDesign


def write(design: Design, path: Path) -> None:
    """Write the folder ``path`` with ``unit-N.csv`` (rows: row term) and ``manifest.csv``.

    Raises:
        UserError: the design has no rule tables.
        RunError: the folder cannot be written.
    """
    controller = design.controller
    if not isinstance(controller, HierarchicalDesign):
        raise UserError(f"design {design.name} is of kind {controller.kind}: no rule tables")
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"{path}: cannot be written: {error.strerror or error}") from None
    labels = [term.label for term in controller.terms]
    manifest = [["unit", "column_input", "row_input", "file"]]
    for unit in controller.units:
        name = f"unit-{unit.id}.csv"
        corner = f"row {unit.row_input} \\ column {unit.column_input}"
        rows = [[corner, *labels]]
        rows += [
            [label, *map(repr, row)] for label, row in zip(labels, unit.consequents, strict=True)
        ]
        manifest.append([f"unit-{unit.id}", unit.column_input, unit.row_input, name])
        write_whole(path / name, _csv(rows))
    write_whole(path / "manifest.csv", _csv(manifest))


def _csv(rows: list[list[str]]) -> bytes:
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerows(rows)
    return buffer.getvalue().encode()
