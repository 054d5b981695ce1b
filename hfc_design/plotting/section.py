"""Parts of a page: tables, figures, and sections with both under a heading."""

from collections.abc import Callable, Collection, Sequence
from typing import Any, NamedTuple

from matplotlib.figure import Figure

Rows = list[list[str]]  # of a table
Drawn = Callable[[], Figure]  # a figure once it is asked for


class Listing(NamedTuple):
    """A table; its first column names the rows."""

    caption: str
    head: list[str]
    rows: Rows
    best: Sequence[Collection[int]] = ()  # of each row the places of the best; () for none in all


class Drawing(NamedTuple):
    """A figure with its alternative text and its caption."""

    figure: Figure
    alt: str
    caption: str
    cursor: Any = None  # of ``controllers.surfaces``: what a report tells under a cursor on it


class Section(NamedTuple):
    """A part of the page under its own heading."""

    title: str
    text: str  # "" for none
    listing: Listing | None
    drawings: list[Drawing]
