"""Commands that simulate: design, score and simulate one design; batch many, for report."""

from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hfc_design.cli.options import (
    CHOICES,
    CHOSEN,
    PATH,
    Texts,
    as_json,
    force,
    knowing_plugins,
    memory,
    on_scenario,
    on_scenarios,
    output,
    setting,
    with_plugins,
)
from hfc_design.cli.trading import show_front, trading

if TYPE_CHECKING:
    from hfc_design.files.design import Design
    from hfc_design.files.scenario import Scenario

FILE = click.Path(path_type=Path, exists=True, dir_okay=False)
#: Option of hfc design -> key of the scenario.
KEYS = {
    "seed": "run.seed",
    "population": "search.population",
    "generations": "search.generations",
    "preset": "search.preset",
    "precision": "run.precision",
}
PARETO_HELP = "Look for the front of two or three objectives, as in tracking,effort."
PRESET_HELP = "Search strategy, see hfc list strategies [default: the scenario's, else race]."
ANYWAY_HELP = "Resume what another version, file or own part began; it may end otherwise."
SAMPLES_HELP = "Machines to draw [default: 1000; robust.unseen, where the scenario has it]."
DEFAULT = "c-axis-practical"
BATCH_SET_HELP = "Change a value in every cell by its dotted key, as in search.generations=20."


@click.command()
@click.argument("scenario", required=False)
@click.option("--out", type=PATH, help="Run folder [default: runs/NAME-N].")
@click.option("--seed", type=click.IntRange(min=0), help="Seed of the search [default: 0].")
@click.option("--population", type=int, help="Individuals in a generation.")
@click.option("--generations", type=int, help="Generations.")
@click.option("--preset", help=PRESET_HELP)
@click.option("--pareto", metavar="NAME,NAME", help=PARETO_HELP)
@click.option("--precision", type=click.Choice(["float32", "float64"]), help="Of the search.")
@setting
@click.option("--resume", is_flag=True, help="Continue the run in --out where it stopped.")
@click.option("--anyway", is_flag=True, help=ANYWAY_HELP)
@click.option("--quiet", is_flag=True, help="No progress.")
@memory
@with_plugins(CHOICES)
def design(
    scenario: str | None,
    changes: Texts,
    out: Path | None,
    resume: bool,
    anyway: bool,
    quiet: bool,
    pareto: str | None,
    **options: Any,
) -> None:
    """Search a controller for SCENARIO (a built-in name or a TOML file).

    Without arguments: c-axis-practical, the C-axis within tolerances, in several motions, with
    sensors and limits as drives have them.
    """
    from hfc_design.cli import shown
    from hfc_design.cli.usable_table import show_usable
    from hfc_design.core.lock import alone
    from hfc_design.core.plugins import resuming
    from hfc_design.core.records import RunError, UserError
    from hfc_design.files.scenario import load_scenario
    from hfc_design.report.page import BASELINES, write_page
    from hfc_design.runs import run
    from hfc_design.runs.problem import check_memory

    plugins = [*filter(None, [options.pop(key) for key in CHOSEN])]
    told = {key: x for name, key in KEYS.items() if (x := options.pop(name)) is not None}
    if pareto is not None and not resume:
        told = trading(scenario or DEFAULT, pareto, told, [*plugins, *changes])
    given = [f"{key}={x}" for key, x in told.items()]
    if anyway and not resume:
        raise UserError("--anyway needs --resume")
    if not resume:
        found = load_scenario(scenario or DEFAULT, [*plugins, *given, *changes])
        check_memory(found)
        folder = out or shown.free_folder(found.name)
    elif out is None or scenario is not None or given or changes or pareto:
        raise UserError("--resume needs --out DIR and nothing else: config.toml says the rest")
    else:
        found, folder = run.opened_run(out), out
    click.get_current_context().with_resource(alone(folder))  # until the report is written
    if not resume:
        found = run.new_run(found, folder)
    watch = shown.Watch(found)
    try:
        with nullcontext() if quiet else watch:
            own = {} if quiet else {"on_generation": watch.generation}
            result = run.run(found, folder, anyway=anyway, **own)
    except KeyboardInterrupt:
        raise RunError(f"interrupted; {resuming(folder)}") from None
    except RunError as error:
        raise RunError(f"{error} (run folder {folder})") from None
    summary = "" if quiet else watch.summary()
    rivals = write_page(found, result, folder)
    show_usable(run.kept_use(folder))
    names = BASELINES.get(found.plant.name, {})
    rows = {"this design": result.evaluation} | {names[k].short: x for k, x in rivals.items()}
    shown.show_table(found, rows, summary)
    if result.front is not None:
        show_front(result.front)
    click.echo(f"run folder {folder}\nreport     {folder / 'report.html'}")


@click.command()
@on_scenarios
@click.option("--spread", type=float, help="Vary the machine's parameters by up to this share.")
@click.option("--samples", type=int, help=SAMPLES_HELP)
@click.option("--seed", type=int, help="Seed of the draw [default: 0].")
@output("--plot", help="Draw the metrics' distributions.")
@force
@memory
@as_json
@with_plugins(CHOICES)
def score(
    found: "Design",
    scenarios: list["Scenario"],
    spread: float | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Fitness, merit and metrics of DESIGN (a built-in name, a design file or a run folder).

    With --spread 0.2 on many machines, each physical parameter within 20 % of its value: the
    share that is stable, and quantiles of every metric. Stable is what settles: a copy that began
    a little off ends on the same motion, no drive stays at a limit of its command, the error of
    the last quarter stays near that of the nominal machine or within 5 % of the way.
    """
    from hfc_design.cli import shown
    from hfc_design.core.records import UserError
    from hfc_design.files.kept import kept
    from hfc_design.files.pairing import machine

    given = {name: value for name, value in options.items() if value is not None}
    if spread is None and given:
        raise UserError(f"--{next(iter(given))} needs --spread, as in --spread 0.2")
    if "plot" in given and len(scenarios) > 1:
        raise UserError("--plot draws one scenario; name only one")
    for where in scenarios:  # before the first one takes its time
        machine(found, where)
    for k, where in enumerate(scenarios):
        if k and not as_json:
            click.echo()
        shown.score_one(found, where, spread, as_json, **given)
        elsewhere = click.get_current_context().params["scenario"] and not as_json
        for note in kept(found, where) if elsewhere else ():
            click.echo(note)


@click.command()
@on_scenario
@output("--csv", "csv_file", help="Write the trajectory.")
@output("--plot", help="Draw it (png, svg or pdf).")
@click.option("--motion", help="Which one, of a scenario of several [default: the first].")
@force
@memory
@with_plugins(CHOICES)
def simulate(
    found: "Design", where: "Scenario", csv_file: Path | None, plot: Path | None, motion: str | None
) -> None:
    """Simulate DESIGN and write its trajectory; without --csv or --plot to stdout as CSV."""
    from hfc_design.simulation.evaluation import evaluate, notes, trajectory_csv

    if motion is not None or where.motions:
        where = where.motion(motion)

    evaluation = evaluate(found, where)
    for note in notes(where, {found.name: evaluation}):
        click.echo(note, err=True)
    if plot is not None:
        from hfc_design.pictures.figure import save
        from hfc_design.report import plots

        save(plots.motion(evaluation, f"{found.name} on {where.name}"), plot)
    if csv_file is not None:
        from hfc_design.core.checkpoint import write_whole

        write_whole(csv_file, trajectory_csv(evaluation).encode())
    if csv_file is None and plot is None:
        click.echo(trajectory_csv(evaluation), nl=False)


@click.command()
@click.argument("folder", type=PATH)
@click.option("--each", is_flag=True, help="Also write the page of every run that lacks one.")
@click.option("--parquet", is_flag=True, help="Also write runs.parquet (needs pyarrow).")
@knowing_plugins
def report(folder: Path, each: bool, parquet: bool) -> None:
    """Write report.html of a run FOLDER, or of all runs below a FOLDER.

    Of many runs: medians and quartiles over the seeds, convergence, significance, what failed;
    the same numbers as runs.csv, groups.csv and comparisons.csv.
    """
    from hfc_design.batch.report import report

    report(folder, each, parquet)


@click.command()
@click.argument("file", required=False, type=PATH)
@click.option("--out", type=PATH, help="Folder [default: runs/NAME].")
@click.option("--set", "changes", multiple=True, metavar="KEY=VALUE", help=BATCH_SET_HELP)
@click.option("--dry-run", is_flag=True, help="Show the plan and how long it will take.")
@click.option("--status", type=PATH, help="What became of a batch's cells.")
@click.option("--workers", type=click.IntRange(min=1), help="Run so many cells at once, here.")
@click.option("--scheduler", metavar="ADDRESS", help="Run them on the workers of a Dask scheduler.")
@click.option("--shared", is_flag=True, help="Those workers see the folder: they write into it.")
@click.option("--tls-ca", type=FILE, help="Who signs the scheduler's and our certificate.")
@click.option("--tls-cert", type=FILE, help="Our certificate.")
@click.option("--tls-key", type=FILE, help="Its key.")
@click.option("--anyway", is_flag=True, help=ANYWAY_HELP)
@memory
@knowing_plugins
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
