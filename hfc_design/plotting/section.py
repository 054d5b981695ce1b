"""Parts of a page: figures, and sections with a table and figures under a heading."""

from collections.abc import Callable
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from hfc_design.core.tables import Table

Drawn = Callable[[], Figure]  # a figure once it is asked for


class Drawing(NamedTuple):
    """A figure with its alternative text and its caption."""

    figure: Figure
    alt: str
    caption: str
    cursor: Any = None  # numbers of ``controllers.surfaces`` for the cursor of a report


class Section(NamedTuple):
    """A part of the page under its own heading."""

    title: str
    text: str  # "" for none
    listing: Table | None
    drawings: list[Drawing]
