"""The options of a command that bring in a user's own parts."""

from collections.abc import Callable
from functools import wraps
from typing import Any

import click

Command = Callable[..., None]
USE = "Make any own part known that files name; can be given several times."
CHOICES = {
    "plant": "Plant of the scenario: a name, or an own one as module:OBJECT.",
    "fitness": "Fitness of the scenario: a name, or an own one as module:OBJECT.",
    "controller": "Kind of the controller: a name, or an own law as module:OBJECT.",
    "strategy": "Make an own search strategy known, as module:OBJECT; search.preset names it.",
}
KNOWN = {
    "plant": "Make an own plant known, as module:OBJECT.",
    "fitness": "Make an own fitness known, as module:OBJECT.",
    "controller": "Make an own controller's law known, as module:OBJECT.",
    "strategy": CHOICES["strategy"],
}


def choosing_plugins(command: Command) -> Command:
    """A command with --plant, --fitness, --controller and --strategy.

    What they name is made known; the changes of a scenario that choose it come to the command as
    ``chosen``, by the option.
    """
    return _with_options(CHOICES, command)


def knowing_plugins(command: Command) -> Command:
    """A command with the same options, which only make known what files name."""

    @wraps(command)
    def unchosen(chosen: dict[str, str], **given: Any) -> None:
        command(**given)

    return _with_options(KNOWN, unchosen)


def _with_options(helps: dict[str, str], command: Command) -> Command:

    @wraps(command)
    def wrapped(used: tuple[str, ...], **given: Any) -> None:
        texts = {key: given.pop(key) for key in helps}
        told = {key: text for key, text in texts.items() if text}
        command(chosen=chosen(told, used), **given)

    wrapped = click.option("--use", "used", multiple=True, metavar="MODULE:OBJECT", help=USE)(
        wrapped
    )
    for key, text in reversed(helps.items()):
        wrapped = click.option(f"--{key}", help=text)(wrapped)
    return wrapped


def chosen(texts: dict[str, str], used: tuple[str, ...]) -> dict[str, str]:
    """Make known what each option names; option -> a change of the scenario that chooses it.

    What is ``used`` only becomes known.

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
