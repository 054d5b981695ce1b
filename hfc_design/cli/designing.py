"""``hfc design``: a search from the options of a command line to tables on a terminal."""

import shlex
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hfc_design.cli import options as common
from hfc_design.cli.options import Texts
from hfc_design.cli.trading import numbers_of, show_front, trading

if TYPE_CHECKING:
    from hfc_design.files.design import Design
    from hfc_design.files.scenario import Scenario
    from hfc_design.runs.run import Result

#: Option of the command -> key of the scenario.
KEYS = {
    "seed": "run.seed",
    "population": "search.population",
    "generations": "search.generations",
    "preset": "search.preset",
    "precision": "run.precision",
    "polish": "run.polish",
}
PARETO_HELP = "Look for the front of two or three objectives, as in tracking,effort."
EXTEND_HELP = "Search again while the answer is not yes, three times at most [default: --extend]."
POLISH_HELP = "Steps that polish the design when the search has ended [default: 0]."
GAINS_HELP = "No search: a controller by hand, as in --controller pid+ff --gains kp=900,kd=2."
PRESET_HELP = "Search strategy: NAMES [default: the scenario's, else race]."
DEFAULT = "c-axis-practical"


@click.command(short_help="Search a controller for SCENARIO.")
@click.argument("scenario", required=False, type=common.SCENARIO)
@click.option("--out", type=common.PATH, help="Run folder [default: runs/NAME-N].")
@click.option("--seed", type=click.IntRange(min=0), help="Seed of the search [default: 0].")
@click.option("--population", type=int, help="Individuals in a generation.")
@click.option("--generations", type=int, help="Generations.")
@common.named("--preset", kind=common.STRATEGY, help=PRESET_HELP)
@click.option("--pareto", metavar="NAME,NAME", help=PARETO_HELP)
@click.option("--precision", type=click.Choice(["float32", "float64"]), help="Of the search.")
@click.option("--polish", metavar="STEPS", type=click.IntRange(min=0), help=POLISH_HELP)
@click.option("--extend/--no-extend", default=None, help=EXTEND_HELP)
@click.option("--gains", metavar="NAME=NUMBER,...", help=GAINS_HELP)
@common.setting
@click.option("--resume", is_flag=True, help="Continue the run in --out where it stopped.")
@click.option("--anyway", is_flag=True, help=common.ANYWAY_HELP)
@click.option("--quiet", is_flag=True, help="No progress.")
@common.memory
@common.with_plugins(common.CHOICES)
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
    from hfc_design.cli.usable_table import again_told, settling_told, show_usable
    from hfc_design.core.console import busy
    from hfc_design.core.lock import alone
    from hfc_design.core.records import in_a_line
    from hfc_design.files.doubts import doubts
    from hfc_design.report.page import write_page
    from hfc_design.report.parts import baselines
    from hfc_design.runs import run
    from hfc_design.runs.polishing import polish_told

    found, folder, given = _asked_for(scenario, changes, out, resume, anyway, pareto, options)
    click.get_current_context().with_resource(alone(folder))  # until the report is written
    if not resume:
        found = run.new_run(found, folder, given)
    for line in doubts(found):  # a search with a wrong unit takes as long as with the right one
        click.echo(in_a_line(f"hfc: warning: {line}"), err=True)
    result, summary = _searched(found, folder, anyway, quiet or given is not None)
    told = _near_the_best(found, result, folder)
    with nullcontext() if quiet else busy("the report, on machines that no search has seen"):
        rivals = write_page(found, result, folder)
    use = run.kept_use(folder)
    show_usable(use)
    if line := settling_told(use, found.constraints):
        click.echo(line)
    names = baselines(found)
    rows = {"this design": result.evaluation} | {names[k].short: x for k, x in rivals.items()}
    shown.show_table(found, rows, summary)
    if line := polish_told(result.design):
        click.echo(line)
    if result.front is not None:
        show_front(result.front)
    if told:
        click.echo(told)
    if result.search is not None and (line := again_told(use, found.run.seed + 1)):
        click.echo(line)
    click.echo(f"run folder {folder}\nreport     {folder / 'report.html'}")


def _near_the_best(scenario: "Scenario", result: "Result", folder: Path) -> str:
    """How near the design of one limited motion of a C-axis is to any controller's best, a line.

    Of several motions that takes longer; ``hfc attainable`` does it when somebody asks.
    """
    from hfc_design.attainable.attainable import check
    from hfc_design.core.records import RunError, UserError
    from hfc_design.runs.attained import attained_told, keep_attained

    try:
        check(scenario)
        if scenario.motions:
            command = f"hfc attainable {shlex.quote(str(folder))}"
            return f"How near is it to the best possible controller? {command}"
        return attained_told(keep_attained(scenario, result.design, folder))
    except (UserError, RunError):  # there is no bound, or it was not found
        return ""


def _asked_for(
    scenario: str | None,
    changes: Texts,
    out: Path | None,
    resume: bool,
    anyway: bool,
    pareto: str | None,
    options: dict[str, Any],
) -> tuple["Scenario", Path, "Design | None"]:
    """The scenario and the folder of the run that the options ask for, and a design by hand.

    Raises:
        UserError: options do not go together, a value is not allowed, or there is no such run.
        RunError: the folder cannot be made.
    """
    from hfc_design.calls.searching import with_gains
    from hfc_design.cli import shown
    from hfc_design.core.dotted import changed
    from hfc_design.core.records import UserError
    from hfc_design.files.named_scenario import load_scenario
    from hfc_design.runs import run
    from hfc_design.runs.problem import check_memory

    gains = options["gains"]
    plugins = [*filter(None, [options[key] for key in common.CHOSEN])]
    told = {key: x for name, key in KEYS.items() if (x := options[name]) is not None}
    if options["extend"] is False:
        told["run.extend"] = 1
    if pareto is not None and not resume:
        told = trading(scenario or DEFAULT, pareto, told, [*plugins, *changes])
    given = [f"{key}={x}" for key, x in told.items()]
    if anyway and not resume:
        raise UserError("--anyway needs --resume")
    if not resume:
        found = load_scenario(scenario or DEFAULT, [*plugins, *given, *changes])
        known = click.get_current_context().meta.get("hfc.strategy", found.search.preset)
        if known != found.search.preset:  # it is easily thought to be the one that searches
            raise UserError(
                f"--strategy: makes {known} known, and the search would be {found.search.preset}; "
                f"add --preset {known}"
            )
        check_memory(found)
        by_hand = None
        if gains is not None:
            told = numbers_of("--gains", gains, "kp=900,ki=40,kd=2")
            by_hand = with_gains(found, found.controller.kind, changed({}, told, "--gains"))
        return found, out or shown.free_folder(found.name), by_hand
    if out is None or scenario is not None or given or changes or pareto or gains:
        raise UserError("--resume needs --out DIR and nothing else: config.toml says the rest")
    return run.opened_run(out), out, None


def _searched(
    scenario: "Scenario", folder: Path, anyway: bool, quiet: bool
) -> tuple["Result", str]:
    """The result of the run in a folder, and what its search took, "" if ``quiet``.

    Raises:
        RunError: it was interrupted, or found nothing.
    """
    from hfc_design.cli import shown
    from hfc_design.core.plugins import resuming
    from hfc_design.core.records import RunError
    from hfc_design.runs import run

    watch = shown.Watch(scenario)
    try:
        with nullcontext() if quiet else watch:
            own: Any = {}
            if not quiet:
                own = {"on_generation": watch.generation, "on_polish": watch.polished}
                own |= {"on_lap": watch.lap}
            result = run.run(scenario, folder, anyway=anyway, **own)
    except KeyboardInterrupt:
        raise RunError(f"interrupted; {resuming(folder)}") from None
    except RunError as error:
        raise RunError(f"{error.typed} (run folder {folder})") from None
    return result, "" if quiet else watch.summary()
