"""Display of a record in a notebook: a line, or a small table in the style of the pages."""

from collections.abc import Mapping
from math import isfinite

from hfc_design.core.tables import MISSING, Table

Rows = Mapping[str, object]


def line(kind: str, rows: Rows) -> str:
    """Text ``kind(name=value, ...)``, numbers with four digits."""
    return f"{kind}({', '.join(f'{key}={_text(value, True)}' for key, value in rows.items())})"


def table(title: str, rows: Rows) -> str:
    """A table of two columns as HTML; its texts are escaped."""
    cells = [[key, _text(value)] for key, value in rows.items()]
    return Table(title, ("", ""), cells)._repr_html_()


def _text(value: object, quoted: bool = False) -> str:
    if isinstance(value, float):
        return f"{value:.4g}" if isfinite(value) else str(value)
    if isinstance(value, str):
        return repr(value) if quoted else value
    return MISSING if value is None and not quoted else str(value)
