"""What a script wants of a page for a paper."""

from pathlib import Path
from typing import TYPE_CHECKING

from hfc_design.core.records import UserError

if TYPE_CHECKING:
    from hfc_design.report.paper import Paper


def for_a_paper(
    folder: Path, stem: str, figures: str | None, width: str | None, latex: bool
) -> "Paper | None":
    """In folders that begin with a ``stem``; None where nothing is wanted.

    Raises:
        UserError: there is no such kind of figure or width, or a width without figures.
    """
    from hfc_design.report.paper import COLUMN, KINDS, Paper

    if figures is not None and figures not in KINDS:
        raise UserError(f"figures = {figures!r}: has to be one of {', '.join(KINDS)}")
    if width is not None and figures is None:
        raise UserError("width: is that of figures, as in figures='pdf'")
    if figures is None and not latex:
        return None
    drawn = folder / f"{stem}figures" if figures else None
    size = COLUMN if width is None else column(width)
    return Paper(figures or "", size, drawn, folder / f"{stem}latex" if latex else None)


def column(width: str) -> float:
    """A width in millimetres; UserError: it is none."""
    from hfc_design.report.paper import millimetres

    try:
        return millimetres(width)
    except (ValueError, TypeError):
        told = "a text with a number and a unit (mm, cm, in, pt), 40 to 400 mm in all"
        raise UserError(f"width = {width!r}: has to be {told}") from None
