"""Commands that analyse a controller: its rules, its margins, the best attainable control."""

from functools import partial
from pathlib import Path
from typing import Any

from hfc_design.cli import options as common
from hfc_design.cli.binding import Answer, Texts, argument, command, option
from hfc_design.cli.functions import drawn, function
from hfc_design.cli.names import DESIGN, SCENARIO

AT_HELP = "Signals of a sample; repeat it for each following sample; the last is explained."


@command("Which rules of DESIGN fire at a sample, and how strongly.", last=common.KNOWING)
def explain(
    design: str = argument(DESIGN),
    others: Texts = common.CHANGING,
    samples: Texts = option(AT_HELP, "--at", required=True, metavar="SIGNAL=NUMBER,..."),
    axis: str = option("Axis to explain, of a controller with several.", default=""),
    least: float = option("Hide shares below this [default: 0.01].", default=0.01),
) -> Answer:
    """Which rules of DESIGN fire at a sample, how strongly, and how its command is composed.

    Give every signal that DESIGN reads. With one --at this includes remembered signals of the
    previous sample, as in previous_velocity=0.02; for a feed drive previous_error or error_change.
    Integral and adaptation then have their initial values. With several --at the controller steps
    through the samples from rest, and adapts.
    """
    from hfc_design.cli.explain_tables import tables
    from hfc_design.files.loop_setup import load_design
    from hfc_design.runtime.explain import explained

    explanation = explained(load_design(design, others), samples, axis)
    return Answer(explanation, partial(tables, explanation, least))


@command(last=common.KNOWING)
def stability(
    call: partial[Any] = function(
        "calls.stability.stability", design=argument(required=False), changes=common.CHANGING
    ),
    plot: Path | None = common.output("Draw the range (png, svg or pdf)."),
) -> Answer:
    """Gains that keep a drive stable; margins of a loop."""
    return drawn(call(), plot)


NEAR_HELP = "Design to rate against the bound [default: that of the run]."


@command(
    "Limits for the best possible controller of a C-axis.",
    last=common.plugins({"plant": common.CHOICES["plant"]}),
)
def attainable(
    name: str = argument(SCENARIO, metavar="SCENARIO"),
    design: str | None = option(NEAR_HELP, kind=DESIGN),
    changes: Texts = common.SETTING,
) -> Answer:
    """Lower and upper limit of the best sum |e| that any controller can reach in SCENARIO.

    SCENARIO is a built-in name, a TOML file, or the folder of a finished run, which then stores the
    result in attainable.json and in its page. It needs a C-axis with a voltage limit, and considers
    the nominal machine: a certified lower bound, and the result of the best open-loop voltage found
    with full knowledge of the motion.
    """
    from hfc_design.files.named_scenario import load_scenario
    from hfc_design.report.page import write_page
    from hfc_design.runs.attained import attained, attained_table, keep_attained
    from hfc_design.runs.run import DESIGN, finished_run

    folder, every = Path(name), [*common.choosing("plant"), *changes]
    if (folder / DESIGN).is_file() and not (every or design):
        scenario, result = finished_run(folder)
        numbers = keep_attained(scenario, result.design, folder)
        write_page(scenario, result, folder)
    else:
        source = str(folder / "config.toml") if folder.is_dir() else name
        numbers = attained(load_scenario(source, every), design)
    return Answer(numbers, lambda: [attained_table(numbers)])
