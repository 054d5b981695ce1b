"""Curves of a design and of its search, and how a figure becomes a file.

Every function makes a ``matplotlib.figure.Figure`` of its own; none touches pyplot. The figures
are narrow on purpose: they are to be read on a phone too.
"""

import io
from collections.abc import Mapping
from itertools import chain, cycle
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator
from numpy.typing import NDArray

from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import UserError
from hfc_design.search.loop import History
from hfc_design.simulation.evaluation import Evaluation

Floats = NDArray[np.float64]

WIDTH = 5.4  # of every figure [in]
# Okabe and Ito's colours, which stay apart for a colour-blind reader.
OWN, OTHER = "#0072B2", "#B34F00"
RIVALS: tuple[dict[str, Any], ...] = tuple(
    {"color": color, "lw": 1.2, "ls": style}
    for color, style in (("#D55E00", "-"), ("#009E73", "--"), ("#CC79A7", "-."), ("#E69F00", ":"))
)
#: A curve is drawn with at most two points in each of this many slices of time.
SLICES = 500
#: A diverged motion is not drawn once its error is this many times the largest reference.
RUNAWAY = 10.0
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


def response(evaluation: Evaluation, title: str) -> Figure:
    """Position, tracking error, spring deflection, command and load against time.

    The C-axis as LL fig. 6 and 7, c to f. There is no panel of a deflection that the plant has
    not, or of a load where there is none. A diverged motion ends where it runs away.
    """
    (axis,) = evaluation.axes
    drawn = slice(_drawn(evaluation))
    plant = evaluation.plant
    factor, unit = _error_unit(evaluation)
    error = axis.motion.error[drawn]
    angular = plant.units["error"] == "rad"
    curves = {
        f"{'angle' if angular else 'position'} [{plant.units['error']}]": axis.reference[drawn]
        - error,
        f"error [{unit}]": factor * error,
    }
    if "deflection" in axis.readings:
        curves["deflection [mrad]"] = 1e3 * axis.readings["deflection"][drawn]
    curves[f"{plant.command_name} [{plant.units['command']}]"] = axis.motion.command[drawn]
    if np.any(axis.load):
        curves[f"load [{plant.units['load']}]"] = axis.load[drawn]
    figure = framed(1.45 * len(curves) + 1.0, top=0.4)
    panels = figure.subplots(len(curves), 1, sharex=True, gridspec_kw={"hspace": 0.12})
    for axes, (label, values) in zip(panels, curves.items(), strict=True):
        curve = _thinned(evaluation.time[drawn], values)
        axes.plot(*curve, color=OWN, lw=1.2, label="spindle" if angular else "axis")
        finish(axes, label)
    reference = _thinned(evaluation.time, axis.reference)
    panels[0].plot(*reference, color="black", lw=1, ls="--", label="reference")
    panels[0].legend(fontsize=9, frameon=False)
    panels[0].margins(x=0)
    panels[-1].set_xlabel("time [s]")
    if evaluation.diverged:
        title += f" (diverged at {evaluation.time[drawn][-1]:.3g} s)"
    panels[0].set_title(title, fontsize=11)
    return figure


def errors(evaluations: Mapping[str, Evaluation]) -> Figure:
    """Largest error in each hundredth of the time, logarithmic; the first stands out.

    The contour error of an X-Y machine, else the tracking error.

    Errors that differ by orders of magnitude and change their sign cannot be compared otherwise.
    """
    figure = framed(3.8, top=0.65)
    axes = figure.subplots()
    factor, unit = _error_unit(next(iter(evaluations.values())))
    styles = chain([{"color": OWN, "lw": 2.5, "zorder": 3}], cycle(RIVALS))
    for (name, evaluation), style in zip(evaluations.items(), styles, strict=False):
        count = _drawn(evaluation)
        starts = np.arange(0, count, -(-len(evaluation.time) // 100))
        largest = np.maximum.reduceat(factor * np.abs(_error(evaluation)[:count]), starts)
        label = f"{name} (diverged)" if evaluation.diverged else name
        axes.plot(evaluation.time[starts], largest, label=label, **style)
    finish(axes, f"largest error [{unit}]")
    logarithmic(axes)
    axes.margins(x=0)
    axes.set_xlabel("time [s]")
    figure.legend(fontsize=9, frameon=False, ncols=2, loc="upper center")
    return figure


def history(history: History, title: str) -> Figure:
    """Best and median merit, by its ``title``, and how many individuals diverged."""
    figure = framed(4.15, top=0.4)
    ratios = {"height_ratios": (3, 1), "hspace": 0.12}
    scores, diverged = figure.subplots(2, 1, sharex=True, gridspec_kw=ratios)
    count = len(history.best)
    generation = np.arange(1.0, count + 1)
    style: dict[str, Any] = {"marker": "." if count < 30 else None}
    scores.plot(*_thinned(generation, history.best), color=OWN, label="best so far", **style)
    scores.plot(*_thinned(generation, history.median), color=OTHER, label="median", **style)
    scores.legend(fontsize=9, frameon=False)
    scores.set_title(title, fontsize=11, parse_math=False)
    finish(scores, "merit")
    logarithmic(scores)
    place, bars = _thinned(generation, history.diverged)
    place = np.concatenate([[0.5], place, [count + 0.5]])
    diverged.fill_between(place, np.pad(bars, 1, mode="edge"), step="mid", color="0.6")
    finish(diverged, "diverged [1]")
    diverged.set_xlabel("generation")
    diverged.set_xlim(0.5, count + 0.5)
    diverged.set_ylim(0, 1.05 * max(int(history.diverged.max()), 1))
    diverged.xaxis.set_major_locator(MaxNLocator(integer=True))
    diverged.yaxis.set_major_locator(MaxNLocator(nbins=3, integer=True))
    return figure


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


def _error(evaluation: Evaluation) -> Floats:
    """(steps,) what the controller is to make small."""
    path = evaluation.contour
    return evaluation.axes[0].motion.error if path is None else path.error


def _error_unit(evaluation: Evaluation) -> tuple[float, str]:
    """Factor and unit in which the errors of ``evaluation`` are easy to read."""
    unit = evaluation.plant.units["error"]
    if unit != "rad":
        return 1.0, unit
    largest = np.abs(_error(evaluation)[: _drawn(evaluation)]).max()
    return (1e6, "µrad") if largest < 1e-3 else (1e3, "mrad")


def _drawn(evaluation: Evaluation) -> int:
    """Number of samples before a diverged motion runs away, at least one; else all."""
    if not evaluation.diverged:
        return len(evaluation.time)
    if evaluation.contour is not None:
        kept = np.isfinite(evaluation.contour.error)
        return len(kept) if kept.all() else max(int(np.argmin(kept)), 1)
    (axis,) = evaluation.axes
    limit = RUNAWAY * np.abs(axis.reference).max() or RUNAWAY
    kept = np.isfinite(axis.motion.command)
    for values in (axis.motion.error, axis.readings.get("deflection", axis.motion.error)):
        kept &= np.abs(values) < limit  # nan is not
    return len(kept) if kept.all() else max(int(np.argmin(kept)), 1)


def _thinned(time: Floats, values: NDArray[Any]) -> tuple[Floats, NDArray[Any]]:
    """The curve with the lowest and the highest point of each slice of time, in order."""
    size = -(-len(values) // SLICES)
    if size <= 2:
        return time, values
    slices = np.pad(values, (0, -len(values) % size), mode="edge").reshape(-1, size)
    first = size * np.arange(len(slices))
    ends = [[0, len(values) - 1], first + slices.argmin(axis=1), first + slices.argmax(axis=1)]
    keep = np.unique(np.minimum(np.concatenate(ends), len(values) - 1))
    return time[keep], values[keep]
