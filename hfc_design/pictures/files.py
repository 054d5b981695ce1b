"""A figure as a file, or as the address of an image in a page."""

import base64
import io
import re
from pathlib import Path
from typing import Any
from urllib.parse import quote

import matplotlib
from matplotlib.figure import Figure

from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import UserError
from hfc_design.pictures.pgf import picture

#: File suffix -> metadata that keep the date out of the file.
FORMATS: dict[str, dict[str, Any]] = {
    "png": {},
    "svg": {"Date": None},
    "pdf": {"CreationDate": None},
}
#: Text stays text: a file is much smaller, and can be searched; publishers refuse fonts of Type 3.
SETTINGS: Any = {"svg.hashsalt": "hfc-design", "svg.fonttype": "none", "pdf.fonttype": 42}


def save(figure: Figure, path: Path) -> None:
    """Write a figure; the suffix of the file says whether png, svg or pdf.

    Raises:
        UserError: another suffix.
        RunError: the file cannot be written.
    """
    write_whole(path, image(figure, kind_of(path)))


def kind_of(path: Path) -> str:
    """The one in ``FORMATS`` that the suffix of a file says; UserError: it says another."""
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        raise UserError(f"{path}: a plot has to end in .png, .svg or .pdf")
    return kind


def image(figure: Figure, kind: str, dpi: float = 160.0) -> bytes:
    """The figure as a file of a kind in ``FORMATS``, or as pgf; the same gives the same bytes."""
    if kind == "pgf":
        return picture(figure)
    buffer = io.BytesIO()
    with matplotlib.rc_context(SETTINGS):
        figure.savefig(buffer, format=kind, dpi=dpi, metadata=FORMATS[kind])
    return buffer.getvalue()


def address(figure: Figure) -> str:
    """A figure as the address of an image, so that its names cannot clash with a page's."""
    return "data:image/svg+xml;base64," + base64.b64encode(image(figure, "svg")).decode()


def small_svg(figure: Figure) -> str:
    """A figure as SVG in few letters: curves to a hundredth of a point, text as it is."""
    svg = image(figure, "svg").decode()
    for pattern, by in _SMALLER:
        svg = pattern.sub(by, svg)
    return svg


def small_address(figure: Figure) -> str:
    """The same as the address of an image, in a third of the letters."""
    return "data:image/svg+xml," + quote(small_svg(figure), safe=" /:=;,()!*'-._~")


def _rounded(curve: re.Match[str]) -> str:
    """What a path says, in fewer letters."""
    numbers = (
        x if x.isalpha() else f"{float(x):.2f}".rstrip("0").rstrip(".") for x in curve[1].split()
    )
    return f' d="{_LETTER.sub(lambda found: found[1], ",".join(numbers))}"'


_LETTER = re.compile(r",?([A-Za-z]),?")
#: What stands in a picture of matplotlib's and nobody sees -> what is left of it.
_SMALLER: tuple[tuple[re.Pattern[str], Any], ...] = (
    (re.compile(r"<metadata>.*</metadata>", re.DOTALL), ""),
    (re.compile(r"'DejaVu Sans', [^;\"]*sans-serif"), "'DejaVu Sans', sans-serif"),
    (re.compile(r'\sd="([^"]*)"'), _rounded),
    (re.compile(r"\n\s*"), " "),
)
