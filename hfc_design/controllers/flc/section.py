"""What the page shows of a feed drive's fuzzy controller, kinds flc and aflc."""

from hfc_design.controllers.aflc.adapted import at_the_end
from hfc_design.controllers.flc import gains as stability
from hfc_design.controllers.flc import pictures as fuzzy_plots
from hfc_design.controllers.flc.range_picture import stability_figure
from hfc_design.controllers.flc.record import AflcDesign, FlcDesign, FuzzyRecord
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.pictures.section import Drawing, Listing, Rows, Section
from hfc_design.simulation.evaluation import Evaluation
from hfc_design.stability.stable_range import stable_range

ORIGINAL = "as designed"
#: What has to be known of a form of the flc (JK95 eq. 1) to read its table.
FORMS = {
    "P": "In the form P it takes the change for zero. ",
    "PI": "In the form PI the rules say by how much what they command is to change. ",
    "PD": "",
}


def sections(design: Design, own: Evaluation, scenario: Scenario) -> list[Section]:
    """The table, the terms, what the adaptation made of them, the gains in the stable range.

    Raises:
        ValueError: the design is of another kind.
    """
    record = _fuzzy(design)
    adapted = at_the_end(design, own, scenario)
    return [
        _controller(record),
        *([_adaptation(record, adapted)] if adapted else []),
        _stability(design, adapted),
    ]


def _fuzzy(design: Design) -> FuzzyRecord:
    if not isinstance(design.controller, FuzzyRecord):
        raise ValueError(f"design {design.name} is of kind {design.controller.kind}: no rules")
    return design.controller


def _controller(record: FuzzyRecord) -> Section:
    kind = FORMS[record.form] if isinstance(record, FlcDesign) else ""
    if isinstance(record, AflcDesign):
        kind = (
            "It judges the rules that fired a sample ago by what became of the error, and moves "
            "them. "
        )
    text = (
        f"Every {1e3 * record.sample_time_s:g} ms the control reads the error of each axis and its "
        f"change since the last sample. {kind}To what the rules command it adds the integral of "
        "the error. One BLU is a step of the encoder, one unit a step of the converter."
    )
    return Section(
        "The controller",
        text,
        Listing("Gains, steps and limits.", ["parameter", "value", "unit"], _parameters(record)),
        [
            Drawing(
                fuzzy_plots.rule_table(record, f"rule table {ORIGINAL}"),
                "Heat map of the rule table",
                "Rule table: the command for each pair of terms, from negative large (NL) to "
                "positive large (PL).",
            ),
            Drawing(
                fuzzy_plots.terms(record, f"terms {ORIGINAL}"),
                "Membership functions of the error and of its change",
                "What the terms mean: the degree to which an error and its change belong to each.",
            ),
            Drawing(
                fuzzy_plots.surface(record, f"control surface {ORIGINAL}"),
                "Command of the rules against error and change of error",
                "Control surface: what the rules command between the centres of the terms.",
            ),
        ],
    )


def _parameters(record: FuzzyRecord) -> Rows:
    rows: list[tuple[str, float | str, str]] = []
    if isinstance(record, FlcDesign):
        rows.append(("form of the controller (JK95 eq. 1)", record.form, "\u2013"))
    rows.append(("integral gain", record.integral_gain, "unit/(BLU s)"))
    if isinstance(record, AflcDesign):
        steps = record.adaptation
        rows += [
            ("step of an edge of an error term, k_a", steps.k_a, "BLU"),
            ("step of an edge of a term of the change, k_b", steps.k_b, "BLU"),
            ("step of a command in the rule table, k_c", steps.k_c, "unit"),
            ("limit of the adaptation, K₁", steps.stable_range.k1_max, "unit/BLU"),
            ("limit of the adaptation, K₂", steps.stable_range.k2_max, "unit/BLU"),
        ]
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
    return [[name, v if isinstance(v, str) else f"{v:.5g}", unit] for name, v, unit in rows]


def _adaptation(record: FuzzyRecord, adapted: dict[str, FuzzyRecord]) -> Section:
    drawings = []
    for axis, after in adapted.items():
        drawings += [
            Drawing(
                fuzzy_plots.rule_table(after, f"rule table of {axis}, adapted", record),
                f"Heat map of the adapted rule table of {axis}",
                f"Rule table of {axis} at the end of the motion: the numbers are the commands "
                "[unit] by then, the colours what they have moved by.",
            ),
            Drawing(
                fuzzy_plots.terms(after, f"terms of {axis}, adapted", record),
                f"Adapted membership functions of {axis}",
                f"Terms of {axis} at the end of the motion; grey: {ORIGINAL}.",
            ),
        ]
    text = "Each axis begins with the table and the terms above and adapts its own while it moves."
    return Section("What the adaptation made of it", text, None, drawings)


def _stability(design: Design, adapted: dict[str, FuzzyRecord]) -> Section:
    """Sectors of the table in the stable range of the axis with the largest gain."""
    points = stability.points(design)
    for axis, after in adapted.items():
        changed = design.model_copy(update={"controller": after})
        points[f"{axis}, adapted"] = stability.points(changed)["table, with its edges"]
    drive = stability.drive(design, {})
    found = stable_range(**drive)
    told = stability.numbers(found, points)["points"]
    rows = [
        [name, f"{p['k1']:.4g}", f"{p['k2']:.4g}", "yes" if p["inside"] else "no"]
        for name, p in told.items()
    ]
    return Section(
        "Stability",
        "K₁ is the largest slope of the command over the error, K₂ over its change (Jee & Koren "
        "2004, section 3). The range is that of a drive without friction, of "
        f"{drive['gain']:g} (BLU/s)/unit and {1e3 * drive['time_constant']:g} ms; "
        f"it ends at K₁ = {found.k1:.4g} unit/BLU.",
        Listing(
            "Gains of the rules [unit/BLU]; eq. 13 and 14 look at the centres of the terms alone.",
            ["gains of", "K₁", "K₂", "inside"],
            rows,
        ),
        [
            Drawing(
                stability_figure(found, points),
                "Stable range of the gains K₁ and K₂ with the design in it",
                "Stable range and the gains of the design.",
            )
        ],
    )
