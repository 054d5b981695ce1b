"""What every format is written from: facts for the file's head, rule tables, units of signals."""

import hashlib
import re

from hfc_design import __version__
from hfc_design.controllers.kind import needed
from hfc_design.controllers.rules import RuleBase, RuleUnit
from hfc_design.files.design import Design, design_json
from hfc_design.files.machine import ALL_PLANTS, PlantSettings


def rule_base(design: Design) -> RuleBase:
    """What the design's kind tells of its rule tables.

    Raises:
        UserError: the design is of a kind without rule tables.
    """
    found: RuleBase = needed(design.kind.rules, design, "no rule tables")
    return found


def rule_units(design: Design) -> list[RuleUnit]:
    """The units in evaluation order, the last one gives the output.

    Raises:
        UserError: the design is of a kind without rule tables.
    """
    return rule_base(design).units(design.controller)


def signal_units(design: Design) -> dict[str, str]:
    """Unit of each signal of the design's plant, of "error" and "command" too; {} if unknown."""
    if design.plant.name not in ALL_PLANTS.known:
        return {}
    machine = PlantSettings(**design.plant.model_dump()).machine
    if design.axis:
        return machine.drives[machine.axes.index(design.axis)].units
    return machine.drives[0].units if len(set(machine.drives)) == 1 else {}


def facts(design: Design) -> list[str]:
    """Lines for the head of a file: what made it, and from which design."""
    digest = hashlib.sha256(design_json(design).encode()).hexdigest()
    controller = design.controller
    return [
        f"made by hfc-design {__version__}",
        f"design {design.name}, sha256 {digest}",
        f"controller {controller.kind} for the plant {design.plant.name}, "
        f"stepped every {controller.sample_time_s!r} s",
    ]


def comment(lines: list[str]) -> list[str]:
    """Lines for a comment or a string; nothing in them can end it."""
    return [re.sub(r"[^A-Za-z0-9 .,:;_+-]", "_", line) for line in lines]
