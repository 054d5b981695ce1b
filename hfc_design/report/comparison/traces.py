"""Motions as curves that a page can show and zoom into: few numbers, no peak of them lost."""

import base64
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Json
from hfc_design.pictures.figure import drawable, readable
from hfc_design.report.plots import drawn_samples
from hfc_design.simulation.comparison import Bout
from hfc_design.simulation.evaluation import Evaluation

#: A curve has the lowest and the highest value of each of at most so many slices of time.
SLICES = 600
REFERENCE = "reference"
Curves = dict[str, Floats]  # (samples,) each


class Panel(NamedTuple):
    """Curves of one quantity over the samples of a motion."""

    label: str  # with the unit
    curves: Curves  # by design, and of a position the reference; nan where one has run away


def panels(bout: Bout) -> list[Panel]:
    """Error, command, velocity and position of every axis, of a path the contour error first.

    Of the nominal machine. A diverged motion ends where it runs away.
    """
    each = {name: found.motion for name, found in bout.found.items()}
    first = next(iter(each.values()))
    found = []
    if first.contour is not None:
        off = {name: one.contour.error for name, one in each.items() if one.contour}
        found.append(_panel("contour error", first.contour.unit, each, off))
    for k, axis in enumerate(first.axes):
        own = {name: one.axes[k] for name, one in each.items()}
        units, several = axis.drive.units, len(first.axes) > 1
        drawn: list[tuple[str, str, Curves]] = [
            ("error", "error", {name: one.motion.error for name, one in own.items()}),
            (axis.drive.command_name, "command", {x: one.motion.command for x, one in own.items()}),
            ("velocity", "error_rate", {name: one.velocity for name, one in own.items()}),
        ]
        places = {name: one.reference - one.motion.error for name, one in own.items()}
        drawn.append(("position", "error", {**places, REFERENCE: axis.reference}))
        for name, unit, curves in drawn:
            label = f"{axis.name} {name}" if several else name
            found.append(_panel(label, units[unit], each, curves))
    return found


def _panel(label: str, unit: str, each: Mapping[str, Evaluation], curves: Curves) -> Panel:
    """The curves in a unit that suits the largest of them that did not diverge."""
    cut = {}
    for name, values in curves.items():
        end = drawn_samples(each[name]) if name in each else len(values)
        cut[name] = np.where(np.arange(len(values)) < end, drawable(values), np.nan)
    kept = [np.nanmax(np.abs(x)) for name, x in cut.items() if name not in each or held(each[name])]
    factor, named = readable(unit, max(kept, default=1.0))
    return Panel(f"{label} [{named}]", {name: factor * values for name, values in cut.items()})


def held(evaluation: Evaluation) -> bool:
    """Whether a motion has an end."""
    return not evaluation.diverged


def extremes(values: Floats, slices: int = SLICES) -> tuple[Floats, int]:
    """(2 slices,) the lowest and the highest of each slice as they come, and samples in a slice.

    The values themselves, in slices of 1, where there are no more of them than that.
    """
    size = -(-len(values) // slices)
    if size <= 2:
        return values, 1
    whole = np.pad(values, (0, -len(values) % size), mode="edge").reshape(-1, size)
    unknown = np.isnan(whole)
    low = np.where(unknown, np.inf, whole).argmin(axis=1)
    high = np.where(unknown, -np.inf, whole).argmax(axis=1)
    order = np.sort(np.stack([low, high], axis=1), axis=1)
    return np.take_along_axis(whole, order, axis=1).ravel(), size


def data(bout: Bout, shown: list[Panel]) -> Json:
    """What the page's script draws: every curve as 32-bit floats, little-endian, in base64."""
    first = next(iter(bout.found.values())).motion
    every = float(first.time[1] - first.time[0]) if len(first.time) > 1 else 1.0
    _, size = extremes(first.time)
    drawn = [
        {
            "label": panel.label,
            "curves": [
                {"name": name, "data": _packed(extremes(values)[0])}
                for name, values in panel.curves.items()
            ],
        }
        for panel in shown
    ]
    # Two values a slice, drawn at its beginning and in its middle.
    return {"step": every * (size / 2 if size > 1 else 1.0), "panels": drawn}


def _packed(values: Floats) -> str:
    with np.errstate(over="ignore"):
        return base64.b64encode(values.astype("<f4").tobytes()).decode()
