"""Every kind of plug-in, and what the command line named of them, for other processes to know."""

from typing import Any

from hfc_design.controllers.kinds import KINDS
from hfc_design.core.plugins import Group, References
from hfc_design.files.machine import ALL_PLANTS
from hfc_design.objectives.fitness import OWN_FITNESSES

#: By the option that names one, without its dashes.
GROUPS: dict[str, Group[Any]] = {group.what: group for group in (ALL_PLANTS, OWN_FITNESSES, KINDS)}


def given() -> References:
    """What this process was told on its command line; never what a file or a package says."""
    return [(what, text) for what, group in GROUPS.items() for text in group.given.values()]


def know(references: References) -> None:
    """Make these known, and no longer those that an earlier call made known.

    Raises:
        UserError: one cannot be imported or used here.
    """
    for group in GROUPS.values():
        group.forget()
    for what, text in references:
        GROUPS[what].resolve(text)
