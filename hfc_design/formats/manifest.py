"""How a design's units are wired, and what surrounds them: the files beside the units' own.

A file of FLL, FCL, FML or FIS holds one unit. ``manifest.csv`` lists the units in evaluation order
with what they read; ``controller.json`` has everything else that the command takes: scales, limits,
gains, and the steps of one sample in words.
"""

import json
import re
from collections.abc import Collection
from typing import Any

from hfc_design.controllers.rules import RuleUnit, identifier
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.formats.csv_tables import csv_text
from hfc_design.formats.units import facts, rule_base, rule_units, signal_units


def surroundings(design: Design, suffix: str) -> dict[str, str]:
    """``manifest.csv`` and ``controller.json`` by file name, for units in ``NAME.suffix``.

    Raises:
        UserError: the design is of a kind without rule tables.
    """
    record = json.dumps(_controller(design), indent=1, allow_nan=False)
    return {"manifest.csv": _manifest(rule_units(design), suffix), "controller.json": record + "\n"}


def distinct(design: Design, target: str, reserved: Collection[str]) -> list[RuleUnit]:
    """``rule_units`` whose names and labels are identifiers, each one of its own.

    None is a word of ``reserved`` either. Upper and lower case are alike, as in IEC 61131.

    Raises:
        UserError: they are not.
    """
    units = rule_units(design)
    inputs = [identifier(name) for name in rule_base(design).inputs(design.controller)]
    rows, columns = (
        [t.label for t in terms] for terms in (units[0].row_terms, units[0].column_terms)
    )
    for names in ([*inputs, *(unit.name for unit in units)], rows, columns):
        taken = {word.casefold() for word in reserved}
        for name in names:
            if not re.fullmatch(r"[A-Za-z](_?[A-Za-z0-9])*", name):
                raise UserError(
                    f"--to {target}: {name} is no identifier there: a letter, then letters, digits "
                    "and single underscores between them; rename it in the design file"
                )
            if name.casefold() in taken:
                raise UserError(
                    f"--to {target}: {name} is a word of that format, or two names are {name} "
                    "there; rename it in the design file"
                )
            taken.add(name.casefold())
    return units


def _manifest(units: list[RuleUnit], suffix: str) -> str:
    rows = [["unit", "column_input", "row_input", "file"]]
    rows += [[unit.name, unit.column, unit.row, f"{unit.name}.{suffix}"] for unit in units]
    return csv_text(rows)


def _controller(design: Design) -> dict[str, Any]:
    units = signal_units(design)
    return {
        "facts": facts(design),
        "sample_time_s": design.controller.sample_time_s,
        "command_unit": units.get("command", ""),
        **rule_base(design).about(design.controller, units),
    }
