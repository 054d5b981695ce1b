"""Pictures of a feed drive's fuzzy controller: its terms, its rule table, its surface."""

from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from hfc_design.controllers.flc.law import infer, memberships
from hfc_design.controllers.flc.record import LABELS, FuzzyRecord, Triangles
from hfc_design.core.scalars import ARRAYS
from hfc_design.core.shapes import Floats
from hfc_design.pictures.figure import OTHER, OWN, WIDTH, framed, heat_map, round_above

ERROR, CHANGE = "error e [BLU]", "change of error [BLU per sample]"
#: The terms are drawn up to this share of the outermost centre.
BEYOND = 1.25
#: Points a side that the surface is computed at.
POINTS = 81
#: About so many colours stand for a command of one sign.
BANDS = 12


def terms(record: FuzzyRecord, title: str, before: FuzzyRecord | None = None) -> Figure:
    """Degrees of membership in the terms of the error and of its change.

    ``before`` is drawn in grey below.
    """
    figure = framed(4.6, top=0.75)
    panels = figure.subplots(2, 1, gridspec_kw={"hspace": 0.75})
    keys = {"error_terms": ERROR, "error_change_terms": CHANGE}
    for axes, (key, label) in zip(panels, keys.items(), strict=True):
        reach = BEYOND * max(abs(term.centre) for term in getattr(record, key))
        if before is not None:
            _triangles(axes, getattr(before, key), reach, ["0.65"], lw=1.0, ls="--")
        _triangles(axes, getattr(record, key), reach, [OWN, OTHER], lw=1.4)
        _names(axes, getattr(record, key))
        axes.set(xlim=(-reach, reach), ylim=(0.0, 1.08), yticks=(0.0, 0.5, 1.0))
        axes.grid(color="0.93")
        axes.set_axisbelow(True)
        axes.set_xlabel(label)
        axes.set_ylabel("degree [1]")
    panels[0].set_title(title, fontsize=11, pad=32)
    return figure


def _triangles(
    axes: Axes, found: Triangles, reach: float, colors: list[str], lw: float, ls: str = "-"
) -> None:
    for term, color in zip(found, cycle(colors), strict=False):
        left, right = term.left, term.right
        corners = [(-reach, 1.0) if left is None else (left, 0.0), (term.centre, 1.0)]
        corners.append((reach, 1.0) if right is None else (right, 0.0))
        axes.plot(*zip(*corners, strict=True), color=color, lw=lw, ls=ls)


def _names(axes: Axes, found: Triangles) -> None:
    """Labels above the centres, in two rows: centres may stand close together."""
    for k, term in enumerate(found):
        axes.annotate(
            term.label,
            (term.centre, 1.08),
            xytext=(0, 3 + 11 * (k % 2)),
            textcoords="offset points",
            ha="center",
            fontsize=9,
            color=(OWN, OTHER)[k % 2],
        )


def rule_table(record: FuzzyRecord, title: str, before: FuzzyRecord | None = None) -> Figure:
    """The singletons [unit], rows by error and columns by its change.

    With ``before`` the colours are what each has moved by.
    """
    values = np.array(record.rules.centroids)
    moved = None if before is None else values - np.array(before.rules.centroids)
    meaning = "command [unit]" if before is None else "moved by [unit]"
    return heat_map(values, LABELS, "row: error", "column: change of error", title, meaning, moved)


def surface(record: FuzzyRecord, title: str) -> Figure:
    """What the rules command [unit] between and beyond the centres of their terms."""
    figure = framed(4.0, top=0.35)
    figure.subplots_adjust(right=1 - 0.95 / WIDTH)
    axes = figure.subplots()
    error, change = (
        np.linspace(-1.0, 1.0, POINTS) * BEYOND * max(abs(term.centre) for term in found)
        for found in (record.error_terms, record.error_change_terms)
    )
    values = commanded(record, error[:, None], change)
    limit = float(np.abs(values).max()) or 1.0
    division = round_above(limit / BANDS)
    count = int(np.ceil(limit / division + 0.5))
    levels = division * (np.arange(-count, count) + 0.5)  # none at 0: rounding would draw it
    filled = axes.contourf(change, error, values, levels, cmap="RdBu_r")
    filled.set_edgecolor("face")  # else white hairlines show between the bands
    axes.axhline(0.0, color="0.3", lw=0.6)
    axes.axvline(0.0, color="0.3", lw=0.6)
    axes.set_xlabel(CHANGE)
    axes.set_ylabel(ERROR)
    axes.set_title(title, fontsize=11)
    place = axes.get_position()
    strip = figure.add_axes((place.x1 + 0.02, place.y0, 0.03, place.height))
    bar = figure.colorbar(filled, cax=strip, ticks=MaxNLocator(7, symmetric=True))
    bar.set_label("command [unit]")
    return figure


def commanded(record: FuzzyRecord, error: Floats, change: Floats) -> Floats:
    """Output of the rules [unit] at errors and changes [BLU] that broadcast."""
    table = record.table()
    in_error = memberships(ARRAYS, table.error_terms, error)
    in_change = memberships(ARRAYS, table.change_terms, change)
    found: Floats = infer(ARRAYS, in_error, in_change, table.singletons)
    return found
