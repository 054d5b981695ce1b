"""Display of a record in a notebook: a line, or a small table in the style of the pages."""

from collections.abc import Mapping
from html import escape
from math import isfinite

#: A table has no more rows than this; the rest is counted.
MOST = 40
STYLE = "border-collapse:collapse;font-variant-numeric:tabular-nums"
CELL = "padding:.2rem .7rem;border-bottom:1px solid #ddd;text-align:{}"

Rows = Mapping[str, object]


def line(kind: str, rows: Rows) -> str:
    """Text ``kind(name=value, ...)``, numbers with four digits."""
    return f"{kind}({', '.join(f'{key}={_text(value, True)}' for key, value in rows.items())})"


def table(title: str, rows: Rows) -> str:
    """A table of two columns as HTML; its texts are escaped."""
    shown = list(rows.items())[:MOST]
    cells = [
        f'<tr><th scope="row" style="{CELL.format("left")};font-weight:normal">{escape(key)}</th>'
        f'<td style="{CELL.format("right")}">{escape(_text(value))}</td></tr>'
        for key, value in shown
    ]
    rest = len(rows) - len(shown)
    below = f"<p>{rest} more</p>" if rest else ""
    return (
        f'<table style="{STYLE}"><caption>{escape(title)}</caption>{"".join(cells)}</table>{below}'
    )


def _text(value: object, quoted: bool = False) -> str:
    if isinstance(value, float):
        return f"{value:.4g}" if isfinite(value) else str(value)
    if isinstance(value, str):
        return repr(value) if quoted else value
    return "–" if value is None and not quoted else str(value)
