"""Pictures of a feed drive's fuzzy controller: its table, its terms, its surface."""

import numpy as np
from matplotlib.figure import Figure

from hfc_design.controllers import surfaces
from hfc_design.controllers.flc.export import labels_of, units
from hfc_design.controllers.flc.law import infer, memberships
from hfc_design.controllers.flc.names import USUAL, called
from hfc_design.controllers.flc.record import FuzzyRecord, Terms, TriangleRecord
from hfc_design.controllers.surfaces import Side, Surface
from hfc_design.core.numbers import ARRAYS, Floats
from hfc_design.pictures.heat_map import heat_map
from hfc_design.pictures.section import Drawn
from hfc_design.pictures.terms import Curve, Panel
from hfc_design.pictures.terms import terms as drawn_terms
from plants import Drive

#: The terms are drawn up to this share of the outermost centre.
BEYOND = 1.25


def terms(record: FuzzyRecord, title: str, before: FuzzyRecord | None = None) -> Figure:
    """Degrees of membership in the terms of the error and of its change.

    ``before`` is drawn in grey below.
    """
    labels = (side.label for side in _sides(record))
    panels = []
    for key, label in zip(("error_terms", "error_change_terms"), labels, strict=True):
        own: Terms = getattr(record, key)
        reach = _reach(own)
        curves = {term.label: _triangle(term, reach) for term in own}
        grey = () if before is None else getattr(before, key)
        old = [_triangle(term, reach) for term in grey]
        panels.append(Panel(label, (-reach, reach), curves, old))
    return drawn_terms(panels, title)


def _triangle(term: TriangleRecord, reach: float) -> Curve:
    degrees = np.array([float(term.left is None), 1.0, float(term.right is None)])
    return np.clip(term.edges(), -reach, reach), degrees


def rule_table(record: FuzzyRecord, title: str, before: FuzzyRecord | None = None) -> Figure:
    """The singletons [unit], rows by error and columns by its change.

    With ``before`` the colours are what each has moved by.
    """
    values = np.array(record.rules.centroids)
    moved = None if before is None else values - np.array(before.rules.centroids)
    command = called(record.names.output, USUAL.output, "command")
    meaning = f"{command} [unit]" if before is None else "moved by [unit]"
    error, change = _sides(record)
    row, column = f"row: {error.name}", f"column: {change.name}"
    return heat_map(values, labels_of(record), row, column, title, meaning, moved)


def surface(record: FuzzyRecord, title: str) -> Surface:
    """What the rules command [unit] between and beyond the centres of their terms, at first."""
    record = record.at_first()
    error, change = _sides(record)
    said = "change of command" if record.control_form() == "PI" else "command"
    said = called(record.names.output, USUAL.output, said)
    (unit,) = units(record)
    return Surface(
        title,
        unit,
        change,
        error,
        f"{said} [unit]",
        lambda change, error: commanded(record, error, change),
    )


def _sides(record: FuzzyRecord) -> tuple[Side, Side]:
    """The error and its change, as far as their terms are drawn."""
    names = record.names
    error, change = _reach(record.error_terms), _reach(record.error_change_terms)
    return (
        Side(called(names.error, USUAL.error, "error"), "BLU", (-error, error)),
        Side(
            called(names.error_change, USUAL.error_change, "change of error"),
            "BLU per sample",
            (-change, change),
        ),
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
