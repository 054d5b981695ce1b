"""What the page shows of a controller, whatever its kind."""

from math import isfinite
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


def score(value: float) -> str:
    """A fitness or a merit as people read it: of contour errors small, by Lin & Lee large."""
    if not isfinite(value):
        return "diverged"
    return f"{value:.1f}" if abs(value) >= 10 else f"{value:.4g}"
