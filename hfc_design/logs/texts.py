"""Logs as text: CSV of any program, and the formats of halscope and halsampler."""

import csv
import re
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from hfc_design.core.numbers import Floats, number_of, number_or_none
from hfc_design.logs.columns import MOST_COLUMNS, TOLD, Log, is_unit
from plants import in_a_name

#: Possible separators; the comma is tried last, since it may also be part of numbers.
SEPARATORS = ("\t", ";", ",")
#: First line of a file for spreadsheets, which names the separator.
SAID = re.compile(r'"?sep=([\t;,])"?', re.IGNORECASE)
#: First line of halscope, and of its older versions: the period of the samples.
SCOPE = re.compile(r"# Sampling period is ([0-9]{1,12}) ns\s*")
OLD_SCOPE = re.compile(r"Sampling period is ([0-9]{1,12}) nSec\s*")
#: Line of halsampler where samples were lost.
OVERRUN = "overrun"
#: Name of columns in a file without names.
UNNAMED = "column_{}"
#: Number of lines from the middle of a file, away from its head, that determine the columns.
LOOKED_AT = 20
#: Texts that stand in place of the unit of a column without one.
NO_UNIT = frozenset({"", "-", "1", "[]", "[-]", "[1]"})


#: Lines, each with its number in the file, from 1.
Rows: TypeAlias = list[tuple[int, str]]


class Form(NamedTuple):
    """Format of the rows of a table."""

    separator: str | None  # None: blanks
    columns: int
    numeric: list[int]  # indices of the columns that hold numbers

    def cells(self, line: str) -> list[str]:
        """Return the cells of a line; a quoted separator is an ordinary character."""
        if self.separator is None or '"' not in line:
            return [cell.strip() for cell in line.split(self.separator)]
        try:
            (cells,) = csv.reader([line], delimiter=self.separator, skipinitialspace=True)
        except csv.Error as error:
            raise ValueError(f"{line[:40]!r} is not a line of a table: {error}") from None
        return [cell.strip() for cell in cells]

    @property
    def commas(self) -> bool:
        """True if a comma may be a decimal sign: semicolons or tabs separate the columns."""
        return self.separator in (";", "\t")

    def pointed(self, text: str) -> str:
        """Return the text with decimal points in place of decimal commas."""
        return text.replace(",", ".") if self.commas else text

    def number(self, cell: str) -> float | None:
        """Return the number in a cell, also with a decimal comma; None: it is not a number."""
        return number_or_none(self.pointed(cell))

    def is_data(self, line: str) -> bool:
        """Return True for a complete row, with a number in every numeric column."""
        cells = self.cells(line)
        whole = len(cells) == self.columns
        return whole and all(self.number(cells[k]) is not None for k in self.numeric)


def text_log(text: str) -> Log:
    """Return the log in a text; ValueError: why it is none, if possible with the line."""
    lines = text.splitlines()
    first = lines[0] if lines else ""
    if match := SCOPE.fullmatch(first):
        return _scope(lines[1:], 1e-9 * int(match[1]))
    if match := OLD_SCOPE.fullmatch(first):
        return _old_scope(_rows(lines[1:], 2), 1e-9 * int(match[1]))
    if match := SAID.fullmatch(first):
        return _table(_rows(lines[1:], 2), match[1])
    return _table(_rows(lines, 1), None)


def _scope(lines: list[str], sample_time: float) -> Log:
    """Return a log of halscope: names, then numbers, between semicolons; # begins a comment."""
    if not lines:
        raise ValueError("line 2: must have the names of the channels")
    names = lines[0].split(";")
    form = Form(";", len(names), [*range(len(names))])
    numbers = _numbers(_rows(lines[1:], 3), form, names)
    return Log(_named(names, numbers), sample_time, format="halscope")


def _old_scope(rows: Rows, sample_time: float) -> Log:
    """Return a log of halscope before 2.9: pairs ``name value``, by samples or by channels."""
    pairs = list[tuple[str, float, int]]()
    for place, line in rows:
        words = line.split()
        if len(words) % 2:
            raise ValueError(f"line {place}: must be names of channels, each with its value")
        for name, value in zip(words[::2], words[1::2], strict=True):
            pairs.append((name, at_line(place, value), place))
    counts = Counter(name for name, _, _ in pairs)
    if not counts:
        raise ValueError("must have samples")
    names, by_sample = [*counts], len(pairs) > 1 and pairs[1][0] != pairs[0][0]
    if by_sample and len(pairs) % len(names) == 1 and pairs[-1][0] == names[0]:
        counts[pairs.pop()[0]] -= 1  # halscope writes the first channel once more at the end
    steps, count = counts[names[0]], len(names)
    for k, (name, _, place) in enumerate(pairs if by_sample else []):
        if name != (wanted := names[k % count]):
            raise ValueError(f"line {place}: {name[:40]} must be {wanted[:40]}: a value is missing")
    for name in names:
        if counts[name] != steps:
            counted = f"{name[:40]} has {counts[name]} values, {names[0][:40]} {steps}"
            raise ValueError(f"{counted}: one is missing")
    table = np.array([value for _, value, _ in pairs])
    table = table.reshape(steps, count) if by_sample else table.reshape(count, steps).T
    return Log(_named(names, table), sample_time, format="halscope (older)")


def _table(rows: Rows, separator: str | None) -> Log:
    """Return the log in a table with or without names; those of halsampler have no names."""
    lost = [place for place, line in rows if line.strip() == OVERRUN]
    rows = [(place, line) for place, line in rows if line.strip() != OVERRUN]
    form = _form([line for _, line in rows], separator)
    whole = (k for k, (_, line) in enumerate(rows) if form.is_data(line))
    begin = next(whole, len(rows) // 2)
    head, data = rows[:begin], rows[begin:]
    if not head:
        form = form._replace(numeric=[*range(form.columns)])  # without names all are numbers
    names = _names(head, form)
    table = _numbers(data, form, names)
    missing = None
    if lost:
        missing = np.zeros(len(table), bool)
        places = np.searchsorted([place for place, _ in data], lost)
        missing[[k for k in places if k < len(table)]] = True
    texts = tuple(name for k, name in enumerate(names) if k not in form.numeric and name)
    columns = _named([names[k] for k in form.numeric], table, form.numeric)
    plain = form.separator is None and not head
    return Log(columns, None, missing, "halsampler" if plain else "CSV", texts)


def _rows(lines: Sequence[str], first: int) -> Rows:
    """Return lines that are neither empty nor comments; the first line has the number ``first``."""
    return [(k, x) for k, x in enumerate(lines, first) if x.strip() and not x.startswith("#")]


def _form(lines: Sequence[str], separator: str | None) -> Form:
    """Return the format of most of the lines in the middle of a file."""
    if not lines:
        raise ValueError("must have samples")
    some = lines[len(lines) // 2 :][:LOOKED_AT]
    if separator is None:
        most = (x for x in SEPARATORS if 2 * sum(x in line for line in some) > len(some))
        separator = next(most, None)
    form = Form(separator, 0, [])
    cells = [form.cells(line) for line in some]
    columns, _ = Counter(map(len, cells)).most_common(1)[0]
    if columns > MOST_COLUMNS:
        raise ValueError(f"must have at most {MOST_COLUMNS} columns (got {columns})")
    whole = [row for row in cells if len(row) == columns]
    has = [sum(form.number(row[k]) is not None for row in whole) for k in range(columns)]
    numeric = [k for k in range(columns) if 2 * has[k] >= len(whole)]
    if not numeric:
        raise ValueError("must have samples")
    return Form(separator, columns, numeric)


def _names(head: Rows, form: Form) -> list[str]:
    """Return the column names above the numbers, with units if a line between has them."""
    if not head:
        return [UNNAMED.format(k + 1) for k in range(form.columns)]
    above = list[list[str]]()
    for _, line in reversed(head):
        cells = form.cells(line)
        while len(cells) > 1 and not cells[-1]:
            cells.pop()
        if any(cells) and not max(form.numeric) < len(cells) <= form.columns:
            break
        if any(cells):
            above.append(cells + [""] * (form.columns - len(cells)))
    place, last = head[-1]
    if not above:
        many = len(form.cells(last))
        raise ValueError(f"line {place}: has {many} columns, the next one {form.columns}")
    said = [cell for cell in above[0] if form.number(cell) is not None]
    if said and (len(above) > 1 or said[0] == above[0][0]):  # numbers, one of them is damaged
        wrong = next(x for x in above[0] if form.number(x) is None)
        raise ValueError(f"line {place}: {wrong[:40]!r} must be a finite number")
    units = [x.strip("[]()") for x in above[0] if x not in NO_UNIT]
    if len(above) > 1 and 2 * sum(map(is_unit, units)) >= max(len(units), 1):
        return [*map(with_unit, above[1], above[0])]
    return above[0]


def with_unit(name: str, unit: str) -> str:
    """Return ``name [unit]``, or the name alone if it contains the unit or there is no unit."""
    bare = unit.strip("[]()")
    known = unit in NO_UNIT or TOLD.fullmatch(name) or name.endswith(f"_{in_a_name(bare)}")
    return name if known else f"{name} [{bare}]"


def at_line(place: int, text: str) -> float:
    """Return the number in a ``text`` of line ``place``; ValueError: it is not a number."""
    try:
        return number_of(text)
    except ValueError as error:
        raise ValueError(f"line {place}: {error}") from None


def _numbers(rows: Rows, form: Form, names: Sequence[str]) -> Floats:
    """Return the numbers (rows, numeric columns) of a table; ValueError: a line is wrong."""
    if not rows:
        raise ValueError("must have samples")
    lines = [line for _, line in rows]
    pointed = [form.pointed(line) for line in lines]
    every = len(form.numeric) == form.columns
    mixed = pointed != lines and any("." in line for line in lines)
    try:
        table = np.loadtxt(
            pointed, delimiter=form.separator, ndmin=2, comments=None, quotechar='"',
            usecols=None if every else form.numeric,
        )  # fmt: skip
        damaged = table.shape[1] != len(form.numeric) or not np.isfinite(table).all()
    except ValueError:
        damaged = True
    if damaged or mixed or not every:
        _check(rows, form, names, damaged)
    if damaged:
        raise ValueError("is not a table of numbers")
    return np.asarray(table, float)


def _check(rows: Rows, form: Form, names: Sequence[str], damaged: bool) -> None:
    """Check that all lines are alike; ValueError: one differs, and the message names it.

    It has another number of columns, another decimal sign, a number in a column of texts, or (this
    is checked if the table is ``damaged``) no number in a numeric column.
    """
    signs = dict[str, int]()  # decimal sign -> first line that has it
    texts = [k for k in range(form.columns) if k not in form.numeric]
    for place, line in rows:
        cells = form.cells(line)
        if len(cells) != form.columns:
            raise ValueError(f"line {place}: has {len(cells)} columns, the others {form.columns}")
        for k in texts:
            if form.number(cells[k]) is not None:
                message = f"column {names[k][:60] or k + 1} has a number here"
                raise ValueError(f"line {place}: {message}, and none in other lines")
        for sign in ",." if form.commas else "":
            if any(sign in cells[k] for k in form.numeric):
                signs.setdefault(sign, place)
        if len(signs) == 2:
            both = f"line {signs[',']}: has a comma in a number, line {signs['.']} a point"
            raise ValueError(f"{both}; all numbers must have the same decimal sign")
        for k in form.numeric if damaged else ():
            at_line(place, form.pointed(cells[k]))


def _named(
    names: Sequence[str], table: Floats, places: Sequence[int] | None = None
) -> dict[str, Floats]:
    """Return columns by distinct names; one without a name is numbered as ``places`` says."""
    where = range(len(names)) if places is None else places
    cleaned = [x.strip() or UNNAMED.format(k + 1) for x, k in zip(names, where, strict=True)]
    for name, count in Counter(cleaned).items():
        if count > 1:
            raise ValueError(f"columns must have different names (got {name[:60]!r} twice)")
        if not name.isprintable() or len(name) > 200:
            allowed = "must have at most 200 printable characters"
            raise ValueError(f"the name of a column {allowed} (got {name[:40]!r})")
    return dict(zip(cleaned, table.T, strict=True))
