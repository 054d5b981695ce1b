"""``hfc circle``: deviations and diagnosis of a circle."""

from pathlib import Path
from typing import Any

from hfc_design.cli import options as common
from hfc_design.cli.binding import Answer, Texts, argument, command, option
from hfc_design.cli.names import DESIGN, SCENARIO
from hfc_design.cli.usage import refusal

COLUMN_HELP = "Column of x, y, x_reference, y_reference or time in LOG, as in 'x=qm [um]'."
LIMIT_HELP = "Largest allowed G, Gb, F or D [mm], as in G=0.02; can be given several times."
ABOUT_HELP = "Line for the page, as in 'machine: VMC 3'; can be given several times."
RADIUS_HELP = "Nominal radius [mm] [default: that of the reference in LOG, else fitted]."


@command("ISO 230-4 numbers and diagnosis of a circle.", last=common.KNOWING)
def circle(
    source: str = argument(DESIGN, metavar="LOG|RUN|DESIGN"),
    others: Texts = common.CHANGING,
    scenario: str | None = option(common.SCENARIO_HELP, kind=SCENARIO),
    changes: Texts = common.SETTING,
    columns: Texts = option(COLUMN_HELP, "--column", metavar="NAME=COLUMN"),
    radius: float | None = option(RADIUS_HELP, low=0.0, open=True),
    feed: float | None = option("Feed [mm/min] [default: by the times].", low=0.0, open=True),
    centred: bool = option("Count F from the least-squares centre of each direction."),
    limits: Texts = option(LIMIT_HELP, "--limit", metavar="NAME=NUMBER"),
    about: Texts = option(ABOUT_HELP),
    plot: Path | None = common.output("Draw the chart (png, svg or pdf)."),
    pdf: Path | None = common.output("Write a page A4 for a customer."),
    _force: bool = common.FORCE,
    _as_json: bool = common.AS_JSON,
) -> Answer:
    """ISO 230-4 numbers of a circle, and the causes of its deviations.

    In a LOG, of any format that hfc identify reads, the first full turn of each direction counts,
    without run-up and feed-out. A design is simulated in both directions on the circle of its
    scenario. The causes are backlash, reversal spikes, servo mismatch, scale mismatch, squareness,
    radius, centre offset and vibration.
    """
    from hfc_design.calls import circling as calls
    from hfc_design.core.overrides import set_keys
    from hfc_design.plotting.files import save

    of: Any = source, None
    if not calls.is_log(source):
        loops = common.loops_of(source, others, (scenario,) if scenario else (), changes, "plant")
        of = loops.design, loops.only
    elif others or scenario or changes:
        raise refusal("--change, --scenario and --set: apply to designs (got a log)")
    known: Any = {"columns": columns, "radius": radius, "feed": feed, "centred": centred}
    known |= {"limits": set_keys(limits, "limit"), "about": [*about, f"source: {source}"]}
    result = calls.circle(*of, **known)
    for path, page in ((plot, False), (pdf, True)):
        if path:
            save(result.figure(page), path)
    return Answer(result.numbers(), result.tables, [*filter(None, (plot, pdf))])
