"""Frames of figures, and common properties of their axes.

Every picture is a ``matplotlib.figure.Figure`` of its own; none uses pyplot. They are narrow so
that they are legible on a phone too.
"""

from collections import Counter
from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from numpy.typing import NDArray

from hfc_design.plotting.files import Displayed

WIDTH = 5.4  # of every figure [in]
ROOM = 6  # characters of a number beside a y axis
STRIP = 1.0  # margin on the right for a strip of colours with numbers and a label [in]
LABEL = 52  # letters of a label; a longer one is cut off, but a table shows it in full
LARGEST = 1e100  # number that is drawn unchanged; matplotlib's axes fail far beyond
DEEPEST = 1e-6  # share of the largest number to which a logarithmic axis goes down
# Okabe and Ito's colours, which stay apart for a colour-blind reader.
OWN, OTHER = "#0072B2", "#B34F00"
#: Colours of curves: without yellow, which is hard to see on white, and black as the last.
COLOURS = (OWN, "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
STYLES = ("-", "--", "-.", ":")
#: Height of a line of a legend of ``list_above`` [in].
LINE = 0.16


def framed(
    height: float, top: float, left: float = 0.9, right: float = 0.15, bottom: float = 0.5
) -> Figure:
    """Return a figure with margins [in]; automatic margins would draw everything twice."""
    figure = Displayed(figsize=(WIDTH, height))
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
    """As ``gridded``, with the y axis' label at a fixed place that leaves room for long numbers."""
    gridded(axes, x, label)
    axes.yaxis.set_label_coords(-0.155, 0.5)
    numbers = axes.yaxis.get_major_formatter().format_ticks(list(axes.get_yticks()))
    if any(len(number) > ROOM for number in numbers):
        axes.ticklabel_format(axis="y", scilimits=(0, 0))
    # A power of ten stands inside; above it would lie on the frame of the next panel.
    axes.yaxis.get_offset_text().set(x=0.01, ha="left", va="top", fontsize=8)
    vars(axes.yaxis)["OFFSETTEXTPAD"] = -1


def logarithmic(axes: Axes) -> None:
    """Make the y axis logarithmic with plain numbers, unless data are negative or close together.

    Values below ``DEEPEST`` of the largest, including zeros, are drawn at the lower edge, with a
    note in the picture: errors of 0 or of rounding would add many useless decades.
    """
    values = np.concatenate([line.get_ydata() for line in axes.lines])
    positive = values[values > 0]
    if (values < 0).any() or len(positive) == 0 or positive.max() < 5 * positive.min():
        return
    least = max(positive.min(), DEEPEST * positive.max())
    floor = 10.0 ** np.floor(np.log10(least))
    lowest = floor if (values < floor).any() else least
    many = positive.max() > 500 * lowest
    powers = lowest < 1e-4 or positive.max() >= 1e5  # :g would use powers for some numbers only
    axes.set_yscale("log")
    if (values < floor).any():
        for line in axes.lines:
            line.set_ydata(np.maximum(line.get_ydata(), floor))
        axes.relim()
        axes.set_ylim(bottom=floor)
        note = f"edge: {_tick(floor, powers)} or less"
        axes.text(0.99, 0.02, note, **_INSIDE, transform=axes.transAxes)
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0,) if many else (1.0, 2.0, 5.0)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: _tick(value, powers)))


def _tick(value: float, power: bool) -> str:
    """Return the text of a number on a logarithmic axis, with a power of ten if ``power``."""
    if not power or value <= 0.0:
        return f"{value:g}"
    mantissa, exponent = f"{value:.0e}".split("e")
    return f"{mantissa}e{int(exponent)}"


#: Placement of a note in the lower right corner of a picture.
_INSIDE: dict[str, Any] = {"ha": "right", "va": "bottom", "fontsize": 7.5, "color": "0.3"}


def plain(label: str, longest: int = LABEL) -> str:
    """Return a label with only letters that every font has, cut off after ``longest`` letters."""
    known = label.replace("–", "-").encode("latin-1", "replace").decode("latin-1")
    known = "".join(letter if letter.isprintable() else "?" for letter in known)
    return known if len(known) <= longest else known[: longest - 3] + "..."


def distinct(names: Iterable[str], longest: int = LABEL) -> dict[str, str]:
    """Return a distinct label for each name; long names with the same beginning keep their ends."""
    shortened = {name: plain(name, longest) for name in names}
    ends = {name: f"...{plain(name, len(name) + 3)[3 - longest :]}" for name in shortened}
    same = Counter(shortened.values())
    shortened |= {name: ends[name] for name, label in shortened.items() if same[label] > 1}
    same = Counter(shortened.values())
    return {
        name: f"{k}: {plain(label, longest - 4)}" if same[label] > 1 else label
        for k, (name, label) in enumerate(shortened.items(), 1)
    }


def above(figure: Figure, axes: Axes, size: float = 9.0, columns: int = 2, **where: Any) -> None:
    """Place the legend of ``axes`` above everything, or at ``where``; names are not formulas."""
    look: dict[str, Any] = {"frameon": False, "loc": "upper center", **where}
    handles = axes.get_legend_handles_labels()
    legend = figure.legend(*handles, fontsize=size, ncols=columns, **look)
    for text in legend.get_texts():
        text.set_parse_math(False)


def list_above(figure: Figure) -> None:
    """Place the legend above everything, with a line of the height ``LINE`` for each name."""
    where: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (0.9 / WIDTH, 1)}
    where |= {"borderaxespad": 0.2, "borderpad": 0, "labelspacing": 0.2}
    above(figure, figure.axes[0], columns=1, **where)


def colour(k: int) -> str:
    """Return the colour of a curve by its number, from 0."""
    return COLOURS[k % len(COLOURS)]


def stroke(k: int) -> dict[str, Any]:
    """Return colour, width and dashes of a curve by its number, distinguishable in grey too.

    The first curve is meant to lie below all later ones, and is broader; later curves have gaps
    through which it is visible.
    """
    return {"color": colour(k), "lw": 1.2 if k else 1.9, "ls": STYLES[k % len(STYLES)]}


def label_margin(labels: Iterable[str], size: float) -> float:
    """Return the margin [in] for labels of ``size`` [pt] and several lines beside a y axis."""
    letters = FontProperties(size=size)
    lines = [line for label in labels for line in label.splitlines()]
    widths = (text_to_path.get_text_width_height_descent(x, letters, False)[0] for x in lines)
    return (
        0.2 + 1.1 * max(widths, default=0.0) / 72.0
    )  # in a paper margins shrink more than letters


def drawable(values: Any) -> NDArray[Any]:
    """Return values limited to ``LARGEST``; values below the inverse of ``LARGEST`` become 0."""
    seen = np.where(np.abs(values) < 1.0 / LARGEST, 0, values)
    return np.asarray(np.clip(seen, -LARGEST, LARGEST))


def round_above(value: float) -> float:
    """Return the smallest of 1, 2, 5 times a power of ten that is not below a positive value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * next((step for step in (1, 2, 5) if step * power >= value), 10))


def colour_strip(figure: Figure, axes: Axes, drawn: Any, meaning: str, **options: Any) -> Colorbar:
    """Add a strip in the right margin with the meaning of the colours."""
    place = axes.get_position()
    strip = figure.add_axes((place.x1 + 0.02, place.y0, 0.03, place.height))
    bar = figure.colorbar(drawn, cax=strip, label=meaning, **options)
    numbers = strip.yaxis.get_major_formatter().format_ticks(list(bar.get_ticks()))
    if any(len(number) >= ROOM for number in numbers):
        strip.ticklabel_format(axis="y", scilimits=(0, 0))  # a power of ten stands above
        strip.yaxis.get_offset_text().set_fontsize(8)
    return bar
