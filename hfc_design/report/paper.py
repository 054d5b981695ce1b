"""Figures and tables of a page as files for a paper."""

import re
from pathlib import Path
from typing import NamedTuple

from matplotlib.figure import Figure

from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import UserError, option
from hfc_design.formats.writing import write
from hfc_design.plotting.column import in_column
from hfc_design.plotting.files import image
from hfc_design.plotting.latex import latex
from hfc_design.report import Page

#: Millimetres in an inch.
INCH = 25.4
KINDS = "pdf", "svg", "pgf"
#: Column of most two-column journals, and allowed widths [mm].
COLUMN, LEAST, MOST = 88.9, 40.0, 400.0
#: Units of a width -> millimetres; a point is TeX's.
MILLIMETRES = {"mm": 1.0, "cm": 10.0, "in": INCH, "pt": INCH / 72.27}
WIDTH = re.compile(rf"(\d+(?:\.\d*)?|\.\d+) ?({'|'.join(MILLIMETRES)})")


def column(width: str) -> float:
    """Return, in mm, a width such as 88mm, 3.5in or 252pt; UserError: it is no allowed width."""
    match = WIDTH.fullmatch(width) if isinstance(width, str) else None
    size = float(match[1]) * MILLIMETRES[match[2]] if match else 0.0
    if not LEAST <= size <= MOST:
        units = ", ".join(MILLIMETRES)
        allowed = f"a number with a unit ({units}), as in '88mm', {LEAST:g} to {MOST:g} mm in total"
        raise UserError(f"{option('width', width)}: must be {allowed}")
    return size


class Paper(NamedTuple):
    """Selection of the parts of a page for a paper, and their folders."""

    kind: str  # of the files of figures: pdf, svg or pgf
    width: float  # of a column [mm]
    figures: Path | None  # folder; None: no figures
    tables: Path | None  # folder; None: no tables

    def write(self, page: Page) -> list[Path]:
        """Write the selected parts and return their folders; this resizes figures of the ``page``.

        Raises:
            UserError: a figure contains an image, which a pgf cannot have.
            RunError: a folder cannot be written.
        """
        if self.figures is not None:
            write(self.figures, dict(map(self._file, page.figures, page.figures.values())))
        if self.tables is not None:
            texts = {
                f"{name}.tex": latex(name, table, page.of, page.label)
                for name, table in page.tables.items()
            }
            write(self.tables, texts)
        return [path for path in (self.figures, self.tables) if path is not None]

    def _file(self, name: str, figure: Figure) -> tuple[str, bytes]:
        """Return the name and the content of the file of a figure."""
        in_column(figure, self.width / INCH)
        try:
            return f"{name}.{self.kind}", image(figure, self.kind)
        except UserError as error:
            raise error.within(name) from None


def write_with_parts(path: Path, page: Page, paper: Paper | None) -> None:
    """Write a page, and the parts of it that ``paper`` selects; RunError: it cannot be written."""
    write_whole(path, page.html)
    if paper:
        paper.write(page)


def for_a_paper(
    folder: Path,
    stem: str = "",
    figures: str | None = None,
    width: str | None = None,
    latex: bool = False,
) -> Paper | None:
    """Return the parts of a page for a paper; their folders are in ``folder``; None: no parts.

    Args:
        figures: "pdf", "svg" or "pgf": also write every figure as a file of this kind, sized for a
            column of a paper.
        width: width of these figures, as in 88mm, 3.5in or 252pt; default: 3.5in.
        latex: also write every table in LaTeX.

    Raises:
        UserError: the kind of figure or the width is invalid, or a width is given without figures.
    """
    if figures is not None and figures not in KINDS:
        raise UserError(f"{option('figures', figures)}: must be one of {', '.join(KINDS)}")
    if width is not None and figures is None:
        raise UserError(f"{option('width')}: applies to figures; add {option('figures', 'pdf')}")
    if figures is None and not latex:
        return None
    drawn = folder / f"{stem}figures" if figures else None
    size = COLUMN if width is None else column(width)
    return Paper(figures or "", size, drawn, folder / f"{stem}latex" if latex else None)
