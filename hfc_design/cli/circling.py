"""``hfc circle``: deviations and diagnosis of a circle."""

from functools import partial
from pathlib import Path
from typing import Any

from hfc_design.cli import options as common
from hfc_design.cli.binding import Answer, Texts, argument, command, option
from hfc_design.cli.functions import function
from hfc_design.cli.names import DESIGN, SCENARIO
from hfc_design.cli.usage import refusal

LIMITS = option(None, "--limit", metavar="NAME=NUMBER")


@command(last=common.KNOWING)
def circle(
    source: str = argument(DESIGN, metavar="LOG|RUN|DESIGN"),
    others: Texts = common.CHANGING,
    scenario: str | None = option(common.SCENARIO_HELP, kind=SCENARIO),
    changes: Texts = common.SETTING,
    call: partial[Any] = function("calls.circling.circle", "of", "scenario", limits=LIMITS),
    plot: Path | None = common.output("Draw the chart (png, svg or pdf)."),
    pdf: Path | None = common.output("Write a page A4 for a customer."),
) -> Answer:
    """ISO 230-4 numbers and diagnosis of a circle."""
    from hfc_design.calls.circling import is_log
    from hfc_design.core.overrides import set_keys
    from hfc_design.plotting.files import save

    of: Any = source, None
    if not is_log(source):
        loops = common.loops_of(source, others, (scenario,) if scenario else (), changes, "plant")
        of = loops.design, loops.only
    elif others or scenario or changes:
        raise refusal("--change, --scenario and --set: apply to designs (got a log)")
    limits, about = set_keys(call.keywords["limits"], "limit"), call.keywords["about"]
    result = call(*of, limits=limits, about=[*about, f"source: {source}"])
    for path, page in ((plot, False), (pdf, True)):
        if path:
            save(result.figure(page), path)
    return Answer(result.numbers(), result.tables, [*filter(None, (plot, pdf))])
