"""Commands that tell what is known without simulating: list, explain, stability."""

import json
from pathlib import Path

import click

from hfc_design.cli import options as common
from hfc_design.cli.options import Texts
from hfc_design.cli.showing import LISTED, PLURALS

SINGULARS = {
    other: what
    for what, kind in LISTED.items()
    for other in (kind, *(many for many, one in PLURALS.items() if one == kind and many != what))
}
SIGNALS = "SIGNAL=NUMBER,..."
AT_HELP = "Signals of a sample; given again for each sample that follows, the last is explained."


@click.command("list")
@click.argument("what", metavar="WHAT", type=common.OrElse(LISTED, SINGULARS))
@common.knowing_plugins
def list_(what: str) -> None:
    """What is built in.

    WHAT is one of scenarios, designs, plants, controllers, fitnesses, strategies and formats.
    """
    if what == "plants":
        from hfc_design.cli.plant_tables import show_plants

        show_plants()
        return
    from hfc_design.cli import show_reference

    show_reference.show(LISTED[what], None, as_json=False)


@click.command(short_help="Which rules of DESIGN fire at a sample, and how strongly.")
@click.argument("design", type=common.DESIGN)
@common.changing
@click.option("--at", "samples", multiple=True, required=True, metavar=SIGNALS, help=AT_HELP)
@click.option("--axis", default="", help="Of a controller with several: the axis to explain.")
@click.option("--least", type=float, default=0.01, help="Hide smaller shares [default: 0.01].")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout, every rule.")
@common.knowing_plugins
def explain(
    design: str, others: Texts, samples: Texts, axis: str, least: float, as_json: bool
) -> None:
    """Which rules of DESIGN fire at a sample, how strongly, and what its command is made of.

    Every signal that DESIGN reads has to be given. With one --at that includes what it remembers
    of the sample before, as in previous_velocity=0.02; a feed drive's takes previous_error or
    error_change. Integral and adaptation are then as before the first sample. With several --at
    the controller steps through them from rest, and adapts.
    """
    from hfc_design.files.pairing import load_design
    from hfc_design.runtime.explain import explained

    found = explained(load_design(design, others), samples, axis)
    if as_json:
        click.echo(json.dumps(found))
    else:
        from hfc_design.cli.explain_tables import show

        show(found, least)


@click.command(short_help="Gains that keep a drive stable; margins of a loop.")
@click.argument("design", required=False, type=common.DESIGN)
@common.changing
@common.named("--scenario", kind=common.SCENARIO, help="Another than DESIGN was made for.")
@click.option("--gain", type=float, help="K [(BLU/s)/unit] [default: the design's, or 28.3].")
@click.option("--time-constant", type=float, help="tau [s] [default: the design's, or 0.055].")
@click.option("--sample-time", type=float, help="T [s] [default: the design's, or 0.01].")
@common.output("--plot", help="Draw the range (png, svg or pdf).")
@common.force
@common.as_json
@common.knowing_plugins
def stability(
    design: str | None,
    others: Texts,
    scenario: str | None,
    plot: Path | None,
    as_json: bool,
    **options: float | None,
) -> None:
    """Gains of a fuzzy controller that keep the drive K/(s (tau s + 1)) stable; margins of a loop.

    Without anything: the range of the drive of Jee & Koren 2004; with a DESIGN of kind flc, aflc or
    soflc also the gains of its rule table, on another plant than a feed drive with --gain and
    --time-constant. With any DESIGN alone: the loop as it is simulated on its scenario, opened at
    its command and linearised at rest and at the speeds of its motions. Gain, phase and delay
    margin, largest sensitivity, bandwidth and compliance, of the nominal machine and a band over
    others.
    """
    from hfc_design.calls.stability import stability
    from hfc_design.core.records import UserError

    if design is None and others:
        raise UserError("--change needs a DESIGN")
    found = stability(design, others, scenario=scenario, **options)
    if plot is not None:
        from hfc_design.pictures.files import save

        save(found.figure(), plot)
    if as_json:
        click.echo(json.dumps(found.numbers()))
        return
    found.show()
    if plot is not None:
        click.echo(plot)
