"""Motions as curves that a page can zoom into: few numbers, without loss of peaks."""

import base64
from collections.abc import Callable

import numpy as np

from hfc_design.core.numbers import Floats, Json
from hfc_design.plotting.figure import drawable
from hfc_design.plotting.numbers import readable
from hfc_design.report.panels import Evaluations, Panel, drawn_samples
from hfc_design.simulation.comparison import MotionComparison
from hfc_design.simulation.evaluating import AxisMotion

#: Largest number of slices of time of a curve, each with its lowest and its highest value.
SLICES = 600


def panels(bout: MotionComparison) -> list[Panel]:
    """Return panels of contour and orientation, then error, command, velocity, position per axis.

    The motion is that of the nominal machine. A diverged motion ends where it runs away.
    """
    each = {name: result.motion for name, result in bout.results.items()}
    paths = {name: one.contour for name, one in each.items() if one.contour}
    listed = []
    if paths:
        unit, errors = next(iter(paths.values())).unit, {x: path.error for x, path in paths.items()}
        listed.append(_panel("contour error", unit, each, errors))
    if turned := {x: path.turned for x, path in paths.items() if path.turned is not None}:
        listed.append(_panel("orientation error", "deg", each, turned))
    first = next(iter(each.values()))
    for k, axis in enumerate(first.axes):
        head = f"{axis.name} " if len(first.axes) > 1 else ""
        for what, (signal, values) in _curves(axis).items():
            curves = {name: values(one.axes[k]) for name, one in each.items()}
            reference = axis.reference if what == "position" else None
            listed.append(_panel(head + what, axis.drive.units[signal], each, curves, reference))
    return listed


def _curves(axis: AxisMotion) -> dict[str, tuple[str, Callable[[AxisMotion], Floats]]]:
    """Return quantity of an axis -> the signal with the same unit, a function for the values."""
    return {
        "error": ("error", lambda axis: axis.motion.error),
        axis.drive.command_name: ("command", lambda axis: axis.motion.command),
        "velocity": ("error_rate", lambda axis: axis.velocity),
        "position": ("error", lambda axis: axis.reference - axis.motion.error),
    }


def _panel(
    label: str,
    unit: str,
    each: Evaluations,
    curves: dict[str, Floats],
    reference: Floats | None = None,
) -> Panel:
    """Return the curves in a unit that suits the largest value of motions that did not diverge."""
    cut = {}
    for name, values in curves.items():
        end = drawn_samples(each[name])
        cut[name] = np.where(np.arange(len(values)) < end, drawable(values), np.nan)
    steady = [values for name, values in cut.items() if not each[name].diverged]
    known = steady if reference is None else [*steady, drawable(reference)]
    factor, named = readable(unit, max((float(np.abs(x).max()) for x in known), default=1.0))
    scaled = {name: factor * values for name, values in cut.items()}
    return Panel(f"{label} [{named}]", scaled, None if reference is None else factor * reference)


def extremes(values: Floats, slices: int = SLICES) -> tuple[Floats, int]:
    """Return the lowest and highest value of each slice in order, and the samples in a slice.

    The values are (2 slices,). If there are no more values than that, return them unchanged, and 1.
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


def data(bout: MotionComparison, shown: list[Panel]) -> Json:
    """Return data for the page's script: curves as 32-bit floats, little-endian, in base64."""
    first = next(iter(bout.results.values())).motion
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
