"""Reads the tables that ``export.csv_tables`` writes for a feed drive's fuzzy controller."""

import csv
import io
from math import inf
from pathlib import Path

from hfc_design.core.records import TERMS
from hfc_design.formats.reading.system import (
    Input,
    Shape,
    System,
    add_rule,
    fault,
    input_of,
    number,
    place,
    trapezoid,
)

FILES = ("rules.csv", "error_terms.csv", "error_change_terms.csv")
HEADER = ["label", "left_BLU", "centre_BLU", "right_BLU"]

Rows = list[tuple[int, list[str]]]


def files(path: Path) -> list[Path]:
    """The tables of the folder ``path``, or beside the table ``path``.

    Raises:
        ValueError: there is no table of rules.
    """
    folder = path if path.is_dir() else path.parent
    if path.is_file() and path.name != FILES[0]:
        raise ValueError(f"has to be named {FILES[0]}, beside {FILES[1]} and {FILES[2]}")
    if not (folder / FILES[0]).is_file():
        raise ValueError(f"has no {FILES[0]}; a hierarchy's tables hold no terms to import")
    return [folder / name for name in FILES]


def read(texts: dict[str, str]) -> System:
    """The system in ``texts`` by file name.

    Raises:
        ValueError: a table is not complete.
    """
    inputs = []
    for name, file in zip(("error", "error_change"), FILES[1:], strict=True):
        try:
            inputs.append(_input(name, _rows(texts[file])))
        except ValueError as error:
            raise ValueError(f"{file}: {error}") from None
    system = System((inputs[0], inputs[1]), {})
    try:
        _read_rules(system, _rows(texts[FILES[0]]))
    except ValueError as error:
        raise ValueError(f"{FILES[0]}: {error}") from None
    return system


def _rows(text: str) -> Rows:
    """Lines that are not empty, and their cells."""
    reader = csv.reader(io.StringIO(text))
    try:
        return [(reader.line_num, [c.strip() for c in row]) for row in reader if any(row)]
    except csv.Error as error:
        raise fault(reader.line_num, str(error)) from None


def _input(name: str, rows: Rows) -> Input:
    header, *rest = rows or [(1, [])]
    if header[1] != HEADER:
        raise fault(header[0], f"the first line has to be {','.join(HEADER)}")
    return input_of(header[0], name, -inf, inf, [_shape(*row) for row in rest])


def _shape(line: int, cells: list[str]) -> Shape:
    if len(cells) != len(HEADER):
        raise fault(line, f"{len(cells)} cells; needed are {','.join(HEADER)}")
    label, left, centre, right = cells
    middle = number(line, centre)
    below = number(line, left) if left else -inf
    above = number(line, right) if right else inf
    return trapezoid(line, label, below, middle, middle, above)


def _read_rules(system: System, rows: Rows) -> None:
    rows_of, columns_of = ([term.label for term in item.terms] for item in system.inputs)
    (line, header), *rest = rows or [(1, [])]
    if len(header) != TERMS + 1:
        raise fault(line, f"{len(header)} cells; needed are a corner and {TERMS} labels")
    columns = [
        place(line, label, columns_of, "label in error_change_terms.csv") for label in header[1:]
    ]
    for number_of_line, (label, *cells) in rest:
        row = place(number_of_line, label, rows_of, "label in error_terms.csv")
        if len(cells) != TERMS:
            raise fault(number_of_line, f"{len(cells)} numbers; needed are {TERMS}")
        for column, cell in zip(columns, cells, strict=True):
            add_rule(system, number_of_line, (row, column), number(number_of_line, cell))
