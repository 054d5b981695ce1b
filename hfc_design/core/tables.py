"""A table of a result, which writers show: terminal, page, LaTeX; records in a notebook."""

import re
from collections.abc import Collection, Mapping, Sequence
from html import escape
from math import isfinite
from typing import NamedTuple

Rows = Sequence[Sequence[str]]
Values = Mapping[str, object]  # of a record, by their names

#: A missing number.
MISSING = "–"
#: Cells that stand in a column of numbers, or their beginnings.
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
    best: Sequence[Collection[int]] = ()  # of each row the places of the best; () for none in all
    title: str = ""  # what a terminal shows above it, in place of the caption below it
    lines: Sequence[str] = ()  # sentences below it
    key: str = ""  # what the caption of a table without its page says beside it
    links: Sequence[str] = ()  # of each row the address that its name leads to; "" for none

    @property
    def numeric(self) -> list[bool]:
        """Whether each column holds numbers."""
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
    """Lines between tables."""
    return Table("", (), (), lines=lines)


def _cell(content: str, value: bool) -> str:
    tag, side = SIDES[value]
    return CELL.format(tag, side, escape(content), tag)


def line(kind: str, values: Values) -> str:
    """Text ``kind(name=value, ...)``, numbers with four digits."""
    return f"{kind}({', '.join(f'{key}={_text(value, True)}' for key, value in values.items())})"


def table(title: str, values: Values) -> str:
    """A table of two columns as HTML; its texts are escaped."""
    cells = [[key, _text(value)] for key, value in values.items()]
    return Table(title, ("", ""), cells)._repr_html_()


def _text(value: object, quoted: bool = False) -> str:
    if isinstance(value, float):
        return f"{value:.4g}" if isfinite(value) else str(value)
    if isinstance(value, str):
        return repr(value) if quoted else value
    return MISSING if value is None and not quoted else str(value)
