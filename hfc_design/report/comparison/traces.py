"""Motions as curves that a page can show and zoom into: few numbers, no peak of them lost."""

import base64
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Json
from hfc_design.pictures.figure import drawable
from hfc_design.pictures.numbers import readable
from hfc_design.report.plots import drawn_samples
from hfc_design.simulation.comparison import Bout
from hfc_design.simulation.evaluating import Evaluation

#: A curve has the lowest and the highest value of each of at most so many slices of time.
SLICES = 600
Curves = dict[str, Floats]  # (samples,) each


class Panel(NamedTuple):
    """Curves of one quantity over the samples of a motion."""

    label: str  # with the unit
    curves: Curves  # by design; nan where one has run away
    reference: Floats | None = None  # (samples,) of a position


def panels(bout: Bout) -> list[Panel]:
    """Error, command, velocity and position of every axis, of a path the errors off it first.

    Of the nominal machine. A diverged motion ends where it runs away.
    """
    each = {name: found.motion for name, found in bout.found.items()}
    first = next(iter(each.values()))
    found = []
    if first.contour is not None:
        off = {name: one.contour.error for name, one in each.items() if one.contour}
        found.append(_panel("contour error", first.contour.unit, each, off))
        paths = {name: one.contour for name, one in each.items()}
        turned = {x: own.turned for x, own in paths.items() if own and own.turned is not None}
        if turned:
            found.append(_panel("orientation error", "deg", each, turned))
    for k, axis in enumerate(first.axes):
        own = {name: one.axes[k] for name, one in each.items()}
        units, several = axis.drive.units, len(first.axes) > 1
        drawn: list[tuple[str, str, Curves]] = [
            ("error", "error", {name: one.motion.error for name, one in own.items()}),
            (axis.drive.command_name, "command", {x: one.motion.command for x, one in own.items()}),
            ("velocity", "error_rate", {name: one.velocity for name, one in own.items()}),
        ]
        head = f"{axis.name} " if several else ""
        for name, unit, curves in drawn:
            found.append(_panel(head + name, units[unit], each, curves))
        places = {name: one.reference - one.motion.error for name, one in own.items()}
        found.append(_panel(f"{head}position", units["error"], each, places, axis.reference))
    return found


def _panel(
    label: str,
    unit: str,
    each: Mapping[str, Evaluation],
    curves: Curves,
    reference: Floats | None = None,
) -> Panel:
    """The curves in a unit that suits the largest of them that did not diverge."""
    cut = {}
    for name, values in curves.items():
        end = drawn_samples(each[name])
        cut[name] = np.where(np.arange(len(values)) < end, drawable(values), np.nan)
    kept = [values for name, values in cut.items() if not each[name].diverged]
    known = kept if reference is None else [*kept, drawable(reference)]
    factor, named = readable(unit, max((float(np.abs(x).max()) for x in known), default=1.0))
    scaled = {name: factor * values for name, values in cut.items()}
    return Panel(f"{label} [{named}]", scaled, None if reference is None else factor * reference)


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
            "names": list(panel.curves),
            "curves": [_packed(values) for values in panel.curves.values()],
            "reference": None if panel.reference is None else _packed(panel.reference),
        }
        for panel in shown
    ]
    # Two values a slice, drawn at its beginning and in its middle.
    return {"step": every * (size / 2 if size > 1 else 1.0), "panels": drawn}


def _packed(values: Floats) -> str:
    with np.errstate(over="ignore"):
        shown = extremes(values)[0].astype("<f4")
    return base64.b64encode(shown.tobytes()).decode()
