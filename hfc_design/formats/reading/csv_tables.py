"""Reads the tables that ``export.csv_tables`` writes for a feed drive's fuzzy controller."""

import csv
import io
from collections.abc import Iterator
from contextlib import contextmanager
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
    """The tables of the folder ``path``, or beside it; ValueError: there is none of rules."""
    folder = path if path.is_dir() else path.parent
    if path.is_file() and path.name != FILES[0]:
        raise ValueError(f"has to be named {FILES[0]}, beside {FILES[1]} and {FILES[2]}")
    if not (folder / FILES[0]).is_file():
        raise ValueError(f"has no {FILES[0]}; a hierarchy's tables hold no terms to import")
    return [folder / name for name in FILES]


def read(texts: dict[str, str]) -> System:
    """The system in ``texts`` by file name; ValueError: a table is not complete."""
    with _in(FILES[1]):
        first = _input("error", _rows(texts[FILES[1]]))
    with _in(FILES[2]):
        second = _input("error_change", _rows(texts[FILES[2]]))
    with _in(FILES[0]):
        return _with_rules(System((first, second), {}), _rows(texts[FILES[0]]))


@contextmanager
def _in(file: str) -> Iterator[None]:
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from None


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


def _with_rules(system: System, rows: Rows) -> System:
    rows_of, columns_of = ([term.label for term in item.terms] for item in system.inputs)
    (line, header), *rest = rows or [(1, [])]
    if len(header) != TERMS + 1:
        raise fault(line, f"{len(header)} cells; needed are a corner and {TERMS} labels")
    where = "label in error_change_terms.csv"
    columns = [place(line, label, columns_of, where) for label in header[1:]]
    for line, (label, *cells) in rest:
        row = place(line, label, rows_of, "label in error_terms.csv")
        if len(cells) != TERMS:
            raise fault(line, f"{len(cells)} numbers; needed are {TERMS}")
        for column, cell in zip(columns, cells, strict=True):
            add_rule(system, line, (row, column), number(line, cell))
    return system
