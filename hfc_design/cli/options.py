"""Options that commands share: changes, the scenario of a design, a user's own parts."""

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from hfc_design.files.design import Design
    from hfc_design.files.scenario import Scenario

Command = Callable[..., None]
Texts = tuple[str, ...]
#: Option of a plug-in -> a change of the scenario that chooses it.
Chosen = dict[str, str]
Load = Callable[[Chosen], "tuple[Design, Scenario]"]
PATH = click.Path(path_type=Path)
SET_HELP = "Change a value of the scenario by its dotted key, as in simulation.duration_s=5."
CHANGE_HELP = "Change a value of the design by its dotted key, as in controller.integral_gain=8."
SCENARIO_HELP = "Scenario to run it on [default: the one it was made for]."
#: Of every command on a scenario, and of every one on a design.
setting = click.option("--set", "changes", multiple=True, metavar="KEY=VALUE", help=SET_HELP)
changing_design = click.option(
    "--change", "others", multiple=True, metavar="KEY=VALUE", help=CHANGE_HELP
)
as_json = click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
USE = "Make any own part known that files name; can be given several times."
CHOICES = {
    "plant": "Plant of the scenario: a name, or an own one as module:OBJECT.",
    "fitness": "Fitness of the scenario: a name, or an own one as module:OBJECT.",
    "controller": "Kind of the controller: a name, or an own law as module:OBJECT.",
    "strategy": "Make an own search strategy known, as module:OBJECT; search.preset names it.",
}
KNOWN = CHOICES | {
    "plant": "Make an own plant known, as module:OBJECT.",
    "fitness": "Make an own fitness known, as module:OBJECT.",
    "controller": "Make an own controller's law known, as module:OBJECT.",
}


def on_scenario(command: Command) -> Command:
    """A command on a DESIGN and a scenario: ``load`` gives both, of what ``choosing_plugins`` gave.

    The scenario is --scenario or the design's own, with every --set.
    """

    @click.argument("design")
    @changing_design
    @click.option("--scenario", help=SCENARIO_HELP)
    @setting
    @wraps(command)
    def wrapped(
        design: str, others: Texts, scenario: str | None, changes: Texts, **given: object
    ) -> None:
        def load(chosen: Chosen) -> "tuple[Design, Scenario]":
            from hfc_design.files.pairing import load_design, own_scenario
            from hfc_design.files.scenario import load_scenario

            found = load_design(design, others)
            # The controller is the design's, whatever a search of the scenario would vary.
            plugins = [change for key, change in chosen.items() if key != "controller"]
            if scenario is not None:
                return found, load_scenario(scenario, [*plugins, *changes])
            return found, own_scenario(found, design, [*plugins, *changes])

        command(load=load, **given)

    return wrapped


def _plugins(choose: bool) -> Callable[[Command], Command]:
    """Adds --plant, --fitness, --controller, --strategy and --use; what they name is made known.

    To ``choose`` is to give the command the changes of a scenario that choose them, by the option,
    as ``chosen``.
    """
    helps = CHOICES if choose else KNOWN

    def decorated(command: Command) -> Command:
        @click.option("--use", "used", multiple=True, metavar="MODULE:OBJECT", help=USE)
        @wraps(command)
        def wrapped(used: Texts, **given: Any) -> None:
            texts = {key: given.pop(key) for key in helps}
            changes = chosen({key: text for key, text in texts.items() if text}, used)
            command(**given | ({"chosen": changes} if choose else {}))

        for key, text in reversed(helps.items()):
            wrapped = click.option(f"--{key}", help=text)(wrapped)
        return wrapped

    return decorated


choosing_plugins, knowing_plugins = _plugins(choose=True), _plugins(choose=False)


def chosen(texts: dict[str, str], used: Texts) -> Chosen:
    """Make known what each option names, and what is ``used``.

    Raises:
        UserError: something cannot be imported or used.
    """
    if not texts and not used:
        return {}
    import hfc_design.files.scenario  # noqa: F401 - every group of plug-ins is one of a scenario
    from hfc_design.core.plugins import GROUPS, use

    for text in used:
        use(text)
    changes = {}
    for key, text in texts.items():
        group = GROUPS[key]
        name = text if text in group.built_in else group.resolve(text).name
        if key == "strategy":  # the search of a file keeps its own
            continue
        # The plant's parameters stay; a fitness or controller of another kind has other settings.
        changes[key] = f"plant.name='{name}'" if key == "plant" else f"{key}={{kind='{name}'}}"
    return changes
