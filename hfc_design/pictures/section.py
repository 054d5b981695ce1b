"""What the page shows of a controller, whatever its kind."""

from typing import NamedTuple

from matplotlib.figure import Figure

Rows = list[list[str]]


class Listing(NamedTuple):
    """A table; its first column names the rows."""

    caption: str
    head: list[str]
    rows: Rows


class Drawing(NamedTuple):
    """A figure, what it is for those who cannot see it, and its caption."""

    figure: Figure
    alt: str
    caption: str


class Section(NamedTuple):
    """A part of the page under its own heading."""

    title: str
    text: str  # "" for none
    listing: Listing | None
    drawings: list[Drawing]


def score(fitness: float) -> str:
    """A fitness as people read it: contour errors make small ones, Lin & Lee's are large."""
    return f"{fitness:.1f}" if fitness >= 10 else f"{fitness:.4g}"
