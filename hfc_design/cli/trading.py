"""Trade-offs: the options of ``hfc design --pareto``, and ``hfc pick``."""

from os.path import isdir
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hfc_design.cli import options as common
from hfc_design.cli.binding import PATH, Texts, argument, command, option
from hfc_design.cli.usage import refusal

if TYPE_CHECKING:
    from hfc_design.runs.front import Front

#: Default strategy of --pareto.
PRESET = "nsga-ii"
#: Strategy that searches the first design of a front; number of generations added for the front;
#: share of the generations for the first design, if ``--generations`` sets their total.
LEADER, SPREAD, LED = "cma", 120, 0.75


def trading(scenario: str, names: str, settings: dict[str, Any], changes: Texts) -> dict[str, Any]:
    """Return the changes of a scenario for ``--pareto names``, with the ``settings`` of options.

    Population and generations in a scenario are meant for its own strategy. Another strategy has
    its own defaults, unless the user sets them. If the strategy of the scenario is ``cma``, it
    first searches the design from which the front begins.

    Raises:
        UserError: the chosen strategy or the objectives are not possible.
    """
    from hfc_design.files.named_scenario import load_scenario
    from hfc_design.objectives.traded import check_names
    from hfc_design.search.loop import STRATEGIES

    each = [name.strip() for name in names.split(",") if name.strip()]
    try:
        check_names(each)
    except ValueError as error:
        about = str(error).partition(":")[0]  # leaves room for all available names
        head = "--pareto" if about in each else f"--pareto {names}:"
        raise refusal(f"{head} {error}") from None
    search = load_scenario(scenario, changes).search
    set_here = {change.partition("=")[0] for change in changes}
    trade = [name for name in STRATEGIES.names() if STRATEGIES.get(name).trades is not None]
    preset = search.preset if search.preset in trade else PRESET
    preset = settings.get("search.preset", preset)
    if "search.preset" in set_here:
        preset = search.preset
    if preset in STRATEGIES.names() and preset not in trade:
        raise refusal(
            f"--pareto {names}: search strategy {preset} finds a single design; for a "
            f"front use {', '.join(trade)}"
        )
    if preset != search.preset:
        fields = STRATEGIES.get(preset).settings.model_fields
        default = {f"search.{key}": fields[key].default for key in ("population", "generations")}
        if (search.preset, preset) == (LEADER, PRESET):
            whole = settings.get("search.generations")
            if "search.generations" in set_here:
                whole = search.generations
            lead = search.generations if whole is None else round(LED * whole)
            default |= {"search.lead": lead, "search.generations": lead + SPREAD}
        settings = {key: x for key, x in default.items() if key not in set_here} | settings
    return settings | {"search.preset": preset, "search.objectives": str(each)}


def show_front(front: "Front") -> None:
    """Print some points of a front on stdout."""
    from hfc_design.core.console import say, show
    from hfc_design.report.trade_off import EMPTY, front_table

    if len(front.merit):
        show(front_table(front))
    else:
        say(EMPTY)


NEAREST_HELP = "The point closest to these values, as in chatter='2 V',tracking='20 urad'."


@command("Write the design of a point of a front, or the best of a batch.", last=common.KNOWING)
def pick(
    run: Path = argument(PATH),
    point: int | None = option("The point of this number in front.csv."),
    nearest: str | None = option(NEAREST_HELP, metavar="NAME=NUMBER,..."),
    knee: bool = option("The point where the front bends most."),
    out: Path | None = common.output("Design file to write."),
) -> None:
    """Write the design of a point of the front of RUN (of hfc design --pareto) to a file.

    Without a choice it shows the front. From the folder of a batch, or of many runs, it takes the
    best usable design: by the share of machines that pass, then by the merit.
    """
    from hfc_design.batch.results import best_usable, is_run
    from hfc_design.cli.scoring import show_usable
    from hfc_design.core.checkpoint import write_whole
    from hfc_design.core.console import show
    from hfc_design.core.overrides import set_keys
    from hfc_design.core.texts import content
    from hfc_design.formats import FORMATS
    from hfc_design.runs.front import chosen
    from hfc_design.runs.run import DESIGN, finished_run, front_needed, picked
    from hfc_design.simulation.evaluating import score_table

    if isdir(run) and not is_run(run):
        if point is not None or nearest is not None or knee:
            raise refusal(f"{run}: must be a run with a front; name one of its runs")
        best = best_usable(run)
        click.echo(f"{best.title}: {best.answer}\nrun folder {run / best.path}")
        if out is not None:
            write_whole(out, content(run / best.path / DESIGN))
            click.echo(f"design {out}")
        return
    choices = (point is not None) + (nearest is not None) + knee
    if choices > 1:
        raise refusal("hfc pick takes one of --point, --nearest and --knee")
    if not choices and out is not None:
        raise refusal(f"--out {out}: needs --point, --nearest or --knee")
    scenario, result = finished_run(run)
    front = front_needed(run, result)
    if not choices:
        show_front(front)
        return
    if out is None:
        raise refusal("hfc pick needs --out FILE for the design")
    wanted = None if nearest is None else set_keys(nearest.split(","), "nearest")
    point = chosen(front, scenario, point, wanted)
    design, evaluation, numbers = picked(scenario, result, point)
    FORMATS["json"].write(design, out)
    if numbers is not None:
        show_usable(numbers)
    show(score_table(scenario, {f"point {point + 1}": evaluation}))
    click.echo(f"design {out}")
