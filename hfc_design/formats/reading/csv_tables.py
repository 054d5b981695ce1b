"""Reads the tables that ``export.csv_tables`` writes for a feed drive's fuzzy controller."""

import csv
import io
from math import inf
from os.path import isdir, isfile
from pathlib import Path

from hfc_design.core.records import TERMS
from hfc_design.formats.reading.system import Input, Shape, System, Token, input_of, shape_of

FILES = ("rules.csv", "error_terms.csv", "error_change_terms.csv")
HEADER = ["label", "left_BLU", "centre_BLU", "right_BLU"]

Rows = list[list[Token]]


def files(path: Path) -> list[Path]:
    """The tables of the folder ``path``, or beside it; ValueError: there is none of rules."""
    folder = path if isdir(path) else path.parent
    if isfile(path) and path.name != FILES[0]:
        raise ValueError(f"has to be named {FILES[0]}, beside {FILES[1]} and {FILES[2]}")
    if not isfile(folder / FILES[0]):
        raise ValueError(f"has no {FILES[0]}; a hierarchy's tables hold no terms to import")
    return [folder / name for name in FILES]


def read(*texts: str) -> System:
    """The system in the texts of ``FILES``; ValueError: a table is not complete."""
    rules, first, second = map(_rows, FILES, texts)
    system = System((_input("error", first), _input("error_change", second)), {})
    error, change = (item.labels for item in system.inputs)
    header, *rest = rules
    if len(header) != TERMS + 1:
        told = f"{len(header)} cells; needed are a corner and {TERMS} labels"
        raise header[0].fault(told)
    columns = [label.place(change, f"label in {FILES[2]}") for label in header[1:]]
    for label, *cells in rest:
        row = label.place(error, f"label in {FILES[1]}")
        if len(cells) != TERMS:
            raise label.fault(f"{len(cells)} numbers; needed are {TERMS}")
        for column, cell in zip(columns, cells, strict=True):
            system.add(cell, (row, column), cell.number())
    return system


def _rows(file: str, text: str) -> Rows:
    """The cells of the lines that are not empty, at least one."""
    reader = csv.reader(io.StringIO(text))
    try:
        rows = [[Token(reader.line_num, c.strip(), file) for c in r] for r in reader if any(r)]
    except csv.Error as error:
        raise Token(reader.line_num, "", file).fault(str(error)) from None
    return rows or [[Token(1, "", file)]]


def _input(name: str, rows: Rows) -> Input:
    header, *rest = rows
    if [cell.text for cell in header] != HEADER:
        raise header[0].fault(f"the first line has to be {','.join(HEADER)}")
    return input_of(header[0]._replace(text=name), -inf, inf, [_shape(cells) for cells in rest])


def _shape(cells: list[Token]) -> Shape:
    if len(cells) != len(HEADER):
        raise cells[0].fault(f"{len(cells)} cells; needed are {','.join(HEADER)}")
    label, left, centre, right = cells
    middle = centre.number()
    below = left.number() if left.text else -inf
    above = right.number() if right.text else inf
    return shape_of(label, "Triangle", "abbc", (below, middle, above))
