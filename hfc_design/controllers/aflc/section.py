"""Sections of the report page of an adaptive fuzzy controller."""

from hfc_design.controllers.aflc.record import AflcDesign
from hfc_design.controllers.flc import section as flc
from hfc_design.controllers.flc.record import FuzzyRecord
from hfc_design.controllers.flc.section import rule_table, terms
from hfc_design.controllers.kind import ReportContext, last_memory
from hfc_design.plotting.section import Drawing, Section

JUDGES = (
    "It judges the rules that fired one sample ago by the change of the error, and adjusts them. "
)


def sections(record: AflcDesign, shown: ReportContext) -> list[Section]:
    """Return sections: table and terms as designed and as adapted, gains in the stable range."""
    steps = record.adaptation
    parameters: flc.Parameters = [
        ("step of an edge of an error term, k_a", steps.k_a, "BLU"),
        ("step of an edge of a term of the change, k_b", steps.k_b, "BLU"),
        ("step of a command in the rule table, k_c", steps.k_c, "unit"),
        ("limit of the adaptation, K₁", steps.stable_range.k1_max, "unit/BLU"),
        ("limit of the adaptation, K₂", steps.stable_range.k2_max, "unit/BLU"),
    ]
    for k1, k2 in steps.stable_range.curve:
        parameters = [*parameters, (f"limit of K₂ where K₁ is {k1:g}", k2, "unit/BLU")]
    if steps.narrows_zero:
        narrowed = ("rules of ZR, when the error leaves it", "a step narrower", "\u2013")
        parameters = [*parameters, narrowed]
    adapted = at_the_end(record, shown)
    return [
        flc.controller(record, JUDGES, behind=parameters),
        *([_adaptation(record, adapted)] if adapted else []),
        flc.stable_gains(record, shown, adapted),
    ]


def at_the_end(record: AflcDesign, shown: ReportContext) -> dict[str, FuzzyRecord]:
    """Return the adapted controller of each axis at the end of the motion, by the axis' name."""
    each = (shown.signals or {}).items()
    return {shown.called(axis): record.adapted(last_memory(record, x)) for axis, x in each}


def _adaptation(record: FuzzyRecord, adapted: dict[str, FuzzyRecord]) -> Section:
    drawings = []
    for axis, after in adapted.items():
        drawings += [
            Drawing(
                rule_table(after, f"rule table of {axis}, adapted", record),
                f"Heat map of the adapted rule table of {axis}",
                f"Rule table of {axis} at the end of the motion: the numbers are the "
                "commands [unit] by then, the colours how far they have moved.",
            ),
            Drawing(
                terms(after, f"terms of {axis}, adapted", record),
                f"Adapted membership functions of {axis}",
                f"Terms of {axis} at the end of the motion; grey: {flc.ORIGINAL}.",
            ),
            flc.drawn_surface(
                after,
                f"control surface of {axis}, adapted",
                f", of {axis} at the end of the motion",
            ),
        ]
    text = (
        "Each axis starts from the table and the terms above and adapts its own copy "
        "while it moves."
    )
    return Section("Result of the adaptation", text, None, drawings)
