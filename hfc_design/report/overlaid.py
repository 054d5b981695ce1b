"""Several designs in one motion, over one another."""

from collections.abc import Mapping
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from hfc_design.core.numbers import Floats
from hfc_design.pictures.curves import thinned
from hfc_design.pictures.figure import above, finish, framed, plain
from hfc_design.report.plots import SMALL, curves, drawn_samples, error_unit, path_errors, skipped
from hfc_design.report.searches import stroke
from hfc_design.simulation.evaluating import Evaluation

Evaluations = Mapping[str, Evaluation]
#: Height of a line of the legend, and of the title below it [in].
LINE, TITLE = 0.2, 0.4
#: Room above and below what is drawn, as a share of it.
AROUND = 0.05


class Panel(NamedTuple):
    """A curve of each design, and of a position the reference."""

    label: str
    values: list[Floats]  # of each design, (its drawn samples,)
    reference: Floats | None = None  # (steps,)


def motions(evaluations: Evaluations, title: str) -> Figure:
    """Position, error and command of every axis; before them how far each design is off a path.

    Of one axis without a path, panels one below the other, the deflection of a spring too. A
    motion that diverged ends where it runs away, and may leave its panels.

    Args:
        evaluations: by the names of the designs, all of the same scenario.
        title: stands above.
    """
    one = next(iter(evaluations.values()))
    off = _off_path(evaluations)
    rows = [_panels(evaluations, k) for k in range(len(one.axes))]
    top = LINE * -(-(len(evaluations) + 1) // 2) + TITLE
    if off or len(rows) > 1:
        rows = [[panel for panel in row if not skipped(panel.label)] for row in rows]
        figure, places = _in_rows(off, rows, top)
    else:
        figure, places = _one_below_the_other(rows[0], top)
    for axes, panel in zip(places, [*off, *chain.from_iterable(rows)], strict=True):
        _draw(axes, evaluations, panel)
    figure.suptitle(title, fontsize=11, y=1.0 - (top - TITLE + 0.08) / figure.get_figheight())
    above(figure, places[len(off)])  # a position has the reference as well
    return figure


def _one_below_the_other(panels: list[Panel], top: float) -> tuple[Figure, list[Axes]]:
    figure = framed(1.3 * len(panels) + top + 0.5, top=top)
    places = list(figure.subplots(len(panels), 1, sharex=True, gridspec_kw={"hspace": 0.12}))
    for axes, panel in zip(places, panels, strict=True):
        finish(axes, panel.label)
    places[-1].set_xlabel("time [s]")
    return figure, places


def _in_rows(off: list[Panel], rows: list[list[Panel]], top: float) -> tuple[Figure, list[Axes]]:
    """A row for each error off the path, then for each axis."""
    figure = framed(1.4 * (len(off) + len(rows)) + top + 0.5, top=top + 0.2)
    grid = figure.add_gridspec(len(off) + len(rows), 3, **SMALL)
    wide = [(grid[k, :], panel) for k, panel in enumerate(off)]
    small = [
        (grid[len(off) + k, n], own) for k, row in enumerate(rows) for n, own in enumerate(row)
    ]
    places = []
    for place, panel in wide + small:
        axes = figure.add_subplot(place)
        finish(axes, "", "time [s]" if place.rowspan.stop == grid.nrows else "")
        axes.set_title(panel.label, fontsize=9, loc="right")
        axes.tick_params(labelsize=8)
        axes.yaxis.set_major_locator(MaxNLocator(nbins=4))
        places.append(axes)
    return figure, places


def _draw(axes: Axes, evaluations: Evaluations, panel: Panel) -> None:
    time = next(iter(evaluations.values())).time
    for k, ((name, one), values) in enumerate(zip(evaluations.items(), panel.values, strict=True)):
        label = plain(f"{name} (diverged)" if one.diverged else name)
        axes.plot(*thinned(time[: len(values)], values), label=label, **stroke(k))
    if panel.reference is not None:
        axes.plot(*thinned(time, panel.reference), color="black", lw=0.8, ls=":", label="reference")
    pairs = zip(evaluations.values(), panel.values, strict=True)
    kept = [values for one, values in pairs if not one.diverged]
    if kept and len(kept) < len(panel.values):  # else what runs away would be all that is seen
        seen = np.concatenate([*kept, *([] if panel.reference is None else [panel.reference])])
        room = AROUND * (np.ptp(seen) or 1.0)
        axes.set_ylim(seen.min() - room, seen.max() + room)
    axes.margins(x=0)


def _off_path(evaluations: Evaluations) -> list[Panel]:
    """Contour errors, and of machines that turn the tool too how far it is turned off."""
    found = []
    for one in evaluations.values():
        path = one.contour
        planar = [] if path is None else [("contour", 1.0, path.unit, path.error)]
        found.append(path_errors(one) or planar)
    drawn = [drawn_samples(one) for one in evaluations.values()]
    return [
        Panel(
            f"{own[0][0]} error [{own[0][2]}]",
            [factor * error[:n] for (_, factor, _, error), n in zip(own, drawn, strict=True)],
        )
        for own in zip(*found, strict=True)
    ]


def _panels(evaluations: Evaluations, k: int) -> list[Panel]:
    """Those of axis ``k``, without the load, which is the same for all."""
    scale = min(error_unit(one, one.axes[k]) for one in evaluations.values())
    each: list[Any] = [
        curves(one, one.axes[k], slice(drawn_samples(one)), scale) for one in evaluations.values()
    ]
    own = evaluations[next(iter(evaluations))].axes[k]
    count = len(each[0]) - bool(np.any(own.load))
    return [
        Panel(label, [curve[n][1] for curve in each], reference)
        for n, (label, _, reference) in enumerate(each[0][:count])
    ]
