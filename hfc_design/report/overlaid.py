"""Several designs in one motion, in the same panels."""

from itertools import chain

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hfc_design.plotting.figure import above, finish, plain, stroke
from hfc_design.report import panels
from hfc_design.report.panels import Evaluations, Panel

#: Height of a line of the legend, and of the title below it [in].
LINE, TITLE = 0.2, 0.4
#: Room above and below the curves, as a share of their height.
AROUND = 0.05


def motions(evaluations: Evaluations, title: str) -> Figure:
    """Draw position, error and command of every axis, preceded by the contour errors.

    For a single axis without a path, panels are one below the other, including the deflection of a
    spring. The curve of a diverged motion ends early, and may leave the panel.

    Args:
        evaluations: evaluations of the same scenario by the names of the designs.
        title: title above the figure.
    """
    first = next(iter(evaluations.values()))
    wide, count = panels.path_panels(evaluations), len(first.axes)
    alone = not wide and count == 1
    rows = [panels.axis_panels(evaluations, k, spring=alone) for k in range(count)]
    top = LINE * -(-(len(evaluations) + 1) // 2) + TITLE
    if alone:
        figure, places = panels.stacked(rows[0], top)
    else:
        figure, places = panels.small(wide, rows, height=top + 0.5, top=top + 0.2)
    for axes, panel in zip(places, chain(wide, *rows), strict=True):
        (finish if alone else panels.titled)(axes, panel.label)
        _draw(axes, evaluations, panel)
    places[-1].set_xlabel("time [s]")
    figure.suptitle(title, fontsize=11, y=1.0 - (top - TITLE + 0.08) / figure.get_figheight())
    above(figure, places[len(wide)])  # with the reference too
    return figure


def _draw(axes: Axes, evaluations: Evaluations, panel: Panel) -> None:
    each = evaluations.items()
    labels = (plain(f"{name} (diverged)" if one.diverged else name) for name, one in each)
    styles = (stroke(k) | {"label": label} for k, label in enumerate(labels))
    panels.draw(axes, next(iter(evaluations.values())).time, panel, styles)
    steady = [panel.curves[name] for name, one in each if not one.diverged]
    if steady and len(steady) < len(panel.curves):  # else only diverged curves could be seen
        seen = np.concatenate([*steady, *([] if panel.reference is None else [panel.reference])])
        room = AROUND * (np.ptp(seen) or 1.0)
        axes.set_ylim(seen.min() - room, seen.max() + room)
