"""How a figure is framed, drawn and becomes a file.

Every picture is a ``matplotlib.figure.Figure`` of its own; none touches pyplot. They are narrow on
purpose: they are to be read on a phone too.
"""

import io
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import UserError

WIDTH = 5.4  # of every figure [in]
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


def framed(height: float, top: float) -> Figure:
    """A figure with margins in inches; measuring the labels would draw everything twice."""
    figure = Figure(figsize=(WIDTH, height))
    figure.subplots_adjust(
        left=0.9 / WIDTH, right=1 - 0.15 / WIDTH, bottom=0.5 / height, top=1 - top / height
    )
    return figure


def finish(axes: Axes, label: str) -> None:
    """Label the y axis at a fixed place and draw a grid behind the curves."""
    axes.set_ylabel(label)
    axes.yaxis.set_label_coords(-0.155, 0.5)
    axes.grid(color="0.9")
    axes.set_axisbelow(True)


def logarithmic(axes: Axes) -> None:
    """A logarithmic y axis with plain numbers, unless the data lie close together."""
    values = np.concatenate([line.get_ydata() for line in axes.lines])
    positive = values[values > 0]
    if (values < 0).any() or len(positive) == 0 or positive.max() < 5 * positive.min():
        return
    values = positive
    many = values.max() > 500 * values.min()
    axes.set_yscale("log", nonpositive="mask")
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0,) if many else (1.0, 2.0, 5.0)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def round_above(value: float) -> float:
    """The smallest of 1, 2, 5 times a power of ten that is not below a positive value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * next(step for step in (1, 2, 5, 10) if step * power >= value))
