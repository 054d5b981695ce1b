"""Reader of the CSV tables that ``hfc export`` writes of a feed drive's fuzzy controller."""

import csv
import io
import re
from collections.abc import Iterator
from math import inf
from os.path import isdir, isfile
from pathlib import Path
from shlex import quote

from hfc_design.controllers.kinds import KINDS
from hfc_design.core.records import option
from hfc_design.formats.reading import system
from hfc_design.formats.reading.system import Input, Shape, System, Token

FILES = ("rules.csv", "error_terms.csv", "error_change_terms.csv")
#: Optional files: names of the rules' singletons, and of the output.
OTHERS = ("labels.csv", "manifest.csv")
CORNER = re.compile(r"row (\S+) \[BLU\] \\ column (\S+) \[BLU\]")
HEADER = ["label", "left_BLU", "centre_BLU", "right_BLU"]

SIGNALS = ("error", "error_change")

Rows = list[list[Token]]


def files(path: Path) -> list[Path]:
    """Return the files in the folder ``path``, or beside the file; ValueError: no rules.csv."""
    folder = path if isdir(path) else path.parent
    if isfile(path) and path.name != FILES[0]:
        raise ValueError(f"must be named {FILES[0]}, next to {FILES[1]} and {FILES[2]}")
    if not isfile(folder / FILES[0]):
        raise ValueError(f"has no {FILES[0]}; {_instead(folder)}")
    others = [name for name in OTHERS if isfile(folder / name)]
    return [folder / name for name in (*FILES, *others)]


def _instead(folder: Path) -> str:
    """Return advice on a folder without rules.csv."""
    each = folder.iterdir() if isdir(folder) else ()  # isdir is false for impossible names
    others = sorted(one.name for one in each if one.suffix.lower() in (".fll", ".fis"))
    if not others:
        return "the tables of a hierarchy contain no terms to import"
    command = f"hfc import {quote((folder / others[0]).as_posix())}"
    if len(others) == 1:
        return f"import a single file of an engine, as in {command}"
    message = f"its {len(others)} files are the units of a hierarchy"
    return f"{message}; import each alone, {command}, or all together from {option('to', 'json')}"


def read(texts: dict[str, str]) -> System:
    """Return the system in ``texts`` (file name -> text); ValueError: a table is wrong."""
    tables = {name: _rows(name, text) for name, text in texts.items()}
    rules, first, second = (tables[name] for name in FILES)
    corner = CORNER.fullmatch(rules[0][0].text)
    names = corner.groups() if corner else SIGNALS
    inputs = _input(names[0], first), _input(names[1], second)
    # For an output without a name the manifest has the name of a kind, or nothing.
    rows = tables.get("manifest.csv", [])
    named = [row[0].text for row in rows if row[-1].text == FILES[0]]
    unnamed = len(named) == 1 and named[0] not in KINDS.known
    output = system.Output(named[0] if unnamed else "")
    read_system = System("", inputs, output, {}, SIGNALS)
    labels = {}
    if "labels.csv" in tables:
        labels = {place: cell.text for place, cell in _cells(tables["labels.csv"], inputs)}
    for place, cell in _cells(rules, inputs):
        read_system.add(cell, place, system.Singleton(labels.get(place, ""), cell.number()))
    return read_system


def _cells(table: Rows, inputs: tuple[Input, Input]) -> Iterator[tuple[tuple[int, int], Token]]:
    """Yield the indices of both terms, and the cell, of each rule."""
    error, change = (item.labels for item in inputs)
    header, *rest = table
    if len(header) != len(change) + 1:
        message = f"must have a corner and {len(change)} labels (got {len(header)} cells)"
        raise header[0].fault(message)
    columns = [label.place(change, f"label in {FILES[2]}") for label in header[1:]]
    for label, *cells in rest:
        row = label.place(error, f"label in {FILES[1]}")
        if len(cells) != len(change):
            raise label.fault(f"must have {len(change)} numbers (got {len(cells)})")
        for column, cell in zip(columns, cells, strict=True):
            yield (row, column), cell


def _rows(file: str, text: str) -> Rows:
    """Return the cells of lines that are not empty; for an empty file, one empty cell."""
    reader = csv.reader(io.StringIO(text))
    try:
        rows = [[Token(reader.line_num, c.strip(), file) for c in r] for r in reader if any(r)]
    except csv.Error as error:
        raise Token(reader.line_num, "", file).fault(str(error)) from None
    return rows or [[Token(1, "", file)]]


def _input(name: str, rows: Rows) -> Input:
    header, *rest = rows
    if [cell.text for cell in header] != HEADER:
        raise header[0].fault(f"the first line must be {','.join(HEADER)}")
    return system.input_of(
        header[0]._replace(text=name), -inf, inf, [_shape(cells) for cells in rest]
    )


def _shape(cells: list[Token]) -> Shape:
    if len(cells) != len(HEADER):
        raise cells[0].fault(f"must have the cells {','.join(HEADER)} (got {len(cells)} cells)")
    label, left, centre, right = cells
    middle = centre.number()
    below = left.number() if left.text else -inf
    above = right.number() if right.text else inf
    return system.shape_of(label, "Triangle", "abbc", (below, middle, above))
