"""Commands that look into a design without simulating it: explain, stability."""

import json
from pathlib import Path

import click

from hfc_design.cli.options import changing_design
from hfc_design.cli.plugin_options import knowing_plugins


@click.command()
@click.argument("design")
@changing_design
@click.option(
    "--at",
    "samples",
    multiple=True,
    required=True,
    metavar="SIGNAL=NUMBER,...",
    help="Signals of a sample; given again for each sample that follows, the last is explained.",
)
@click.option("--least", type=float, default=0.01, help="Hide rules of a smaller share [0.01].")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout, every rule.")
@knowing_plugins
def explain(
    design: str, others: tuple[str, ...], samples: tuple[str, ...], least: float, as_json: bool
) -> None:
    """Which rules of DESIGN fire at a sample, how strongly, and what its command is made of.

    Every signal that DESIGN reads has to be given. With one --at that includes what it remembers
    of the sample before, as in previous_velocity=0.02; a feed drive's takes previous_error or
    error_change. Integral and adaptation are then as before the first sample. With several --at
    the controller steps through them from rest, and adapts.
    """
    from hfc_design.runtime.explain import explanation
    from hfc_design.simulation.evaluation import load_design

    found = explanation(load_design(design, others), samples)
    if as_json:
        click.echo(json.dumps(found))
        return
    from hfc_design.cli.explain_tables import show

    show(found, least)


@click.command()
@click.argument("design", required=False)
@changing_design
@click.option("--gain", type=float, help="K [(BLU/s)/unit] [default: the design's, or 28.3].")
@click.option("--time-constant", type=float, help="tau [s] [default: the design's, or 0.055].")
@click.option("--sample-time", type=float, help="T [s] [default: the design's, or 0.01].")
@click.option("--plot", type=click.Path(path_type=Path), help="Draw the range (png, svg or pdf).")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
@knowing_plugins
def stability(
    design: str | None,
    others: tuple[str, ...],
    plot: Path | None,
    as_json: bool,
    **options: float | None,
) -> None:
    """Gains of a fuzzy controller that keep the drive K/(s (tau s + 1)) stable.

    With DESIGN (kind flc, aflc or soflc) also the gains of its rule table; one for another plant
    than a feed drive needs --gain and --time-constant. Without anything: the drive of Jee & Koren
    2004.
    """
    from hfc_design.controllers.flc import gains as report
    from hfc_design.core.records import UserError
    from hfc_design.stability.stable_range import stable_range

    given = {key: value for key, value in options.items() if value is not None}
    if design is None:
        if others:
            raise UserError("--change needs a DESIGN")
        points = {}
        drive = {"gain": 28.3, "time_constant": 0.055, "sample_time": 0.01} | given
    else:
        from hfc_design.simulation.evaluation import load_design

        record = load_design(design, others)
        points = report.points(record)
        drive = report.drive(record, given)
    found = stable_range(**drive)
    if plot is not None:
        from hfc_design.controllers.flc.range_picture import stability_figure
        from hfc_design.report.plots import save

        save(stability_figure(found, points), plot)
    if as_json:
        click.echo(json.dumps(report.numbers(found, points)))
    else:
        report.show(found, points)
