"""How a figure is framed, drawn and becomes a file.

Every picture is a ``matplotlib.figure.Figure`` of its own; none touches pyplot. They are narrow on
purpose: they are to be read on a phone too.
"""

import base64
import io
import re
from collections.abc import Callable, Sequence
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from numpy.typing import NDArray

from hfc_design.core.checkpoint import write_whole
from hfc_design.core.numbers import Floats
from hfc_design.core.records import TERMS, UserError

Rows = list[list[str]]  # of a table
Drawn = Callable[[], Figure]  # a figure once it is asked for
WIDTH = 5.4  # of every figure [in]
ROOM = 6  # characters of a number beside a y axis
LABEL = 52  # letters; a longer label is cut off, the table has all of it
LARGEST = 1e100  # number that is drawn as it is; matplotlib's axes fail far beyond
DEEPEST = 1e-6  # share of the largest number to which a logarithmic axis goes down
# Okabe and Ito's colours, which stay apart for a colour-blind reader.
OWN, OTHER = "#0072B2", "#B34F00"
#: File suffix -> metadata that keep the date out of the file.
FORMATS: dict[str, dict[str, Any]] = {
    "png": {},
    "svg": {"Date": None},
    "pdf": {"CreationDate": None},
}


def save(figure: Figure, path: Path) -> None:
    """Write a figure; the suffix of the file says whether png, svg or pdf.

    Raises:
        UserError: another suffix.
        RunError: the file cannot be written.
    """
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        raise UserError(f"{path}: a plot has to end in .png, .svg or .pdf")
    write_whole(path, image(figure, kind))


def image(figure: Figure, kind: str) -> bytes:
    """The figure as a file of a kind in ``FORMATS``; the same figure gives the same bytes."""
    buffer = io.BytesIO()
    # Text stays text: the file is much smaller, and can be searched.
    with matplotlib.rc_context({"svg.hashsalt": "hfc-design", "svg.fonttype": "none"}):
        figure.savefig(buffer, format=kind, dpi=160, metadata=FORMATS[kind])
    return buffer.getvalue()


def address(figure: Figure) -> str:
    """A figure as the address of an image, so that its names cannot clash with a page's."""
    return "data:image/svg+xml;base64," + base64.b64encode(image(figure, "svg")).decode()


def small_address(figure: Figure) -> str:
    """The same in a third of the letters: curves to a hundredth of a point, text as it is."""
    svg = image(figure, "svg").decode()
    for pattern, by in _SMALLER:
        svg = pattern.sub(by, svg)
    return "data:image/svg+xml," + quote(svg, safe=" /:=;,()!*'-._~")


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


def framed(
    height: float, top: float, left: float = 0.9, right: float = 0.15, bottom: float = 0.5
) -> Figure:
    """A figure with margins in inches; measuring the labels would draw everything twice."""
    figure = Figure(figsize=(WIDTH, height))
    figure.subplots_adjust(
        left=left / WIDTH, right=1 - right / WIDTH, bottom=bottom / height, top=1 - top / height
    )
    return figure


def gridded(axes: Axes, x: str = "", y: str = "", color: str = "0.9") -> None:
    """Label the axes and draw a grid behind the curves."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(color=color)
    axes.set_axisbelow(True)


def finish(axes: Axes, label: str, x: str = "") -> None:
    """The same, with the label of the y axis at a fixed place, which long numbers leave free."""
    gridded(axes, x, label)
    axes.yaxis.set_label_coords(-0.155, 0.5)
    numbers = axes.yaxis.get_major_formatter().format_ticks(list(axes.get_yticks()))
    if any(len(number) > ROOM for number in numbers):
        axes.ticklabel_format(axis="y", scilimits=(0, 0))  # a power of ten stands above
        axes.yaxis.get_offset_text().set(ha="right", fontsize=8)


def logarithmic(axes: Axes) -> None:
    """A logarithmic y axis with plain numbers, unless the data lie close together.

    What is smaller than ``DEEPEST`` of the largest, zeros too, is drawn at the lower edge, which
    the picture says: an error is at times 0, and rounding is not worth twelve decades.
    """
    values = np.concatenate([line.get_ydata() for line in axes.lines])
    positive = values[values > 0]
    if (values < 0).any() or len(positive) == 0 or positive.max() < 5 * positive.min():
        return
    least = max(positive.min(), DEEPEST * positive.max())
    floor = 10.0 ** np.floor(np.log10(least))
    many = positive.max() > 500 * least
    axes.set_yscale("log")
    if (values < floor).any():
        for line in axes.lines:
            line.set_ydata(np.maximum(line.get_ydata(), floor))
        axes.relim()
        axes.set_ylim(bottom=floor)
        axes.text(
            0.99, 0.02, f"at the edge: {floor:g} and less", **_INSIDE, transform=axes.transAxes
        )
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0,) if many else (1.0, 2.0, 5.0)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


#: How a note stands in the lower right corner of a picture.
_INSIDE: dict[str, Any] = {"ha": "right", "va": "bottom", "fontsize": 8, "color": "0.3"}


def plain(label: str, longest: int = LABEL) -> str:
    """A label that every font has the letters for."""
    known = label.replace("–", "-").encode("latin-1", "replace").decode("latin-1")
    known = "".join(letter if letter.isprintable() else "?" for letter in known)
    return known if len(known) <= longest else known[: longest - 3] + "..."


def above(figure: Figure, axes: Axes, size: float = 9.0, columns: int = 2) -> None:
    """The legend of ``axes`` above everything; names in it may be any."""
    handles = axes.get_legend_handles_labels()
    legend = figure.legend(
        *handles, fontsize=size, frameon=False, ncols=columns, loc="upper center"
    )
    for text in legend.get_texts():
        text.set_parse_math(False)


def drawable(values: Any) -> NDArray[Any]:
    """The numbers as a picture shows them: none beyond ``LARGEST``, 0 below its inverse."""
    seen = np.where(np.abs(values) < 1.0 / LARGEST, 0, values)
    return np.asarray(np.clip(seen, -LARGEST, LARGEST))


def round_above(value: float) -> float:
    """The smallest of 1, 2, 5 times a power of ten that is not below a positive value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * next((step for step in (1, 2, 5) if step * power >= value), 10))


#: Units that have names for a thousandth and a millionth, in which small numbers are read.
SMALLER = {
    unit: tuple(
        (factor, f"{prefix}{unit}") for factor, prefix in ((1e6, "µ"), (1e3, "m"), (1.0, ""))
    )
    for unit in ("rad", "rad/s", "m", "m/s", "V")
} | {unit: ((1e3, unit.replace("mm", "µm")), (1.0, unit)) for unit in ("mm", "mm/s")}


def readable(unit: str, size: float) -> tuple[float, str]:
    """Factor and unit that make of a number of a ``size`` one that needs no power of ten."""
    steps = SMALLER.get(unit, ((1.0, unit),))
    return next((step for step in steps if abs(size) * step[0] < 1e3), steps[-1])


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
    cursor: Any = None  # of ``controllers.surfaces``: what a report tells under a cursor on it


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


def heat_map(
    values: Floats,
    labels: tuple[Sequence[str], Sequence[str]],
    row: str,
    column: str,
    title: str,
    meaning: str,
    shades: Floats | None = None,
) -> Figure:
    """A table with a number in every cell, its first row on top as the papers print it.

    Args:
        values: what is written.
        labels: names of the terms of the rows' input, and of the columns'.
        row: name of the input of the rows.
        column: name of the input of the columns.
        title: stands above.
        meaning: what the colours stand for, with its unit.
        shades: what is coloured; without it the values.
    """
    figure = framed(4.0, top=0.35, right=0.95)
    axes = figure.subplots()
    shades = values if shades is None else shades
    limit = float(np.abs(shades).max()) or 1.0
    largest = np.abs(values).max()
    decimals = 2 if largest < 10 else 1 if largest < 100 else 0
    rows, columns = (np.arange(len(of) + 1) - 0.5 for of in labels)
    mesh = axes.pcolormesh(columns, rows, shades, cmap="RdBu_r", vmin=-limit, vmax=limit)
    size = 9 if len(labels[1]) <= TERMS else 7
    for (i, j), value in np.ndenumerate(values):
        color = "white" if abs(shades[i, j]) > 0.6 * limit else "black"
        text = f"{value:z.{decimals}f}".replace("-", "\u2212")
        axes.text(j, i, text, ha="center", va="center", fontsize=size, color=color)
    axes.set_xticks(range(len(labels[1])), labels[1])
    axes.set_yticks(range(len(labels[0])), labels[0])
    axes.tick_params(length=0)
    axes.invert_yaxis()
    axes.set(xlabel=column, ylabel=row)
    axes.set_title(title, fontsize=11)
    colour_strip(figure, axes, mesh, meaning).outline.set_visible(False)
    return figure


def colour_strip(figure: Figure, axes: Axes, drawn: Any, meaning: str, **options: Any) -> Colorbar:
    """What the colours of a picture stand for, in the margin on its right."""
    place = axes.get_position()
    strip = figure.add_axes((place.x1 + 0.02, place.y0, 0.03, place.height))
    return figure.colorbar(drawn, cax=strip, label=meaning, **options)
