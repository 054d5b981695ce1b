"""Options that commands share: changes, the scenario of a design, a user's own parts."""

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any

import click

Command = Callable[..., None]
Texts = tuple[str, ...]
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
    "controller": "Kind of the controller: a name, or an own law or kind as module:OBJECT.",
    "strategy": "Make an own search strategy known, as module:OBJECT; search.preset names it.",
}
KNOWN = CHOICES | {
    "plant": "Make an own plant known, as module:OBJECT.",
    "fitness": "Make an own fitness known, as module:OBJECT.",
    "controller": "Make an own control law or kind of controller known, as module:OBJECT.",
}


def with_plugins(helps: dict[str, str] = KNOWN) -> Callable[[Command], Command]:
    """Adds --use and the options with these helps; ``chosen`` makes known what they name."""

    def decorated(command: Command) -> Command:
        found = click.option("--use", multiple=True, metavar="MODULE:OBJECT", help=USE)(command)
        for key, text in reversed(helps.items()):
            found = click.option(f"--{key}", help=text)(found)
        return found

    return decorated


def knowing_plugins(command: Command) -> Command:
    """A command with these options, which make known what files name."""

    @with_plugins()
    @wraps(command)
    def wrapped(**given: Any) -> None:
        chosen(given)
        command(**given)

    return wrapped


def on_scenario(command: Command) -> Command:
    """A command ``with_plugins`` on a DESIGN and a scenario: it gets both, and its other options.

    The scenario is --scenario or the design's own, with every --set.
    """

    @click.argument("name", metavar="DESIGN")
    @changing_design
    @click.option("--scenario", help=SCENARIO_HELP)
    @setting
    @wraps(command)
    def wrapped(
        name: str, others: Texts, scenario: str | None, changes: Texts, **given: Any
    ) -> None:
        from hfc_design.files.pairing import load_design, own_scenario
        from hfc_design.files.scenario import load_scenario

        # The controller is the design's, whatever a search of the scenario would vary.
        plugins = [change for key, change in chosen(given).items() if key != "controller"]
        changes = (*plugins, *changes)
        design = load_design(name, others)
        if scenario is None:
            command(design, own_scenario(design, name, changes), **given)
        else:
            command(design, load_scenario(scenario, changes), **given)

    return wrapped


def chosen(given: dict[str, Any]) -> dict[str, str]:
    """Take the options of ``with_plugins`` out of what is given and make known what they name.

    Returns the changes of a scenario that choose it, by the option.

    Raises:
        UserError: something cannot be imported or used.
    """
    used: Texts = given.pop("use")
    texts: dict[str, str] = {key: text for key in CHOICES if (text := given.pop(key))}
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
