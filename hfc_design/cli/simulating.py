"""Commands that simulate: score and simulate one design; batch many, for report."""

from functools import partial
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import click

from hfc_design.cli import options as common

if TYPE_CHECKING:
    from hfc_design.files.design import Design
    from hfc_design.files.scenario import Scenario

FILE = click.Path(path_type=Path, exists=True, dir_okay=False)
SAMPLES_HELP = "Machines to draw [default: 1000; robust.unseen, where the scenario has it]."
BATCH_SET_HELP = "Change a value in every cell by its dotted key, as in search.generations=20."


@click.command(short_help="Fitness, merit and metrics of DESIGN, and its robustness.")
@common.on_scenarios
@click.option("--spread", type=float, help="Vary the machine's parameters by up to this share.")
@click.option("--samples", type=int, help=SAMPLES_HELP)
@click.option("--seed", type=int, help="Seed of the draw [default: 0].")
@click.option("--motion", help="Only this one, of a scenario of several, and on all machines.")
@common.output("--plot", help="Draw the metrics' distributions.")
@common.force
@common.memory
@common.as_json
@common.with_plugins(common.CHOICES)
def score(
    found: "Design",
    scenarios: list["Scenario"],
    spread: float | None,
    as_json: bool,
    motion: str | None,
    **options: Any,
) -> None:
    """Fitness, merit and metrics of DESIGN (a built-in name, a design file or a run folder).

    With --plant on another plant, whose parameters --set plant.parameters.NAME=... gives: nearest
    to a test of the model, wherever the signals that DESIGN reads are there in the same units.

    With --spread 0.2 on many machines, each physical parameter within 20 % of its value: the
    share that is stable, and quantiles of every metric. Stable is what settles: a copy that began
    a little off ends on the same motion, no drive stays at a limit of its command, the error of
    the last quarter stays near that of the nominal machine or within 5 % of the way.
    """
    from hfc_design.cli import shown
    from hfc_design.core.records import UserError
    from hfc_design.files.pairing import machine

    given = {name: value for name, value in options.items() if value is not None}
    if spread is None and given:
        raise UserError(f"--{next(iter(given))} needs --spread, as in --spread 0.2")
    if "plot" in given and len(scenarios) > 1:
        raise UserError("--plot draws one scenario; name only one")
    if motion is not None:
        scenarios = [where.motion(motion) for where in scenarios]
    for where in scenarios:  # before the first one takes its time
        machine(found, where)
    for k, where in enumerate(scenarios):
        if k and not as_json:
            click.echo()
        shown.score_one(found, where, spread, as_json, **given)
        named = click.get_current_context().params["scenario"]
        if (named or where.plant.name != found.plant.name) and not as_json:
            _show_kept(found, where)


def _show_kept(design: "Design", scenario: "Scenario", err: bool = False) -> None:
    """What of its own a design keeps on a scenario that it was not made with."""
    from hfc_design.files.kept import kept

    for note in kept(design, scenario):
        click.echo(note, err=err)


@click.command(short_help="Simulate DESIGN and write its trajectory, or draw it.")
@common.on_scenario
@common.output("--csv", "csv_file", help="Write the trajectory.")
@common.output("--plot", help="Draw it (png, svg or pdf).")
@common.output("--learned", "learned_file", help="Write the design with what it has learnt.")
@click.option("--motion", help="Which one, of a scenario of several [default: the first].")
@common.force
@common.memory
@common.with_plugins(common.CHOICES)
def simulate(
    found: "Design",
    where: "Scenario",
    csv_file: Path | None,
    plot: Path | None,
    learned_file: Path | None,
    motion: str | None,
) -> None:
    """Simulate DESIGN and write its trajectory; without --csv, --plot or --learned to stdout.

    A design that adapts can be written as it is after the motion, to start the next one.
    """
    from hfc_design.core.console import room
    from hfc_design.runtime import Machine
    from hfc_design.simulation.evaluating import evaluate, notes, trajectory_csv

    whole = where
    if motion is not None or where.motions:
        where = where.motion(motion)

    if learned_file is not None:  # who does not adapt is told before it takes its time
        Machine(found, where.plant.machine.axes).learned()
    evaluation = evaluate(found, where)
    for note in notes(where, {found.name: evaluation}):
        click.echo(fill(note, room()), err=True)
    if click.get_current_context().params["scenario"] or whole.plant.name != found.plant.name:
        _show_kept(found, whole, err=True)
    if plot is not None:
        from hfc_design.pictures.files import save
        from hfc_design.report import plots

        save(plots.motion(evaluation, f"{found.name} on {where.name}"), plot)
    if csv_file is not None:
        from hfc_design.core.checkpoint import write_whole

        write_whole(csv_file, trajectory_csv(evaluation).encode())
    if learned_file is not None:
        from hfc_design.formats import FORMATS
        from hfc_design.simulation.evaluating import learned_in

        FORMATS["json"].write(learned_in(found, where, evaluation), learned_file)
    for path in filter(None, (csv_file, plot, learned_file)):
        click.echo(path)
    if csv_file is None and plot is None and learned_file is None:
        click.echo(trajectory_csv(evaluation), nl=False)


@click.command(short_help="Run every cell of a batch FILE: scenarios x seeds x settings.")
@click.argument("file", required=False, type=common.PATH)
@click.option("--out", type=common.PATH, help="Folder [default: runs/NAME].")
@click.option("--set", "changes", multiple=True, metavar="KEY=VALUE", help=BATCH_SET_HELP)
@click.option("--dry-run", is_flag=True, help="Show the plan and how long it will take.")
@click.option("--status", type=common.PATH, help="What became of a batch's cells.")
@click.option("--workers", type=click.IntRange(min=1), help="Run so many cells at once, here.")
@click.option("--scheduler", metavar="ADDRESS", help="Run them on the workers of a Dask scheduler.")
@click.option("--shared", is_flag=True, help="Those workers see the folder: they write into it.")
@click.option("--tls-ca", type=FILE, help="Who signs the scheduler's and our certificate.")
@click.option("--tls-cert", type=FILE, help="Our certificate.")
@click.option("--tls-key", type=FILE, help="Its key.")
@click.option("--anyway", is_flag=True, help=common.ANYWAY_HELP)
@common.memory
@common.knowing_plugins
def batch(
    file: Path | None,
    status: Path | None,
    workers: int | None,
    scheduler: str | None,
    shared: bool,
    **options: Any,
) -> None:
    """Run every cell of a batch FILE (TOML): scenarios x seeds x any setting.

    What is finished is skipped, what broke off goes on where it stopped, what fails stops nothing.
    Without --workers or --scheduler one cell after the other, each on every core.
    """
    from hfc_design.batch import session
    from hfc_design.core.records import UserError

    if (file is None) == (status is None):
        raise UserError("give either a batch file or --status DIR")
    if workers is not None and scheduler is not None:
        raise UserError("give either --workers N or --scheduler ADDRESS")
    if shared and scheduler is None:
        raise UserError("--shared needs --scheduler ADDRESS")
    tls = tuple(options.pop(f"tls_{part}") for part in ("ca", "cert", "key"))
    if any(tls) and not (all(tls) and scheduler):
        raise UserError("--tls-ca, --tls-cert and --tls-key belong together, with --scheduler")
    afar = None
    if workers is not None or scheduler is not None:
        from hfc_design.batch.cluster import connected

        afar = partial(connected, workers, scheduler, shared, tls)
    if status is not None:
        session.show_status(status)
    elif file is not None:
        at_once = 0 if scheduler else workers or 1
        session.batch(file, workers=afar, at_once=at_once, **options)
