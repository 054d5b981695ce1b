"""Options that commands share: changes, the scenario of a design, a user's own parts."""

import os
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from importlib import metadata
from os.path import exists, isdir, isfile, realpath
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING, Any, TypeVar

import click
from click.shell_completion import CompletionItem

Decorated = TypeVar("Decorated", bound=Callable[..., Any] | click.Command)


class Named(click.types.StringParamType):
    """A name of one thing: built in, of an installed package, or what else its option takes.

    The help and the completion of a shell have the names: those of the reference that comes with
    the package, and of installed packages. Nothing here starts JAX.
    """

    name = "name"

    def __init__(self, kind: str, entry_points: str = "", files: bool = False):
        """``kind`` is that of the entries of the reference; with ``files`` a path will do too."""
        self.kind, self.entry_points, self.files = kind, entry_points, files

    def told(self) -> dict[str, str]:
        """Every name, with what it is."""
        from hfc_design.reference.entries import things

        found = {one.name: one.meaning for one in things(self.kind)}
        if self.entry_points:
            installed = metadata.entry_points(group=self.entry_points).names
            found |= dict.fromkeys(sorted(installed), "of an installed package")
        return found

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """The names that begin like this, and files."""
        items = [
            CompletionItem(name, help=shorten(meaning, 72, placeholder=" ..."))
            for name, meaning in self.told().items()
            if name.startswith(incomplete)
        ]
        # In front: Bash forgets what came before, and takes files where no name begins so.
        return [CompletionItem(incomplete, type="file"), *items] if self.files else items


SCENARIO = Named("scenario", files=True)
DESIGN = Named("design", files=True)
PLANT = Named("plant", "hfc_design.plants")
FITNESS = Named("objective", "hfc_design.fitness")
CONTROLLER = Named("controller", "hfc_design.controllers")
STRATEGY = Named("strategy", "hfc_design.strategies")
FORMAT = Named("format")
ALL = {one.kind: one for one in (SCENARIO, DESIGN, PLANT, FITNESS, CONTROLLER, STRATEGY)}


class NamedOfKind(click.types.StringParamType):
    """A name of the kind that the argument before it says."""

    name = "name"

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """The names of that kind."""
        kind = str(ctx.params.get("kind"))
        return ALL.get(kind, Named(kind)).shell_complete(ctx, param, incomplete)


class OrElse(click.Choice):  # type: ignore[type-arg]
    """One of some names; each of ``others`` stands for one of them too, as plants for plant."""

    def __init__(self, choices: Iterable[str], others: Mapping[str, str]):
        """Of both what the help has and what else is understood."""
        super().__init__([*choices])
        self.others = others

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The name that is meant."""
        return super().convert(self.others.get(value, value), param, ctx)


class NamedOption(click.Option):
    """An option whose help has the names that there are in the place of NAMES."""

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """Option and help, for a table."""
        found = super().get_help_record(ctx)
        if found is None or not isinstance(self.type, Named):
            return found
        return found[0], found[1].replace("NAMES", ", ".join(self.type.told()))


def named(*names: str, kind: Named, **others: Any) -> Callable[[Decorated], Decorated]:
    """An option that takes a name; NAMES in its help are those that there are."""
    return click.option(*names, cls=NamedOption, type=kind, metavar="NAME", **others)


def _bounded(_: click.Context, option: click.Parameter, told: str | None) -> None:
    """Bound the memory of this process and of its workers."""
    if told is not None:
        from hfc_design.simulation import memory

        memory.size(told)
        os.environ[memory.VARIABLE] = told


Command = Callable[..., None]
Texts = tuple[str, ...]
PATH = click.Path(path_type=Path)


def free(path: Path, option: str = "--out", folder: bool = False) -> Path:
    """Where a command is to write a file, or a ``folder``, which comes with those around it.

    Raises:
        UserError: something is there already, and no --force; or it is a device, a pipe, or what
            another option names too; or a file in a folder that is not there, which would only
            be found once everything has been computed.
    """
    from hfc_design.core.records import UserError

    told, meta = f"{option} {path}", click.get_current_context().meta
    if exists(path) and not (isfile(path) or isdir(path)):  # a rename would take its place
        raise UserError(f"{told}: is neither a file nor a folder; name another path")
    if exists(path) and not meta["hfc.force"]:
        raise UserError(f"{told}: exists already; name another path, or add --force")
    if not folder and not isdir(path.absolute().parent):
        raise UserError(f"{told}: there is no folder {path.parent}")
    other = meta.setdefault("hfc.named", {}).setdefault(realpath(path), option)
    if other != option:
        raise UserError(f"{told}: {other} names it too")
    return path


def output(*names: str, folder: bool = False, **others: Any) -> Callable[[Command], Command]:
    """An option that names what to write, which is ``free``; of a command that has ``force``.

    A ``--plot`` has to be of a kind that can be drawn, before anything is simulated.
    """

    def checked(_: click.Context, option: click.Parameter, path: Path | None) -> Path | None:
        if path and option.opts[0] == "--plot":
            from hfc_design.pictures.files import kind_of

            kind_of(path)
        return path and free(path, option.opts[0], folder)

    return click.option(*names, type=PATH, callback=checked, **others)


force = click.option(
    "--force",
    is_flag=True,
    is_eager=True,  # the paths ask for it
    expose_value=False,
    callback=lambda ctx, _, told: ctx.meta.update({"hfc.force": told}),
    help="Overwrite what is there.",
)
SET_HELP = "Change a value of the scenario by its dotted key, as in simulation.duration_s=5."
CHANGE_HELP = "Change a value of the design by its dotted key, as in controller.integral_gain=8."
SCENARIO_HELP = "Scenario to run it on [default: the one it was made for]."
SCENARIO_HELPS = SCENARIO_HELP, SCENARIO_HELP.replace(" [", "; can be given several times [")
#: Of every command on a scenario, and of every one on a design.
setting = click.option("--set", "changes", multiple=True, metavar="KEY=VALUE", help=SET_HELP)
changing = click.option("--change", "others", multiple=True, metavar="KEY=VALUE", help=CHANGE_HELP)
as_json = click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
MEMORY_HELP = "Memory that it may hold, as in 8GB [default: 80 % of what is free]."
#: Of every command that may need much of it; a variable, so that workers have it too.
memory = click.option("--memory", callback=_bounded, expose_value=False, help=MEMORY_HELP)
#: Of the commands that search.
ANYWAY_HELP = "Resume what another version, file or own part began; it may end otherwise."
USE = "Make any own part known that files name; can be given several times."
CHOICES = {
    "plant": "Plant of the scenario: NAMES, or an own one as module:OBJECT.",
    "fitness": "Fitness of the scenario: NAMES, or an own one as module:OBJECT.",
    "controller": "Kind of the controller: NAMES, or an own law or kind as module:OBJECT.",
    "strategy": "Make an own search strategy known, as module:OBJECT; search.preset names it.",
}
NAMED = {"plant": PLANT, "fitness": FITNESS, "controller": CONTROLLER, "strategy": STRATEGY}
#: Those that name a part of a scenario; the search of a file keeps its own strategy.
CHOSEN = "plant", "fitness", "controller"
KNOWN = CHOICES | {
    "plant": "Make an own plant known, as module:OBJECT.",
    "fitness": "Make an own fitness known, as module:OBJECT.",
    "controller": "Make an own control law or kind of controller known, as module:OBJECT.",
}


def with_plugins(helps: dict[str, str]) -> Callable[[Command], Command]:
    """Adds --use and the options with these helps, which make known what they name.

    Of each of ``CHOSEN`` with its help in ``CHOICES`` a command gets the change of a scenario that
    chooses it.
    """

    def decorated(command: Command) -> Command:
        # Eager: the others may name what --use makes known.
        use: dict[str, Any] = {"multiple": True, "is_eager": True, "metavar": "MODULE:OBJECT"}
        found = click.option("--use", callback=_known, expose_value=False, help=USE, **use)(command)
        for key, text in reversed(helps.items()):
            told = key in CHOSEN and text == CHOICES[key]
            own: dict[str, Any] = {"kind": NAMED[key], "callback": _known, "help": text}
            found = named(f"--{key}", expose_value=told, **own)(found)
        return found

    return decorated


#: The options of a command that only has to know what files name.
knowing_plugins = with_plugins(KNOWN)
#: The same of a command that puts designs on a plant.
on_a_plant = with_plugins(KNOWN | {"plant": CHOICES["plant"]})


def _known(ctx: click.Context, option: click.Parameter, told: str | Texts | None) -> str:
    """Make known what an option names; the change of a scenario that chooses it, "" for none."""
    if not told:
        return ""
    import hfc_design.files.scenario  # noqa: F401 - every group of plug-ins is one of a scenario
    from hfc_design.core.plugins import GROUPS, use

    if not isinstance(told, str):
        for text in told:
            use(text)
        return ""
    key = str(option.name)
    name = told if told in GROUPS[key].built_in else GROUPS[key].resolve(told).name
    ctx.meta[f"hfc.{key}"] = name
    # The plant's parameters stay; a fitness or controller of another kind has other settings.
    return f"plant.name='{name}'" if key == "plant" else f"{key}={{kind='{name}'}}"


def _on(several: bool) -> Callable[[Command], Command]:
    """Makes a command ``with_plugins`` one on a DESIGN and a scenario, or on ``several``.

    It gets both, and its other options. A scenario is a --scenario or the design's own, with every
    --set.
    """

    def decorated(command: Command) -> Command:
        @click.argument("name", metavar="DESIGN", type=DESIGN)
        @changing
        @named("--scenario", kind=SCENARIO, multiple=several, help=SCENARIO_HELPS[several])
        @setting
        @wraps(command)
        def wrapped(name: str, others: Texts, scenario: Any, changes: Texts, **given: Any) -> None:
            from hfc_design.files.named_scenario import load_scenario
            from hfc_design.files.pairing import load_design, own_scenario

            # The controller is the design's, whatever a search of the scenario would vary.
            plant, fitness, _ = (given.pop(key) for key in CHOSEN)
            changes = (*filter(None, (plant, fitness)), *changes)
            design, asked = load_design(name, others), [scenario] if scenario else []
            found = [load_scenario(one, changes) for one in (scenario if several else asked)]
            found = found or [own_scenario(design, name, changes)]
            command(design, found if several else found[0], **given)

        return wrapped

    return decorated


#: Of a command on scenarios, and of one on a scenario.
on_scenarios, on_scenario = _on(several=True), _on(several=False)


if TYPE_CHECKING:
    from hfc_design.report.paper import Paper

#: Those of ``report.paper``, which takes long to import.
KINDS = "pdf", "svg", "pgf"
FIGURES_HELP = "Every figure of the page as a file too, for the column of a paper."
WIDTH_HELP = "Of these figures, as in 88mm, 3.5in, 252pt [default: 3.5in]."
#: Of a place, where its folders lie and what their names begin with: what is wanted there.
Papers = Callable[[Path, str], "Paper | None"]


def for_a_paper(command: Command) -> Command:
    """A command that has ``force``: it gets ``papers``, which tells what is wanted of a page."""

    @click.option("--figures", type=click.Choice(KINDS), help=FIGURES_HELP)
    @click.option("--width", callback=millimetres_of, metavar="WIDTH", help=WIDTH_HELP)
    @click.option("--latex", is_flag=True, help="Every table of the page in LaTeX too.")
    @wraps(command)
    def wrapped(figures: str | None, width: float | None, latex: bool, **given: Any) -> None:
        from hfc_design.core.records import UserError

        if width is not None and figures is None:
            raise UserError(f"--width: is that of figures; add --figures {'|'.join(KINDS)}")

        def papers(folder: Path, stem: str = "") -> "Paper | None":
            if figures is None and not latex:
                return None
            from hfc_design.report.paper import COLUMN, Paper

            drawn = free(folder / f"{stem}figures", "--figures", folder=True) if figures else None
            tables = free(folder / f"{stem}latex", "--latex", folder=True) if latex else None
            return Paper(figures or "", COLUMN if width is None else width, drawn, tables)

        command(papers=papers, **given)

    return wrapped


def millimetres_of(_: click.Context, option: click.Parameter, told: str | None) -> float | None:
    """A width in millimetres."""
    if told is None:
        return None
    from hfc_design.report.paper import millimetres

    try:
        return millimetres(told)
    except ValueError as error:
        raise click.BadParameter(str(error)) from None
