"""Pictures of a feed drive's fuzzy controller: its table, its terms, its surface."""

from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hfc_design.controllers import surfaces
from hfc_design.controllers.flc.export import labels_of, units
from hfc_design.controllers.flc.law import infer, memberships
from hfc_design.controllers.flc.names import NamesRecord
from hfc_design.controllers.flc.record import FuzzyRecord, Terms
from hfc_design.controllers.surfaces import Side, Surface
from hfc_design.core.numbers import ARRAYS, Floats
from hfc_design.pictures.figure import OTHER, OWN, framed
from hfc_design.pictures.heat_map import heat_map
from hfc_design.pictures.section import Drawn
from plants import Drive

ERROR, CHANGE = ("error e", "BLU"), ("change of error", "BLU per sample")
#: The terms are drawn up to this share of the outermost centre.
BEYOND = 1.25


def terms(record: FuzzyRecord, title: str, before: FuzzyRecord | None = None) -> Figure:
    """Degrees of membership in the terms of the error and of its change.

    ``before`` is drawn in grey below.
    """
    figure = framed(4.6, top=0.75)
    panels = figure.subplots(2, 1, gridspec_kw={"hspace": 0.75})
    keys = {"error_terms": ERROR, "error_change_terms": CHANGE}
    for axes, (key, (name, unit)) in zip(panels, keys.items(), strict=True):
        found: Terms = getattr(record, key)
        reach = _reach(found)
        if before is not None:
            _triangles(axes, getattr(before, key), reach, ["0.65"], lw=1.0, ls="--")
        _triangles(axes, found, reach, [OWN, OTHER], lw=1.4)
        for k, term in enumerate(found):  # in two rows: centres may stand close together
            axes.annotate(
                term.label,
                (term.centre, 1.08),
                xytext=(0, 3 + 11 * (k % 2)),
                textcoords="offset points",
                ha="center",
                fontsize=9,
                color=(OWN, OTHER)[k % 2],
            )
        axes.set(xlim=(-reach, reach), ylim=(0.0, 1.08), yticks=(0.0, 0.5, 1.0))
        axes.set(xlabel=f"{name} [{unit}]", ylabel="degree [1]", axisbelow=True)
        axes.grid(color="0.93")
    panels[0].set_title(title, fontsize=11, pad=32)
    return figure


def _triangles(
    axes: Axes, found: Terms, reach: float, colors: list[str], lw: float, ls: str = "-"
) -> None:
    for term, color in zip(found, cycle(colors), strict=False):
        x = np.clip(term.edges(), -reach, reach)
        y = [float(term.left is None), 1.0, float(term.right is None)]
        axes.plot(x, y, color=color, lw=lw, ls=ls)


def rule_table(record: FuzzyRecord, title: str, before: FuzzyRecord | None = None) -> Figure:
    """The singletons [unit], rows by error and columns by its change.

    With ``before`` the colours are what each has moved by.
    """
    values = np.array(record.rules.centroids)
    moved = None if before is None else values - np.array(before.rules.centroids)
    meaning = "command [unit]" if before is None else "moved by [unit]"
    names, usual = record.names, NamesRecord()
    row = "row: error" + _named(names.error, usual.error)
    column = "column: change of error" + _named(names.error_change, usual.error_change)
    return heat_map(values, labels_of(record), row, column, title, meaning, moved)


def _named(name: str, usual: str) -> str:
    return "" if name == usual else f", {name}"


def surface(record: FuzzyRecord, title: str) -> Surface:
    """What the rules command [unit] between and beyond the centres of their terms, at first."""
    record = record.at_first()
    change, error = (
        Side(name, unit, (-reach, reach))
        for (name, unit), reach in (
            (CHANGE, _reach(record.error_change_terms)),
            (ERROR, _reach(record.error_terms)),
        )
    )
    said = "change of command [unit]" if record.control_form() == "PI" else "command [unit]"
    (unit,) = units(record)
    return Surface(
        title, unit, change, error, said, lambda change, error: commanded(record, error, change)
    )


def _reach(terms: Terms) -> float:
    return BEYOND * max(abs(term.centre) for term in terms)


def pictures(record: FuzzyRecord, drive: Drive) -> dict[str, dict[str, Drawn]]:
    """For ``hfc plot``."""
    return {
        **surfaces.pictures({"rules": lambda: surface(record, "control surface")}),
        "terms": {"rules": lambda: terms(record, "terms")},
        "tables": {"rules": lambda: rule_table(record, "rule table")},
    }


def commanded(record: FuzzyRecord, error: Floats, change: Floats) -> Floats:
    """Output of the rules [unit] at errors and changes [BLU] that broadcast."""
    table = record.table()
    in_error = memberships(ARRAYS, table.error_terms, error)
    in_change = memberships(ARRAYS, table.change_terms, change)
    found: Floats = infer(ARRAYS, in_error, in_change, table.singletons)
    return found
