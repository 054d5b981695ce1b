"""The command line. Commands import what they need when they run, so that help is quick."""

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hfc_design import __version__
from hfc_design.plugin_options import choosing_plugins, knowing_plugins

if TYPE_CHECKING:
    from hfc_design.rulebase import Design
    from hfc_design.scenarios import Scenario

SET_HELP = "Change a value of the scenario by its dotted key, as in simulation.duration_s=5."


class Commands(click.Group):
    """A group whose commands tell a user's mistake in one line."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; UserError becomes a line on stderr and its exit code."""
        from hfc_design.records import UserError

        try:
            return super().invoke(ctx)
        except UserError as error:
            click.echo(f"hfc: {error}", err=True)
            sys.exit(error.exit_code)
        except BrokenPipeError:
            sys.exit(1)


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="hfc")
def main() -> None:
    """Design hierarchical fuzzy controllers for machine-tool drives by simulation."""


@main.command()
@click.argument("scenario", required=False)
@click.option("--out", type=click.Path(path_type=Path), help="Run folder [default: runs/NAME-N].")
@click.option("--seed", type=click.IntRange(min=0), help="Seed of the search [default: 0].")
@click.option("--population", type=int, help="Individuals in a generation.")
@click.option("--generations", type=int, help="Generations.")
@click.option("--preset", help="Search strategy: race (default) or lin-lee-1999.")
@click.option("--precision", type=click.Choice(["float32", "float64"]), help="Of the search.")
@click.option("--set", "changes", multiple=True, metavar="KEY=VALUE", help=SET_HELP)
@click.option("--resume", is_flag=True, help="Continue the run in --out where it stopped.")
@click.option("--quiet", is_flag=True, help="No progress.")
@choosing_plugins
def design(
    scenario: str | None,
    out: Path | None,
    changes: tuple[str, ...],
    resume: bool,
    quiet: bool,
    chosen: dict[str, str],
    **options: Any,
) -> None:
    """Search a controller for SCENARIO (a built-in name or a TOML file).

    Without arguments: the no-load ramp of the C-axis.
    """
    from hfc_design import session

    keys = {
        "seed": "run.seed",
        "population": "search.population",
        "generations": "search.generations",
        "preset": "search.preset",
        "precision": "run.precision",
    }
    given = [f"{keys[name]}={value}" for name, value in options.items() if value is not None]
    plugins = () if resume else chosen.values()  # they only have to be known then
    session.design(scenario, out, [*plugins, *given, *changes], resume, quiet)


@main.command()
@click.argument("design")
@click.option("--scenario", help="Scenario to run it on [default: the one it was made for].")
@click.option("--set", "changes", multiple=True, metavar="KEY=VALUE", help=SET_HELP)
@click.option("--spread", type=float, help="Vary the machine's parameters by up to this share.")
@click.option("--samples", type=int, help="Machines to draw [default: 1000].")
@click.option("--seed", type=int, help="Seed of the draw [default: 0].")
@click.option("--plot", type=click.Path(path_type=Path), help="Draw the metrics' distributions.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
@choosing_plugins
def score(
    design: str,
    scenario: str | None,
    changes: tuple[str, ...],
    chosen: dict[str, str],
    spread: float | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Fitness and metrics of DESIGN (a built-in name, a design file or a run folder).

    With --spread 0.2 on many machines, each physical parameter within 20 % of its value: the
    share that is stable, and quantiles of every metric. Stable is a motion that stays finite and
    in whose last quarter no error is larger than the reference ever is and no drive stands at a
    limit of its command for more than a tenth of the time.
    """
    from hfc_design import session
    from hfc_design.evaluate import evaluate
    from hfc_design.records import UserError

    given = {name: value for name, value in options.items() if value is not None}
    if spread is None and given:
        raise UserError(f"--{next(iter(given))} needs --spread, as in --spread 0.2")
    found, where = _loaded(design, scenario, chosen, changes)
    if spread is not None:
        session.score_spread(found, where, spread, as_json, **given)
        return
    evaluation = evaluate(found, where)
    if as_json:
        line = {
            "design": found.name,
            "scenario": where.name,
            "fitness": evaluation.fitness,
            "diverged": evaluation.diverged,
            **evaluation.metrics,
        }
        click.echo(json.dumps(line))
    else:
        click.echo(f"scenario {where.name}")
        session.show_table(where, {found.name: evaluation})


@main.command()
@click.argument("design")
@click.option("--scenario", help="Scenario to run it on [default: the one it was made for].")
@click.option("--set", "changes", multiple=True, metavar="KEY=VALUE", help=SET_HELP)
@click.option("--csv", "csv_file", type=click.Path(path_type=Path), help="Write the trajectory.")
@click.option("--plot", type=click.Path(path_type=Path), help="Draw it (png, svg or pdf).")
@choosing_plugins
def simulate(
    design: str,
    scenario: str | None,
    changes: tuple[str, ...],
    chosen: dict[str, str],
    csv_file: Path | None,
    plot: Path | None,
) -> None:
    """Simulate DESIGN and write its trajectory; without --csv or --plot to stdout as CSV."""
    from hfc_design.evaluate import evaluate, trajectory_csv

    found, where = _loaded(design, scenario, chosen, changes)
    evaluation = evaluate(found, where)
    if plot is not None:
        from hfc_design.pictures.contour_plots import motion
        from hfc_design.pictures.plots import save

        save(motion(evaluation, f"{found.name} on {where.name}"), plot)
    if csv_file is not None:
        from hfc_design.checkpoint import write_whole

        write_whole(csv_file, trajectory_csv(evaluation).encode())
    if csv_file is None and plot is None:
        click.echo(trajectory_csv(evaluation), nl=False)


@main.command()
@click.argument("design")
@click.option("--to", "target", required=True, help="Format; see hfc list formats.")
@click.option("--out", type=click.Path(path_type=Path), help="File or folder to write.")
@click.option("--lookup", type=click.IntRange(2, 32767), help="Only c: N-point table, no exp.")
@knowing_plugins
def export(design: str, target: str, out: Path | None, lookup: int | None) -> None:
    """Write DESIGN for another program."""
    from hfc_design.evaluate import load_design
    from hfc_design.export import FORMATS, c_source
    from hfc_design.records import UserError

    if target not in FORMATS:
        raise UserError(f"--to {target}: no such format; there is {', '.join(FORMATS)}")
    if lookup is not None and target != "c":
        raise UserError(f"--lookup {lookup}: only --to c has it, not --to {target}")
    found = load_design(design)
    path = out or Path(f"{found.name}.{target}")
    if path.exists():
        raise UserError(f"--out {path}: exists already; name another path")
    if lookup is None:
        FORMATS[target][1](found, path)
    else:
        deviation = c_source.write_lookup(found, path, lookup)
        click.echo(f"largest deviation from the exact command: {deviation}")
    click.echo(path)


@main.command("import")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Design file [default: NAME.json].")
@click.option("--kind", type=click.Choice(["flc", "aflc", "pd+hierarchical-fuzzy"]))
@click.option("--name", help="Of the design [default: the file's].")
@click.option("--plant", type=click.Choice(["feed-drive", "c-axis"]))
@click.option("--sample-time", type=float, help="T [s] [default: 0.01, of a C-axis 0.001].")
@click.option("--like", metavar="DESIGN", help="Take from DESIGN whatever FILE does not hold.")
@click.option(
    "--signal",
    "signals",
    multiple=True,
    metavar="INPUT=SIGNAL",
    help="Which signal an input of FILE is, as in input1=error, where its name does not say so.",
)
def import_(file: Path, out: Path | None, signals: tuple[str, ...], **options: Any) -> None:
    """Read another program's controller FILE: FLL, .fis, or the tables of hfc export --to csv.

    Two inputs of seven terms and a singleton for each of the 49 rules, with product and weighted
    average. Triangles give an flc, or with --kind aflc one that adapts; Gaussians with flat tops
    give a hierarchy of one unit. Whatever a design cannot hold is refused; within the ranges of its
    inputs the design computes what FILE says. A scenario takes an flc or aflc as the start of a
    search with [controller] start = "NAME.json".
    """
    from hfc_design.checkpoint import write_whole
    from hfc_design.importing import Wish, imported
    from hfc_design.records import UserError
    from hfc_design.rulebase import design_json

    pairs = {}
    for item in signals:
        name, equals, signal = item.partition("=")
        if not equals:
            raise UserError(f"--signal {item}: has to be INPUT=SIGNAL, as in input1=error")
        pairs[name] = signal
    design = imported(file, Wish(**options, signals=pairs))
    path = out or Path(f"{design.name}.json")
    if path.exists():
        raise UserError(f"--out {path}: exists already; name another path")
    write_whole(path, (design_json(design) + "\n").encode())
    click.echo(path)


@main.command()
@click.argument("design")
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
def explain(design: str, samples: tuple[str, ...], least: float, as_json: bool) -> None:
    """Which rules of DESIGN fire at a sample, how strongly, and what its command is made of.

    Every signal that DESIGN reads has to be given. With one --at that includes what it remembers
    of the sample before, as in previous_velocity=0.02; a feed drive's takes previous_error or
    error_change. Integral and adaptation are then as before the first sample. With several --at
    the controller steps through them from rest, and adapts.
    """
    from hfc_design.evaluate import load_design
    from hfc_design.explain import explanation

    found = explanation(load_design(design), samples)
    if as_json:
        click.echo(json.dumps(found))
        return
    from hfc_design.explain_tables import show

    show(found, least)


@main.command()
@click.argument("design", required=False)
@click.option("--gain", type=float, help="K [(BLU/s)/unit] [default: the design's, or 28.3].")
@click.option("--time-constant", type=float, help="tau [s] [default: the design's, or 0.055].")
@click.option("--sample-time", type=float, help="T [s] [default: the design's, or 0.01].")
@click.option("--plot", type=click.Path(path_type=Path), help="Draw the range (png, svg or pdf).")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def stability(design: str | None, plot: Path | None, as_json: bool, **drive: float | None) -> None:
    """Gains of a fuzzy controller that keep the drive K/(s (tau s + 1)) stable.

    With DESIGN (kind flc, aflc or soflc) also the gains of its rule table. Without anything: the
    drive of Jee & Koren 2004.
    """
    from hfc_design.stability import report
    from hfc_design.stability.stable_range import stable_range

    own: dict[str, Any] = {"gain": 28.3, "time_constant": 0.055, "sample_time": 0.01}
    points = {}
    if design is not None:
        from hfc_design.evaluate import load_design

        record = load_design(design)
        points = report.points(record)
        own = report.drive(record)
    wanted = {key: own[key] if value is None else value for key, value in drive.items()}
    found = stable_range(**wanted)
    if plot is not None:
        from hfc_design.pictures.plots import save
        from hfc_design.stability.plot import stability_figure

        save(stability_figure(found, points), plot)
    if as_json:
        click.echo(json.dumps(report.numbers(found, points)))
    else:
        report.show(found, points)


@main.command()
@click.argument("file", required=False, type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Folder [default: runs/NAME].")
@click.option("--dry-run", is_flag=True, help="Show the plan and how long it will take.")
@click.option("--status", type=click.Path(path_type=Path), help="What became of a batch's cells.")
@click.option("--workers", type=click.IntRange(min=1), help="Run so many cells at once, here.")
@click.option("--scheduler", metavar="ADDRESS", help="Run them on the workers of a Dask scheduler.")
@click.option("--shared", is_flag=True, help="Those workers see the folder: they write into it.")
@knowing_plugins
def batch(
    file: Path | None,
    out: Path | None,
    dry_run: bool,
    status: Path | None,
    workers: int | None,
    scheduler: str | None,
    shared: bool,
) -> None:
    """Run every cell of a batch FILE (TOML): scenarios x seeds x any setting.

    What is finished is skipped, what broke off goes on where it stopped, what fails stops nothing.
    Without --workers or --scheduler one cell after the other, each on every core.
    """
    from hfc_design.batch import session
    from hfc_design.records import UserError

    if (file is None) == (status is None):
        raise UserError("give either a batch file or --status DIR")
    if workers is not None and scheduler is not None:
        raise UserError("give either --workers N or --scheduler ADDRESS")
    if shared and scheduler is None:
        raise UserError("--shared needs --scheduler ADDRESS")
    here = workers is None and scheduler is None
    where = None if here else session.Where(workers, scheduler, shared)
    if status is not None:
        session.show_status(status)
    elif file is not None:
        session.batch(file, out, dry_run, where)


@main.command()
@click.argument("folder", type=click.Path(path_type=Path))
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


@main.command("list")
@click.argument(
    "what", type=click.Choice(["scenarios", "designs", "plants", "controllers", "formats"])
)
def list_(what: str) -> None:
    """What is built in."""
    from hfc_design import session

    session.show_list(what)


def _loaded(
    name: str, scenario: str | None, chosen: dict[str, str], changes: tuple[str, ...]
) -> "tuple[Design, Scenario]":
    from hfc_design.evaluate import load_design, own_scenario
    from hfc_design.scenarios import load_scenario

    found = load_design(name)
    # The controller is the design's, whatever a search of the scenario would vary.
    plugins = (change for key, change in chosen.items() if key != "controller")
    changes = (*plugins, *changes)
    if scenario is not None:
        return found, load_scenario(scenario, changes)
    return found, own_scenario(found, name, changes)
