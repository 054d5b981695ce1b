"""A figure as a file, as the address of an image in a page, and in a notebook."""

import base64
import io
import re
from pathlib import Path
from typing import Any
from urllib.parse import quote

import matplotlib
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_pgf import RendererPgf
from matplotlib.figure import Figure

from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import UserError
from hfc_design.plotting.latex import escaped

#: File suffix -> metadata that keep the date out of the file.
FORMATS: dict[str, dict[str, Any]] = {
    "png": {},
    "svg": {"Date": None},
    "pdf": {"CreationDate": None},
}
#: Text stays text, for small files that can be searched; publishers refuse fonts of Type 3.
SETTINGS: Any = {"svg.hashsalt": "hfc-design", "svg.fonttype": "none", "pdf.fonttype": 42}


def save(figure: Figure, path: Path) -> None:
    """Write a figure as png, svg or pdf, according to the suffix of the file.

    Raises:
        UserError: the suffix is another one.
        RunError: the file cannot be written.
    """
    write_whole(path, image(figure, kind_of(path)))


def kind_of(path: Path) -> str:
    """Return the kind in ``FORMATS`` of a file's suffix; UserError: the suffix is another one."""
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        raise UserError(f"{path}: must end in .png, .svg or .pdf")
    return kind


HEAD = r"""% A figure of hfc-design. In the preamble: \usepackage{pgf}
\begingroup%
\makeatletter%
\providecommand\mathdefault[1]{#1}%
\begin{pgfpicture}%
"""
TAIL = r"""\end{pgfpicture}%
\makeatother%
\endgroup%
"""


class Renderer(RendererPgf):
    """Matplotlib's renderer with escaped texts that are measured without TeX.

    Matplotlib's canvas for this format has a TeX program measure every text. Here matplotlib's own
    letters are measured instead, so that TeX need not be installed. Texts are placed at their
    anchors, so that only surrounding boxes, such as a legend, have the size of those letters.
    """

    def draw_text(self, gc, x, y, s, prop, angle, ismath=False, mtext=None):  # type: ignore[no-untyped-def]
        """Draw a text; matplotlib's own parser has checked every command of its formulas."""
        parts = re.split(r"(?<!\\)\$", s) if ismath else [s]
        texts = (f"${part}$" if k % 2 else escaped(part) for k, part in enumerate(parts))
        super().draw_text(gc, x, y, "".join(texts), prop, angle, ismath, mtext)

    def get_text_width_height_descent(self, s, prop, ismath):  # type: ignore[no-untyped-def]
        """Measure a text in matplotlib's letters."""
        return RendererBase.get_text_width_height_descent(self, s, prop, ismath)

    def draw_image(self, gc, x, y, im, transform=None):  # type: ignore[no-untyped-def]
        """Refuse an image, which would be a file of its own."""
        raise UserError("a figure with an image cannot be a pgf; use pdf")


def picture(figure: Figure) -> bytes:
    r"""Return a PGF picture, which a paper includes by ``\input`` in its own fonts.

    The same figure gives the same bytes.

    Raises:
        UserError: the figure contains an image.
    """
    file = io.StringIO()
    width, height = figure.get_size_inches()
    file.write(HEAD)
    file.write(
        rf"\pgfpathrectangle{{\pgfpointorigin}}{{\pgfqpoint{{{width:f}in}}{{{height:f}in}}}}%"
        "\n\\pgfusepath{use as bounding box, clip}%\n"
    )
    figure.draw(Renderer(figure, file))
    file.write(TAIL)
    return file.getvalue().encode()


def image(figure: Figure, kind: str, dpi: float = 160.0) -> bytes:
    """Return a figure as a file of a ``kind``: ``FORMATS`` or pgf; equal figures, equal bytes."""
    if kind == "pgf":
        return picture(figure)
    buffer = io.BytesIO()
    with matplotlib.rc_context(SETTINGS):
        figure.savefig(buffer, format=kind, dpi=dpi, metadata=FORMATS[kind])
    return buffer.getvalue()


def address(figure: Figure) -> str:
    """Return a figure as the address of an image; its names cannot clash with those of a page."""
    return "data:image/svg+xml;base64," + base64.b64encode(image(figure, "svg")).decode()


def small_svg(figure: Figure) -> str:
    """Return a figure as compact SVG: curves to a hundredth of a point, texts as texts."""
    svg = image(figure, "svg").decode()
    for pattern, by in _SMALLER:
        svg = pattern.sub(by, svg)
    return svg


def small_address(figure: Figure) -> str:
    """Return the compact SVG as the address of an image, a third as long as ``address``."""
    return "data:image/svg+xml," + quote(small_svg(figure), safe=" /:=;,()!*'-._~")


def _rounded(curve: re.Match[str]) -> str:
    """Return the commands of a path with rounded numbers."""
    numbers = (
        x if x.isalpha() else f"{float(x):.2f}".rstrip("0").rstrip(".") for x in curve[1].split()
    )
    return f' d="{_LETTER.sub(lambda match: match[1], ",".join(numbers))}"'


_LETTER = re.compile(r",?([A-Za-z]),?")
#: Invisible parts of an SVG of matplotlib -> their replacement.
_SMALLER: tuple[tuple[re.Pattern[str], Any], ...] = (
    (re.compile(r"<metadata>.*</metadata>", re.DOTALL), ""),
    (re.compile(r"'DejaVu Sans', [^;\"]*sans-serif"), "'DejaVu Sans', sans-serif"),
    (re.compile(r'\sd="([^"]*)"'), _rounded),
    (re.compile(r"\n\s*"), " "),
)

#: Letters of an SVG above which a PNG may be smaller, and the resolution of the PNG [1/in].
LARGE, FINE = 50_000, 110.0


class Displayed(Figure):
    """A figure that a notebook displays below a cell in few bytes: as SVG, or else as PNG."""

    def _repr_mimebundle_(self, **options: Any) -> tuple[dict[str, str], dict[str, Any]]:
        svg = small_svg(self)
        if len(svg) > LARGE:
            png = base64.b64encode(image(self, "png", FINE)).decode()
            if len(png) < len(svg):
                width = {"width": round(self.get_figwidth() * self.get_dpi())}
                return {"image/png": png, "text/plain": repr(self)}, {"image/png": width}
        return {"image/svg+xml": svg, "text/plain": repr(self)}, {}
