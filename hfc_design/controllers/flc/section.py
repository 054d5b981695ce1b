"""What the page shows of a feed drive's fuzzy controller."""

from hfc_design.controllers.flc import pictures as fuzzy_plots
from hfc_design.controllers.flc.record import FlcDesign, FuzzyRecord, points
from hfc_design.controllers.kind import Shown
from hfc_design.pictures.section import Drawing, Listing, Rows, Section
from hfc_design.stability import report as stability
from hfc_design.stability.picture import stability_figure
from hfc_design.stability.stable_range import stable_range

ORIGINAL = "as designed"
#: What has to be known of a form of the flc (JK95 eq. 1) to read its table.
FORMS = {
    "P": "In the form P it takes the change for zero. ",
    "PI": "In the form PI the rules say by how much what they command is to change. ",
    "PD": "",
}
Parameters = list[tuple[str, float | str, str]]


def sections(record: FlcDesign, shown: Shown) -> list[Section]:
    """The table, the terms, the gains in the stable range."""
    form: Parameters = [("form of the controller (JK95 eq. 1)", record.form, "\u2013")]
    return [
        controller(record, FORMS[record.form], form, []),
        stable_gains(record, shown, {}),
    ]


def table_sections(record: FuzzyRecord, shown: Shown) -> list[Section]:
    """The same of another kind, as far as it is the same."""
    return [controller(record, "", [], []), stable_gains(record, shown, {})]


def controller(record: FuzzyRecord, kind: str, before: Parameters, behind: Parameters) -> Section:
    """The table and the terms; ``kind`` says more, with parameters before and behind the gain."""
    text = (
        f"Every {1e3 * record.sample_time_s:g} ms the control reads the error of each axis and its "
        f"change since the last sample. {kind}To what the rules command it adds the integral of "
        "the error. One BLU is a step of the encoder, one unit a step of the converter."
    )
    rows = _parameters(record, before, behind)
    return Section(
        "The controller",
        text,
        Listing("Gains, steps and limits.", ["parameter", "value", "unit"], rows),
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


def _parameters(record: FuzzyRecord, before: Parameters, behind: Parameters) -> Rows:
    rows = [*before, ("integral gain", record.integral_gain, "unit/(BLU s)"), *behind]
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


def stable_gains(record: FuzzyRecord, shown: Shown, adapted: dict[str, FuzzyRecord]) -> Section:
    """Sectors of the table in the stable range of the axis with the largest gain."""
    own = points(record)
    for axis, after in adapted.items():
        own[f"{axis}, adapted"] = points(after)["table, with its edges"]
    axes = zip(shown.machine.drives, shown.parameters, strict=True)
    linear = [drive.linear(parameters) for drive, parameters in axes if drive.linear]
    drive = stability.drive_of("this plant is", linear, record.sample_time_s, {})
    found = stable_range(**drive)
    told = stability.numbers(found, own)["points"]
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
                stability_figure(found, own),
                "Stable range of the gains K₁ and K₂ with the design in it",
                "Stable range and the gains of the design.",
            )
        ],
    )
