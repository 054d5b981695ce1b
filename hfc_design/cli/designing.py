"""``hfc design``: a search from the options of a command line to tables on a terminal."""

import shlex
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hfc_design.cli import options as common
from hfc_design.cli.binding import Texts, argument, command, option
from hfc_design.cli.names import SCENARIO, STRATEGY
from hfc_design.cli.trading import show_front, trading
from hfc_design.cli.usage import refusal

if TYPE_CHECKING:
    from hfc_design.files.design import Design
    from hfc_design.files.scenario import Scenario
    from hfc_design.runs.run import Result

EXTEND_HELP = "Search again until the answer is yes, at most three times [default: --extend]."
GAINS_HELP = "No search: use these gains, as in --controller pid+ff --gains kp=900,kd=2."
PRESET_HELP = "Search strategy: NAMES [default: the scenario's, else race]."
POLISH_HELP = "Steps of the final local optimisation [default: 0]."
PARETO_HELP = "Search the Pareto front of two or three objectives, as in tracking,effort."
DEFAULT = "c-axis-practical"


@command("Search for a controller for SCENARIO.", last=common.CHOOSING)
def design(
    scenario: str | None = argument(SCENARIO, required=False),
    out: Path | None = option("Run folder [default: runs/NAME-N]."),
    seed: int | None = option("Seed of the search [default: 0].", kind=click.IntRange(0)),
    population: int | None = option("Individuals per generation."),
    generations: int | None = option("Generations."),
    preset: str | None = option(PRESET_HELP, kind=STRATEGY),
    pareto: str | None = option(PARETO_HELP, metavar="NAME,NAME"),
    precision: str | None = option(
        "Floating-point precision of the search.", kind=click.Choice(["float32", "float64"])
    ),
    polish: int | None = option(POLISH_HELP, metavar="STEPS", kind=click.IntRange(0)),
    extend: bool | None = option(EXTEND_HELP, "--extend/--no-extend", default=None),
    gains: str | None = option(GAINS_HELP, metavar="NAME=NUMBER,..."),
    changes: Texts = common.SETTING,
    resume: bool = option("Continue the run in --out where it stopped."),
    anyway: bool = option(common.ANYWAY_HELP),
    quiet: bool = option("Show no progress."),
) -> None:
    """Search for a controller for SCENARIO (a built-in name or a TOML file).

    Without arguments: c-axis-practical, the C-axis within tolerances, in several motions, with
    realistic sensors and limits.
    """
    from hfc_design.cli.search_progress import Watch, free_folder
    from hfc_design.core.lock import exclusive
    from hfc_design.runs import run

    options = {
        "run.seed": seed,
        "search.population": population,
        "search.generations": generations,
        "search.preset": preset,
        "run.precision": precision,
        "run.polish": polish,
        "run.extend": 1 if extend is False else None,
    }
    settings = {key: x for key, x in options.items() if x is not None}
    by_hand = None
    if not resume:
        if anyway:
            raise refusal("--anyway needs --resume")
        task = _scenario(scenario or DEFAULT, pareto, settings, changes)
        if gains is not None:
            by_hand = _by_hand(task, gains)
        folder = out or free_folder(task.name)
    elif out is None or scenario is not None or settings or changes or pareto or gains:
        raise refusal("--resume takes only --out DIR: config.toml has all other settings")
    else:
        folder, task = out, run.opened_run(out)
        _warn(task)
    click.get_current_context().with_resource(exclusive(folder))  # until the report is written
    with nullcontext() if resume else run.begun(folder):
        if not resume:
            task = run.new_run(task, folder, by_hand)
        watch = None if quiet or by_hand is not None else Watch(task)
        result = _searched(task, folder, anyway, watch)
    _show(task, folder, result, watch.summary() if watch else "", quiet)


def _scenario(
    name: str, pareto: str | None, settings: dict[str, Any], changes: Texts
) -> "Scenario":
    """Return the scenario with the changes of options; UserError: options contradict each other."""
    from hfc_design.files.named_scenario import load_scenario
    from hfc_design.runs.problem import check_memory

    changes = (*common.choosing("plant", "fitness", "controller"), *changes)
    if pareto is not None:
        settings = trading(name, pareto, settings, changes)
    loaded = load_scenario(name, [*(f"{key}={x}" for key, x in settings.items()), *changes])
    known = common.named_part("strategy") or loaded.search.preset
    if known != loaded.search.preset:  # the user may think that the loaded one searches
        raise refusal(
            f"--strategy: loads {known}, but search.preset is {loaded.search.preset}; "
            f"add --preset {known}"
        )
    _warn(loaded)  # before the drive is linearised, which a wrong value may prevent
    check_memory(loaded)
    return loaded


def _by_hand(scenario: "Scenario", gains: str) -> "Design":
    from hfc_design.calls.searching import with_gains
    from hfc_design.core.overrides import overridden

    numbers = overridden({}, gains.split(","), "gains")
    return with_gains(scenario, scenario.controller.kind, numbers)


def _warn(scenario: "Scenario") -> None:
    """Warn about doubtful values: a search with a wrong unit takes as long as a correct one."""
    from hfc_design.core.records import in_a_line
    from hfc_design.files.plausibility import plausibility_warnings

    for line in plausibility_warnings(scenario):
        click.echo(in_a_line(f"hfc: warning: {line}"), err=True)


def _searched(scenario: "Scenario", folder: Path, anyway: bool, watch: Any) -> "Result":
    """Return the result of a search; ``watch`` shows it; RunError: interrupted, or no design."""
    from hfc_design.core.plugins import resuming
    from hfc_design.core.records import RunError
    from hfc_design.runs import run

    try:
        if watch is None:
            return run.run(scenario, folder, anyway=anyway)
        seen = {"on_generation": watch.generation, "on_polish": watch.polished}
        with watch:
            return run.run(scenario, folder, anyway=anyway, on_lap=watch.lap, **seen)
    except KeyboardInterrupt:
        raise RunError(f"interrupted; {resuming(folder)}") from None
    except RunError as error:
        raise RunError(f"{error.message} (run folder {folder})") from None


def _show(scenario: "Scenario", folder: Path, result: "Result", summary: str, quiet: bool) -> None:
    """Write the report, and print the results."""
    from hfc_design.cli.scoring import again_told, settling_told, show_usable
    from hfc_design.core.console import busy, say, show
    from hfc_design.report.page import write_page
    from hfc_design.report.parts import baselines
    from hfc_design.runs.polishing import polish_told
    from hfc_design.runs.run import kept_use
    from hfc_design.simulation.evaluating import score_table

    near = _near_the_best(scenario, result, folder)
    with nullcontext() if quiet else busy("the report, on unseen machines"):
        rivals = write_page(scenario, result, folder)
    use = kept_use(folder)
    show_usable(use)
    if line := settling_told(use, scenario.constraints):
        click.echo(line)
    names = baselines(scenario)
    rows = {"this design": result.evaluation} | {names[k].short: x for k, x in rivals.items()}
    show(score_table(scenario, rows))
    say(summary)
    if line := polish_told(result.design):
        click.echo(line)
    if result.front is not None:
        show_front(result.front)
    again = again_told(use, scenario) if result.search is not None else ""
    if near:
        click.echo(near)
    if again:
        say(again)
    click.echo(f"run folder {folder}\nreport     {folder / 'report.html'}")


def _near_the_best(scenario: "Scenario", result: "Result", folder: Path) -> str:
    """Return a line that compares the design with the best attainable control of a C-axis, or "".

    For several motions, which take longer, the line names the command ``hfc attainable``.
    """
    from hfc_design.attainable.attainable import check
    from hfc_design.core.records import RunError, UserError
    from hfc_design.runs.attained import attained_told, keep_attained

    try:
        check(scenario)
        if scenario.motions:
            command = f"hfc attainable {shlex.quote(folder.as_posix())}"
            return f"How close is it to the best possible controller? {command}"
        return attained_told(keep_attained(scenario, result.design, folder))
    except (UserError, RunError):  # no bound exists, or none was found
        return ""
