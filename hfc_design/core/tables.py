"""Tables of results for terminals, pages, LaTeX and notebooks; display of records in notebooks."""

import re
from collections.abc import Collection, Mapping, Sequence
from html import escape
from math import isfinite
from typing import NamedTuple

Rows = Sequence[Sequence[str]]
Values = Mapping[str, object]  # name -> value of a field of a record

#: A missing number.
MISSING = "–"
#: A cell of a column of numbers, or the beginning of such a cell.
NUMERIC = re.compile(
    r"[<≤]? ?[-+±\u2212]?(\d|\.\d|[–∞])|(-|unstable|diverged|diverges|never|chaotic|breaks)?$"
)
#: A notebook shows no more rows than this; the rest is counted.
MOST = 40
STYLE = "border-collapse:collapse;font-variant-numeric:tabular-nums"
CELL = '<{} style="padding:.2rem .7rem;border-bottom:1px solid #ddd;text-align:{}">{}</{:.2}>'
SIDES = ('th scope="row"', "left;font-weight:normal"), ("td", "right")


class Table(NamedTuple):
    """A table of texts; its first column names the rows."""

    caption: str  # what it shows
    head: Sequence[str]
    rows: Rows
    best: Sequence[Collection[int]] = ()  # for each row the indices of its best cells; (): no marks
    title: str = ""  # text above the table on a terminal, instead of the caption below
    lines: Sequence[str] = ()  # sentences below the table
    key: str = ""  # explanation that the caption needs where the table is not on its page
    links: Sequence[str] = ()  # for each row the address to which its name links; "": no link

    @property
    def numeric(self) -> list[bool]:
        """For each column, whether it contains numbers."""
        return [
            k > 0 and head != "unit" and bool(cells) and all(map(NUMERIC.match, cells))
            for k, (head, *cells) in enumerate(zip(self.head, *self.rows, strict=True))
        ]

    def _repr_html_(self) -> str:
        shown = [self.head, *self.rows[:MOST]] if any(self.head) else self.rows[:MOST]
        rows = ("".join(_cell(cell, k > 0) for k, cell in enumerate(row)) for row in shown)
        body = "".join(f"<tr>{cells}</tr>" for cells in rows)
        rest = len(self.rows) - MOST
        below = f"<p>{rest} more</p>" if rest > 0 else ""
        about = f"<caption>{escape(self.title or self.caption)}</caption>"
        return f'<table style="{STYLE}">{about}{body}</table>{below}'


def text(*lines: str) -> Table:
    """Return a table of ``lines`` only, for text between tables."""
    return Table("", (), (), lines=lines)


def _cell(content: str, value: bool) -> str:
    tag, side = SIDES[value]
    return CELL.format(tag, side, escape(content), tag)


def line(kind: str, values: Values) -> str:
    """Return the text ``kind(name=value, ...)``, with floats of four digits."""
    return f"{kind}({', '.join(f'{key}={_text(value, True)}' for key, value in values.items())})"


def table(title: str, values: Values) -> str:
    """Return a table of names and values as HTML, with escaped texts."""
    cells = [[key, _text(value)] for key, value in values.items()]
    return Table(title, ("", ""), cells)._repr_html_()


def _text(value: object, quoted: bool = False) -> str:
    if isinstance(value, float):
        return f"{value:.4g}" if isfinite(value) else str(value)
    if isinstance(value, str):
        return repr(value) if quoted else value
    return MISSING if value is None and not quoted else str(value)
