"""Report sections of a feed drive's fuzzy controller: table, terms, surface, stability."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from hfc_design.controllers import surfaces
from hfc_design.controllers.flc.export import labels_of, units
from hfc_design.controllers.flc.law import infer
from hfc_design.controllers.flc.record import (
    USUAL,
    FlcDesign,
    FuzzyRecord,
    Terms,
    TriangleRecord,
    called,
    signals_of,
)
from hfc_design.controllers.kind import ReportContext
from hfc_design.controllers.neighbours import Partition, memberships
from hfc_design.controllers.surfaces import Side, Surface
from hfc_design.core.numbers import ARRAYS, Floats
from hfc_design.core.tables import Table
from hfc_design.plotting.heat_map import heat_map
from hfc_design.plotting.section import Drawing, Drawn, Section
from hfc_design.plotting.terms import Curve, Panel
from hfc_design.plotting.terms import terms as drawn_terms
from hfc_design.stability import report as stability
from hfc_design.stability.stable_range import stable_range
from plants import Drive

ORIGINAL = "as designed"
HELD = ", as limited by the adaptation from the first sample"
#: Sentence needed to read the table, by form of the flc (JK95 eq. 1).
FORMS = {
    "P": "In the form P the change is taken as zero. ",
    "PI": "In the form PI the output of the rules is the change of their command. ",
    "PD": "",
}
#: Rows of a table of parameters: name, value, unit.
Parameters = Sequence[tuple[str, float | str, str]]


def sections(record: FlcDesign, shown: ReportContext) -> list[Section]:
    """Return the sections: table and terms, and the gains in the stable range."""
    form = ("form of the controller (JK95 eq. 1)", record.form, "\u2013")
    return [controller(record, FORMS[record.form], before=[form]), stable_gains(record, shown)]


def table_sections(record: FuzzyRecord, shown: ReportContext) -> list[Section]:
    """Return the sections that all fuzzy kinds have in common."""
    return [controller(record), stable_gains(record, shown)]


def controller(
    record: FuzzyRecord, kind: str = "", before: Parameters = (), behind: Parameters = ()
) -> Section:
    """Return the section with gains, rule table, terms and surface.

    ``kind`` is text on the kind; ``before`` and ``behind`` are rows around the integral gain.
    """
    names = record.names
    if signals_of(names):
        kind += (
            f"In the source of the table the error is called {names.error}, its change "
            f"{names.error_change}, and the output {names.output}. "
        )
    integral = "The integral of the error is added to the output of the rules. "
    if not record.integral_gain:
        integral = "There is no integral of the error. "
    text = (
        f"Every {1e3 * record.sample_time_s:g} ms the control reads the error of each axis and its "
        f"change since the last sample. {kind}{integral}One BLU is a step of the encoder, one unit "
        "a step of the converter."
    )
    rows = [*before, ("integral gain", record.integral_gain, "unit/(BLU s)"), *behind]
    if record.dead_zone:
        rows.append(("errors up to this count as 0", record.dead_zone, "BLU"))
    low = record.low_velocity
    if low is not None:
        for name, curve in (("forward", low.forward), ("backward", low.backward)):
            units = ("unit/(mm/s)²", "unit/(mm/s)", "unit")
            for power, value, unit in zip((2, 1, 0), curve, units, strict=True):
                rows.append((f"friction compensated {name}, coefficient of V^{power}", value, unit))
        rows += [
            ("friction is compensated below", low.highest_velocity_mm_s, "mm/s"),
            ("command at rest, forward", low.breakaway[0], "unit"),
            ("command at rest, backward", low.breakaway[1], "unit"),
            ("command at rest from an error of", low.smallest_error, "BLU"),
        ]
    for label, value in (record.rules.output_terms or {}).items():
        rows.append((f"output term {label}", value, "unit"))
    labels = [term.label for term in record.error_terms]
    usual = {"NL": "negative large (NL)", "PL": "positive large (PL)"}
    first, last = (usual.get(label, label) for label in (labels[0], labels[-1]))
    cells = [[name, v if isinstance(v, str) else f"{v:.5g}", unit] for name, v, unit in rows]
    return Section(
        "The controller",
        text,
        Table("Gains, steps and limits.", ["parameter", "value", "unit"], cells),
        [
            Drawing(
                rule_table(record, f"rule table {ORIGINAL}"),
                "Heat map of the rule table",
                f"Rule table: the command for each pair of terms, from {first} to {last}.",
            ),
            Drawing(
                terms(record, f"terms {ORIGINAL}"),
                "Membership functions of the error and of its change",
                "Meaning of the terms: the degree to which an error and its change belong to each.",
            ),
            drawn_surface(record, f"control surface {ORIGINAL}", HELD * record.adapts),
        ],
    )


def drawn_surface(record: FuzzyRecord, title: str, whose: str) -> Drawing:
    """Return the control surface with a cursor; ``whose`` continues a sentence of the caption."""
    zone = record.dead_zone
    return surfaces.drawing(
        surface(record, title),
        f"Control surface: the output of the rules over both inputs{whose}. Where a term "
        "of each input is highest a single rule decides, elsewhere several together."
        + f" Errors up to {zone:g} BLU enter as 0."
        * bool(zone),
    )


def stable_gains(
    record: FuzzyRecord, shown: ReportContext, adapted: Mapping[str, FuzzyRecord] = {}
) -> Section:
    """Return the gains of the tables in the stable range of the axis with the largest gain."""
    gains = record.table_gains()
    for axis, after in adapted.items():
        gains[f"{axis}, adapted"] = after.table_gains()["table, with its edges"]
    axes = zip(shown.machine.drives, shown.parameters, strict=True)
    drive = stability.drive_of("this plant is", axes, record.sample_time_s, {})
    gain_range = stable_range(**drive)
    rows = [
        [name, f"{k1:.4g}", f"{k2:.4g}", "yes" if gain_range.contains(k1, k2) else "no"]
        for name, (k1, k2) in gains.items()
    ]
    return Section(
        "Stability",
        "K₁ is the largest slope of the command over the error, K₂ over its change (Jee & Koren "
        "2004, section 3). The range is that of a drive without friction, of "
        f"{drive['gain']:g} (BLU/s)/unit and {1e3 * drive['time_constant']:g} ms; "
        f"it ends at K₁ = {gain_range.k1_bound:.4g} unit/BLU. Gains outside it may still "
        "settle in the motions of this page, which \u201cCan I use it?\u201d tests by simulation; "
        "the range is valid for every motion of that drive.",
        Table(
            "Gains of the rules [unit/BLU]; eq. 13 and 14 use only the centres of the terms.",
            ["gains of", "K₁", "K₂", "inside"],
            rows,
        ),
        [
            Drawing(
                stability.stability_figure(gain_range, gains),
                "Stable range of the gains K₁ and K₂ with the design in it",
                "Stable range and the gains of the design.",
            )
        ],
    )


#: Terms are drawn up to this multiple of the outermost centre.
BEYOND = 1.25


def terms(record: FuzzyRecord, title: str, before: FuzzyRecord | None = None) -> Figure:
    """Draw the terms of the error and of its change; those of ``before`` in grey behind them."""
    labels = (side.label for side in _sides(record))
    panels = []
    for (key, side_terms), label in zip(record.sides.items(), labels, strict=True):
        span = _ranges(side_terms)
        curves = {term.label: _triangle(term, span) for term in side_terms}
        grey = () if before is None else getattr(before, key)
        old = [_triangle(term, span) for term in grey]
        panels.append(Panel(label, (-span, span), curves, old))
    return drawn_terms(panels, title)


def _triangle(term: TriangleRecord, span: float) -> Curve:
    degrees = np.array([float(term.left is None), 1.0, float(term.right is None)])
    return np.clip(term.edges(), -span, span), degrees


def rule_table(record: FuzzyRecord, title: str, before: FuzzyRecord | None = None) -> Figure:
    """Draw the singletons [unit], rows by error and columns by its change.

    With ``before`` the colours show how far each singleton has moved since.
    """
    values = np.array(record.rules.centroids)
    moved = None if before is None else values - np.array(before.rules.centroids)
    command = called(record.names.output, USUAL.output, "command")
    meaning = f"{command} [unit]" if before is None else "moved by [unit]"
    error, change = _sides(record)
    row, column = f"row: {error.name}", f"column: {change.name}"
    return heat_map(values, labels_of(record), row, column, title, meaning, moved)


def surface(record: FuzzyRecord, title: str) -> Surface:
    """Return the surface of the output [unit] of the rules in the first sample."""
    record = record.at_first()
    error, change = _sides(record)
    said = "change of command" if record.control_form() == "PI" else "command"
    said = called(record.names.output, USUAL.output, said)
    (unit,) = units(record)

    def law(change: Floats, error: Floats) -> Floats:
        return commanded(record, error, change)

    return Surface(title, unit, change, error, f"{said} [unit]", law)


def _sides(record: FuzzyRecord) -> tuple[Side, Side]:
    """Return error and change of error as axes of pictures, with names, units and ranges."""
    names = record.names
    error, change = map(_ranges, record.sides.values())
    error_name = called(names.error, USUAL.error, "error")
    change_name = called(names.error_change, USUAL.error_change, "change of error")
    of_error = Side(error_name, "BLU", (-error, error))
    return of_error, Side(change_name, "BLU per sample", (-change, change))


def _ranges(terms: Terms) -> float:
    return BEYOND * max(abs(term.centre) for term in terms)


def pictures(record: FuzzyRecord, drive: Drive) -> dict[str, dict[str, Drawn]]:
    """Return the pictures for ``hfc plot``."""
    return {
        **surfaces.pictures({"rules": lambda: surface(record, "control surface")}),
        "terms": {"rules": lambda: terms(record, "terms")},
        "tables": {"rules": lambda: rule_table(record, "rule table")},
    }


def commanded(record: FuzzyRecord, error: Floats, change: Floats) -> Floats:
    """Return the output of the rules [unit] at errors and changes [BLU], arrays that broadcast."""
    table = record.table()
    in_error = memberships(ARRAYS, Partition.of(table.error_terms), error)
    in_change = memberships(ARRAYS, Partition.of(table.change_terms), change)
    commands: Floats = infer(ARRAYS, in_error, in_change, table.singletons)
    return commands
