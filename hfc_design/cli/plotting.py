"""The command that draws: a picture of a design, or several designs or searches in one figure."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem

from hfc_design.cli import options as common
from hfc_design.cli.binding import Texts, argument, command, option
from hfc_design.cli.names import SCENARIO, Named, completions
from hfc_design.cli.usage import refusal

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Names of the pictures -> their descriptions.
WHATS = {
    "surface": "the output of a fuzzy unit, as colours",
    "surface-3d": "the same in 3-D",
    "terms": "membership of the terms",
    "tables": "rule table",
    "tree": "the inputs of each unit",
    "motion": "of several designs in one motion",
    "convergence": "of the searches of runs",
}
#: Pictures of several designs or folders, and the options that belong to them.
CONVERGENCE, MOTION = "convergence", "motion"
OPTIONS = {CONVERGENCE: (), MOTION: ("scenario", "changes", "motion")}
#: Parameters of pictures of a single design.
OF_ONE = ("others", "unit", "axis")


class NameOrWhat(Named):
    """A design, or after the first one also the name of a picture."""

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Return designs and files, and after the first name also pictures."""
        items = super().shell_complete(ctx, param, incomplete)
        return items + completions(WHATS, incomplete) if ctx.params.get("what") else items


NAME_OR_WHAT = NameOrWhat("design")
WIDTH_HELP = "Draw for a column of this width, as in 88mm, 3.5in, 252pt."


@command("Draw a DESIGN, or several in one figure.", last=common.KNOWING)
def plot(
    names: Texts = argument(NAME_OR_WHAT, metavar="DESIGN|FOLDER...", nargs=-1),
    what: str = argument(metavar="WHAT"),
    others: Texts = common.CHANGING,
    unit: str | None = option("Unit of a hierarchy to draw, as unit-1 [default: the root]."),
    axis: str = option("Axis to draw, of a controller with several.", default=""),
    scenario: str | None = option(
        "For motion: scenario [default: that of the first design].", kind=SCENARIO
    ),
    changes: Texts = common.SETTING,
    motion: str | None = option("Motion, of a scenario with several [default: the first]."),
    width: str | None = option(WIDTH_HELP),
    out: Path = common.output("Picture to write (png, svg or pdf).", required=True),
    _memory: str | None = common.MEMORY,
) -> None:
    """Draw a DESIGN: WHAT is surface, surface-3d, terms, tables or tree.

    The output of a fuzzy unit over its two inputs as colours or in 3-D, the membership of its
    terms, its rule table as colours with the names of the terms, or the inputs of each unit. Of a
    controller that wraps others, the wrapped ones are drawn.

    Several in one figure: WHAT is motion, of designs in one scenario, on the machine of the first:
    positions, errors and commands, and the deviation from a path; or convergence, of run folders
    and of folders of runs: the best so far in each generation, of many runs the median of each
    group over a band between its quartiles.
    """
    from hfc_design.files.loop_setup import load_design
    from hfc_design.plotting.column import in_column
    from hfc_design.plotting.files import save
    from hfc_design.report.designs import picture
    from hfc_design.report.paper import INCH, column

    narrow = None if width is None else column(width) / INCH
    _check(names, what)
    if what == CONVERGENCE:
        from hfc_design.batch.findings import convergence

        figure = convergence([Path(name) for name in names])
    elif what == MOTION:
        figure = _motions(names, scenario, changes, motion)
    else:
        figure = picture(load_design(names[0], others), what, unit, axis)
    if narrow is not None:
        in_column(figure, narrow)
    save(figure, out)
    click.echo(out)


def _check(names: Texts, what: str) -> None:
    """Check that options and number of names fit the picture; UserError: they do not."""
    if not names:
        missing = f"{what}: which design?" if what in WHATS else f"{what}: WHAT of it?"
        raise refusal(f"{missing} as in hfc plot DESIGN surface; WHAT is {', '.join(WHATS)}")
    context = click.get_current_context()
    flags = {option.name: option.opts[0] for option in context.command.params}
    allowed = OPTIONS.get(what, OF_ONE)
    for key in {*OF_ONE, *OPTIONS[MOTION]} - {*allowed}:
        if context.params[key]:
            raise refusal(f"{flags[key]}: does not apply to {what}")
    if what == MOTION and len(names) == 1:
        raise refusal(
            f"{MOTION} draws several designs; for one use hfc simulate "
            f"{shlex.quote(names[0])} --plot"
        )
    if what not in OPTIONS and len(names) > 1:
        raise refusal(f"{what}: draws one design; {CONVERGENCE} and {MOTION} draw several")


def _motions(names: Texts, scenario: str | None, changes: Texts, motion: str | None) -> "Figure":
    from hfc_design.files.design_set import differences, labelled, own_machine, shared_machine
    from hfc_design.report.overlaid import motions
    from hfc_design.simulation.evaluating import evaluate, notes

    designs = labelled(names)
    first = next(iter(designs.values()))
    (where,) = common.scenarios_of(first, names[0], (scenario,) if scenario else (), changes)
    shared = shared_machine(designs, where)
    if note := own_machine(next(iter(designs)), where, shared):
        click.echo(note, err=True)
    for name, design in designs.items():
        for note in differences(design, where, shared):
            click.echo(f"{name}: {note}", err=True)
    if motion is not None or shared.motions:
        shared = shared.motion(motion)
    evaluations = {name: evaluate(design, shared) for name, design in designs.items()}
    for note in notes(shared, evaluations):
        click.echo(note, err=True)
    return motions(evaluations, shared.name)
