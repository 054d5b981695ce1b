"""Errors of a design beside those of others, on a logarithmic scale."""

from itertools import chain, cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from hfc_design.plotting.figure import (
    COLOURS,
    LABEL,
    OWN,
    above,
    distinct,
    drawable,
    finish,
    framed,
    gridded,
    logarithmic,
    plain,
    stroke,
)
from hfc_design.report.panels import Evaluations, PathError, drawn_samples, error_scale, path_errors
from hfc_design.simulation.evaluating import Evaluation

#: Largest number of large panels one below the other.
HIGHEST = 3
#: Mark after the name of a design.
DIVERGED = " (diverged)"
RIVALS = tuple(map(stroke, range(1, len(COLOURS))))


def motion_errors(evaluations: Evaluations) -> Figure:
    """As ``errors``, a small panel for each axis in each motion, two in a row."""
    first = next(iter(evaluations.values()))
    return _small(
        [
            (name, {label: one.motions[name] for label, one in evaluations.items()}, k)
            for name, evaluation in first.motions.items()
            for k in range(len(_errors(evaluation)))
        ]
    )


def errors(evaluations: Evaluations) -> Figure:
    """Largest error in each hundredth of the time, logarithmic, with the first design emphasised.

    Drawn are the contour error of an X-Y machine, the tracking error of each axis of others, and
    both for a program of any axes. More than ``HIGHEST`` panels are small, two in a row.

    On a linear scale, errors that differ by orders of magnitude and change their sign cannot be
    compared.
    """
    first = next(iter(evaluations.values()))
    count = len(_errors(first))
    if count > HIGHEST:
        return _small([("", evaluations, k) for k in range(count)])
    top = max(0.65, 0.25 + 0.2 * -(-len(evaluations) // 2))  # the legend
    figure = framed(2.65 * count + 0.5 + top, top=top)
    panels = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    for k, axes in enumerate(panels):
        what, unit = _draw_errors(axes, evaluations, k)
        label = f"largest {what} error".replace("  ", " ")
        finish(axes, f"{label} [{unit}]", "time [s]" if k + 1 == count else "")
        logarithmic(axes)
        axes.margins(x=0)
    above(figure, panels[0])
    return figure


def _small(each: list[tuple[str, Evaluations, int]]) -> Figure:
    """Draw a small panel for each (motion, evaluations in it, index of an error in ``_errors``)."""
    rows, names = -(-len(each) // 2), max(len(errors) for _, errors, _ in each)
    top = 0.45 + 0.2 * -(-names // 2)  # the legend
    figure = framed(1.7 * rows + 0.4 + top, top=top, left=0.6)
    shape = {"hspace": 0.6, "wspace": 0.28}
    panels = figure.subplots(rows, 2, squeeze=False, gridspec_kw=shape).ravel()
    for place, (panel, (name, errors, k)) in enumerate(zip(panels, each, strict=False)):
        what, unit = _draw_errors(panel, errors, k)
        gridded(panel, "time [s]" if place + 2 >= len(each) else "")
        panel.set_title(plain(f"{name} {what}".strip(), 16), fontsize=9, loc="left")
        panel.set_title(f"error [{unit}]", fontsize=9, loc="right")
        panel.tick_params(labelsize=8)
        panel.xaxis.set_major_locator(MaxNLocator(nbins=4))
        logarithmic(panel)
        panel.margins(x=0)
    for panel in panels[len(each) :]:
        panel.set_visible(False)
    above(figure, panels[0])
    return figure


def _errors(evaluation: Evaluation) -> list[PathError]:
    """Return the errors that are drawn of a motion; a name may be empty."""
    path = evaluation.contour
    if path is not None and not path.any_axes:
        return [("", 1.0, path.unit, path.error)]
    errors = path_errors(evaluation)
    for axis in evaluation.axes:
        name = axis.name if len(evaluation.axes) > 1 else ""
        scale = error_scale([evaluation], axis.drive.units["error"])
        errors.append((name, *scale, axis.motion.error))
    return errors


def _draw_errors(axes: Axes, evaluations: Evaluations, k: int) -> tuple[str, str]:
    """Draw error ``k`` of ``_errors``, a curve per design; return the error's name and unit."""
    what, factor, unit, _ = _errors(next(iter(evaluations.values())))[k]
    labels = distinct(evaluations, LABEL - len(DIVERGED))
    styles = chain([{"color": OWN, "lw": 2.5, "zorder": 3}], cycle(RIVALS))
    for (name, evaluation), style in zip(evaluations.items(), styles, strict=False):
        drawn = drawn_samples(evaluation)
        starts = np.arange(0, drawn, -(-len(evaluation.time) // 100))
        error = _errors(evaluation)[k][3][:drawn]
        largest = drawable(np.maximum.reduceat(factor * np.abs(error), starts))
        label = labels[name] + DIVERGED * evaluation.diverged
        axes.plot(evaluation.time[starts], largest, label=label, **style)
    return what, unit
