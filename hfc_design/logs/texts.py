"""Logs as text: CSV of any program, and what LinuxCNC's halscope and halsampler write."""

import csv
import re
from collections.abc import Sequence
from itertools import zip_longest
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats
from hfc_design.logs.log import Log

#: What may stand between columns; a comma is tried last, for it may stand in numbers too.
SEPARATORS = ("\t", ";", ",")
#: First line of halscope, and of its older versions: the period of the samples.
SCOPE = re.compile(r"# Sampling period is (\d{1,12}) ns\s*")
OLD_SCOPE = re.compile(r"Sampling period is (\d{1,12}) nSec\s*")
#: What halsampler writes where samples were lost.
OVERRUN = "overrun"
#: Columns of a file without names are called so.
UNNAMED = "column_{}"


class Rows(NamedTuple):
    """Lines with where they stand in their file."""

    lines: list[str]
    places: list[int]  # number of each line, from 1


def text_log(text: str) -> Log:
    """The log that a text is.

    Raises:
        ValueError: it is none, with the line that says why.
    """
    lines = text.splitlines()
    first = lines[0] if lines else ""
    if found := SCOPE.fullmatch(first):
        return _scope(lines[1:], 1e-9 * int(found[1]))
    if found := OLD_SCOPE.fullmatch(first):
        return _old_scope(lines[1:], 1e-9 * int(found[1]))
    return _table(lines)


def _scope(lines: list[str], sample_time: float) -> Log:
    """halscope: names and numbers between semicolons, settings behind ``#``."""
    if not lines:
        raise ValueError("line 2: has no names of the channels")
    names = lines[0].split(";")
    found = _numbers(_rows(lines[1:], 3), ";", len(names))
    return Log(_named(names, found), sample_time, format="halscope")


def _old_scope(lines: list[str], sample_time: float) -> Log:
    """halscope before 2.9: ``name value`` pairs, a line for a sample or for a channel."""
    columns: dict[str, list[str]] = {}
    for line in lines:
        words = line.split()
        for name, value in zip_longest(words[::2], words[1::2], fillvalue=""):
            columns.setdefault(name, []).append(value)
    table = [[*row] for row in zip_longest(*columns.values(), fillvalue="")]
    if table and "" in table[-1]:  # it writes the first channel once more at the end
        table.pop()
    found = _numbers(_rows([";".join(row) for row in table], 2), ";", len(columns))
    return Log(_named([*columns], found), sample_time, format="halscope (older)")


def _table(lines: list[str]) -> Log:
    """Columns with or without names; halsampler's has neither names nor separators."""
    rows, breaks = _rows(lines, 1), []
    if lost := [k for k, line in enumerate(rows.lines) if line.strip() == OVERRUN]:
        breaks = [k - n for n, k in enumerate(lost)]
        left_out = {*lost}
        kept = [k for k in range(len(rows.lines)) if k not in left_out]
        rows = Rows([rows.lines[k] for k in kept], [rows.places[k] for k in kept])
    if not rows.lines:
        raise ValueError("has no samples")
    separator = _separator(rows.lines)
    head = _cells(rows.lines[0], separator)
    named = any(_number(cell) is None for cell in head)
    if named:
        rows = Rows(rows.lines[1:], rows.places[1:])
    names = head if named else [UNNAMED.format(k + 1) for k in range(len(head))]
    found = _numbers(rows, separator, len(names))
    missing = None
    if breaks:
        missing = np.zeros(len(found), bool)
        missing[[k for k in breaks if k < len(found)]] = True
    plain = separator is None and not named
    return Log(_named(names, found), None, missing, "halsampler" if plain else "CSV")


def _rows(lines: Sequence[str], first: int) -> Rows:
    """What is neither empty nor a comment; ``first`` is the number of the first line."""
    kept = [(x, k) for k, x in enumerate(lines, first) if x.strip() and not x.startswith("#")]
    return Rows([line for line, _ in kept], [place for _, place in kept])


def _separator(lines: Sequence[str]) -> str | None:
    """What stands between the columns of most of the first lines; None: blanks."""
    some = lines[:20]
    for separator in SEPARATORS:
        if all(separator in line for line in some):
            return separator
    return None


def _cells(line: str, separator: str | None) -> list[str]:
    """What stands in a line; quoted, a separator is a letter like others."""
    if separator is None or '"' not in line:
        return [cell.strip() for cell in line.split(separator)]
    try:
        (cells,) = csv.reader([line], delimiter=separator, skipinitialspace=True)
    except csv.Error as error:
        raise ValueError(f"{line[:40]!r} is no line of a table: {error}") from None
    return [cell.strip() for cell in cells]


def _number(text: str) -> float | None:
    """None: it is none, or one that only Python writes."""
    try:
        return None if "_" in text else float(text)
    except ValueError:
        return None


def _numbers(rows: Rows, separator: str | None, columns: int) -> Floats:
    """(rows, columns); a comma in a number is a decimal point where semicolons part them."""
    lines = rows.lines
    if not lines:
        raise ValueError("has no samples")
    if separator in (";", "\t") and any("," in line for line in lines[:20]):
        lines = [line.replace(",", ".") for line in lines]
    try:
        found = np.loadtxt(lines, delimiter=separator, ndmin=2, comments=None, quotechar='"')
        if found.shape[1] == columns and np.isfinite(found).all():
            return np.asarray(found, float)
    except ValueError:
        pass
    for line, place in zip(lines, rows.places, strict=True):  # which line it is
        cells = _cells(line, separator)
        if len(cells) != columns:
            raise ValueError(f"line {place}: has {len(cells)} columns, the first one {columns}")
        for cell in cells:
            value = _number(cell)
            if value is None or not np.isfinite(value):
                raise ValueError(f"line {place}: {cell[:40]!r} is no finite number")
    raise ValueError("is no table of numbers")


def _named(names: Sequence[str], table: Floats) -> dict[str, Floats]:
    """The columns by their names, which have to differ."""
    cleaned = [name.strip() or UNNAMED.format(k + 1) for k, name in enumerate(names)]
    for name in cleaned:
        if cleaned.count(name) > 1:
            raise ValueError(f"two columns are called {name[:60]!r}")
        if not name.isprintable() or len(name) > 200:
            raise ValueError(
                f"{name[:40]!r} is no name of a column: printable, 200 letters at most"
            )
    return dict(zip(cleaned, table.T, strict=True))
