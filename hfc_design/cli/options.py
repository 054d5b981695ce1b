"""Options that commands share: changes, the scenario of a design, output files, plug-ins."""

import os
import shlex
from collections.abc import Iterable, Iterator, Sequence
from os.path import exists, isdir, isfile, realpath
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from hfc_design.cli.binding import Output, Texts, Together, argument, option
from hfc_design.cli.names import CONTROLLER, DESIGN, FITNESS, PLANT, SCENARIO, STRATEGY
from hfc_design.cli.usage import refusal

if TYPE_CHECKING:
    from hfc_design.files.design import Design
    from hfc_design.files.scenario import Scenario


def free(path: Path, option: str = "--out", folder: bool = False) -> Path:
    """Check and return the path of an output file, or of a ``folder``, whose parents are created.

    Raises:
        UserError: the path exists and --force is not given; it is a device, a pipe, or the path of
            another option too; or it is a file in a folder that does not exist, which would
            otherwise be found only after the computation.
    """
    where, meta = f"{option} {path}", click.get_current_context().meta
    if exists(path) and not (isfile(path) or isdir(path)):  # a file would replace it
        raise refusal(f"{where}: must be a file or a folder; name another path")
    if exists(path) and not meta["hfc.force"]:
        raise refusal(f"{where}: already exists; name another path, or add --force")
    if not folder and not isdir(path.absolute().parent):
        raise refusal(f"{where}: no such folder: {path.parent}")
    other = meta.setdefault("hfc.named", {}).setdefault(realpath(path), option)
    if other != option:
        raise refusal(f"{where}: must differ from {other}")
    return path


def output(text: str, folder: bool = False, **others: Any) -> Any:
    """Return an option for an output path, which ``free`` checks.

    The suffix of the path of ``--plot`` is also checked, before anything is simulated.
    """

    def checked(_: click.Context, option: click.Parameter, path: Path | None) -> Path | None:
        if path and option.opts[0] == "--plot":
            from hfc_design.plotting.files import kind_of

            kind_of(path)
        return path and free(path, option.opts[0], folder)

    return option(text, callback=checked, **others)._replace(make=Output)


def _bounded(_: click.Context, option: click.Parameter, value: str | None) -> None:
    """Limit the memory of this process and of its workers."""
    if value is not None:
        from hfc_design.simulation import memory

        memory.size(value)
        os.environ[memory.VARIABLE] = value


SET_HELP = "Change a value of the scenario by its dotted key, as in simulation.duration_s=5."
CHANGE_HELP = "Change a value of the design by its dotted key, as in controller.integral_gain=8."
SCENARIO_HELP = "Scenario to run on [default: the one it was made for]."
SCENARIOS_HELP = SCENARIO_HELP.replace(" [", "; can be given several times [")
#: Option of every command on a scenario, and of every command on a design.
SETTING = option(SET_HELP, "--set", metavar="KEY=VALUE")
CHANGING = option(CHANGE_HELP, "--change", metavar="KEY=VALUE")
MEMORY_HELP = "Limit of memory, as in 8GB [default: 80 % of the free memory]."
#: Option of commands with large memory needs; an environment variable passes it to workers.
MEMORY = option(MEMORY_HELP, callback=_bounded)
LIMITED = MEMORY.of("_memory", str)
#: Help of an option of the commands that search.
ANYWAY_HELP = "Resume even if version, files or plug-ins have changed; the result may differ."
USE_HELP = "Load a plug-in that files name, as module:OBJECT; can be given several times."
CHOICES = {
    "plant": "Plant of the scenario: NAMES, or your own as module:OBJECT.",
    "fitness": "Fitness of the scenario: NAMES, or your own as module:OBJECT.",
    "controller": "Kind of the controller: NAMES, or your own law or kind as module:OBJECT.",
    "strategy": "Load your own search strategy, as module:OBJECT; search.preset names it.",
}
NAMED = {"plant": PLANT, "fitness": FITNESS, "controller": CONTROLLER, "strategy": STRATEGY}
KNOWN = CHOICES | {
    "plant": "Load your own plant, as module:OBJECT.",
    "fitness": "Load your own fitness, as module:OBJECT.",
    "controller": "Load your own control law or kind of controller, as module:OBJECT.",
}


def plugins(helps: dict[str, str]) -> Iterator[click.Parameter]:
    """Yield the options in ``helps`` (name -> help) and --use, which load the parts they name."""
    for key, text in helps.items():
        settings: dict[str, Any] = {"expose_value": False, "callback": _known}
        yield option(text, kind=NAMED[key], **settings).of(key, str)
    # Eager: the others may name what --use makes known.
    use: dict[str, Any] = {"is_eager": True, "metavar": "MODULE:OBJECT", "callback": _known}
    yield option(USE_HELP, **use).of("_use", Texts)


def _known(ctx: click.Context, option: click.Parameter, value: str | Texts | None) -> None:
    """Load the part that an option names, and store its name."""
    if not value:
        return
    import hfc_design.files.scenario  # noqa: F401 - it makes all groups of plug-ins known
    from hfc_design.core.plugins import GROUPS, use

    if not isinstance(value, str):
        for text in value:
            use(text)
        return
    key = str(option.name)
    name = value if value in GROUPS[key].built_in else GROUPS[key].resolve(value).name
    ctx.meta[f"hfc.{key}"] = name


#: Options that only load parts which files name; the same, where --plant also selects the plant.
KNOWING = tuple(plugins(KNOWN))
ON_A_PLANT = LIMITED, *plugins(KNOWN | {"plant": CHOICES["plant"]})
#: Options that select the parts of a scenario.
CHOOSING = LIMITED, *plugins(CHOICES)


def named_part(key: str) -> str | None:
    """Return the plant, fitness, controller or strategy named on the command line; None: none."""
    name: str | None = click.get_current_context().meta.get(f"hfc.{key}")
    return name


def choosing(*keys: str) -> Texts:
    """Return the changes of a scenario that select the parts named on the command line."""
    named = {key: name for key in keys if (name := named_part(key))}
    # The plant's parameters stay; a fitness or controller of another kind has other settings.
    return tuple(
        f"plant.name='{name}'" if key == "plant" else f"{key}={{kind='{name}'}}"
        for key, name in named.items()
    )


class Loops(NamedTuple):
    """A design and the scenarios to run it on."""

    design: "Design"
    scenarios: list["Scenario"]
    elsewhere: bool  # whether --scenario names them

    @property
    def only(self) -> "Scenario":
        """The scenario of a command with a single one."""
        return self.scenarios[0]


def loops_of(name: str, others: Texts, scenarios: Texts, changes: Texts, *parts: str) -> Loops:
    """Return a design with changes, and scenarios with changes and the ``parts`` of options.

    Default scenario: the one that the design was made for.
    """
    from hfc_design.files.loop_setup import load_design

    design = load_design(name, others)
    every = (*choosing(*parts), *changes)
    return Loops(design, scenarios_of(design, name, scenarios, every), bool(scenarios))


def scenarios_of(design: "Design", name: str, scenarios: Texts, changes: Texts) -> list["Scenario"]:
    """Return scenarios with changes; default: the one that the design ``name`` was made for."""
    from hfc_design.files.loop_setup import own_scenario
    from hfc_design.files.named_scenario import load_scenario

    named = [load_scenario(one, changes) for one in scenarios]
    return named or [own_scenario(design, name, changes)]


def again(words: Sequence[str], options: dict[str, Texts], designs: Iterable["Design"]) -> str:
    """Return the command line that repeats a command, with --use for plug-ins of the designs."""
    from hfc_design.core.plugins import uses
    from hfc_design.core.records import harmless

    pairs = [part for option, values in options.items() for x in values for part in (option, x)]
    parts = dict.fromkeys(uses(one.provenance.get("plugins")) for one in designs)
    return harmless(shlex.join([*words, *pairs])) + "".join(parts)


def _on_one(
    name: str = argument(DESIGN, metavar="DESIGN"),
    others: Texts = CHANGING,
    scenario: str | None = option(SCENARIO_HELP, kind=SCENARIO),
    changes: Texts = SETTING,
) -> Loops:
    return loops_of(name, others, (scenario,) if scenario else (), changes, "plant", "fitness")


def _on_several(
    name: str = argument(DESIGN, metavar="DESIGN"),
    others: Texts = CHANGING,
    scenario: Texts = option(SCENARIOS_HELP, kind=SCENARIO),
    changes: Texts = SETTING,
) -> Loops:
    return loops_of(name, others, scenario, changes, "plant", "fitness")


#: Parameters of a command on a design and a scenario, and of one on several.
ON_SCENARIO: Any = Together(_on_one)
ON_SCENARIOS: Any = Together(_on_several)
