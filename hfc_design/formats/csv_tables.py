"""Rule tables for a spreadsheet: one file a unit, and a manifest of how they are wired."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path

from hfc_design.controllers.flc.record import FuzzyRecord
from hfc_design.core.records import Table, UserError
from hfc_design.files.design import Design, HierarchicalDesign
from hfc_design.formats.writing import write_folder

Rows = list[list[str]]


def write(design: Design, path: Path) -> None:
    """Write the folder ``path`` with a table a file and ``manifest.csv``.

    A hierarchy gives ``unit-N.csv`` (rows: row term), a feed drive's fuzzy controller
    ``rules.csv`` (rows: error, columns: change of error) and its terms.

    Raises:
        UserError: the design has no rule tables.
        RunError: the folder cannot be written.
    """
    controller = design.controller
    if isinstance(controller, HierarchicalDesign):
        tables = _hierarchy(controller)
    elif isinstance(controller, FuzzyRecord):
        tables = _fuzzy(controller)
    else:
        raise UserError(f"design {design.name} is of kind {controller.kind}: no rule tables")
    write_folder(path, {name: _csv(rows) for name, rows in tables.items()})


def _hierarchy(controller: HierarchicalDesign) -> dict[str, Rows]:
    labels = [term.label for term in controller.terms]
    manifest = [["unit", "column_input", "row_input", "file"]]
    tables = {}
    for unit in controller.units:
        name = f"unit-{unit.id}.csv"
        corner = f"row {unit.row_input} \\ column {unit.column_input}"
        tables[name] = _table(corner, labels, unit.consequents)
        manifest.append([f"unit-{unit.id}", unit.column_input, unit.row_input, name])
    return tables | {"manifest.csv": manifest}


def _fuzzy(controller: FuzzyRecord) -> dict[str, Rows]:
    labels = [term.label for term in controller.error_terms]
    corner = "row error [BLU] \\ column error_change [BLU]"
    tables = {"rules.csv": _table(corner, labels, controller.rules.centroids)}
    manifest = [["unit", "column_input", "row_input", "file"]]
    manifest.append([controller.kind, "error_change", "error", "rules.csv"])
    for key in ("error_terms", "error_change_terms"):
        rows = [["label", "left_BLU", "centre_BLU", "right_BLU"]]
        for term in getattr(controller, key):
            edges = (term.left, term.centre, term.right)
            rows.append([term.label, *("" if edge is None else repr(edge) for edge in edges)])
        tables[f"{key}.csv"] = rows
    return tables | {"manifest.csv": manifest}


def _table(corner: str, labels: Sequence[str], table: Table) -> Rows:
    rows = [[label, *map(repr, row)] for label, row in zip(labels, table, strict=True)]
    return [[corner, *labels], *rows]


def _csv(rows: Rows) -> str:
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerows(rows)
    return buffer.getvalue()
