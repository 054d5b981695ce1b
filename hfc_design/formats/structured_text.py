"""Structured Text of IEC 61131-3: one function block that holds the whole controller.

LREAL, arrays of one dimension and no arrays as arguments: what every compiler gets right.
"""

import re
from pathlib import Path
from typing import Any

from hfc_design.controllers.kind import Template, needed
from hfc_design.controllers.rules import identifier
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.formats.fcl import real
from hfc_design.formats.format import Format
from hfc_design.formats.writing import NO_CODE, RESERVED, comment, facts, rendered, signal_units

#: No two underscores in a row, none at the end.
NAME = re.compile(r"[A-Za-z](_?[A-Za-z0-9])*")
#: What the block itself calls by these names within a sample.
WITHIN = ["weighted", "part", "firing_row", "firing_column"]
LEFT_OUT = "the adaptation is not here: terms and rules are those that it starts from"
#: What a kind's values say of the block's variables, beside what only its template reads.
USUAL: dict[str, Any] = {"constants": {}, "remembered": [], "within": [], "units": []}


def write(design: Design, path: Path) -> None:
    """Write ``design`` as one function block to the file ``path``.

    An adaptation is left out: the block holds the table that it starts from and says so.
    """
    template: Template = needed(design.kind.st, design, NO_CODE)
    values = USUAL | template.values(design.controller)
    units, limit = values["units"], design.limits.command
    values["constants"] = values["constants"] | {
        f"table_{unit.name}": [value for row in unit.table for value in row] for unit in units
    }
    if limit is not None:
        values["constants"]["largest"] = limit
    if units:
        values["within"] = [*values["within"], *WITHIN, *(unit.name for unit in units)]
    signals = [identifier(name) for name in design.kind.reads(design.controller)]
    name = "fb_" + re.sub("_+", "_", identifier(design.name)).strip("_")
    names = [*signals, *values["constants"], *values["remembered"], *values["within"]]
    indices = ["i", "j", "in_column", "in_row"] if units else []
    _check_names([name, "reset", "command", *names, *indices])
    known = signal_units(design)
    notes = [LEFT_OUT] if values.get("leaves_out") else []
    values |= {
        "signals": {signal: known.get(signal, "") for signal in signals},
        "block": name,
        "limit": limit,
        "command_unit": known.get("command", ""),
        "head": comment([*facts(design), *notes]),
        "literals": lambda row: ", ".join(map(real, row)),
    }
    write_whole(path, rendered("controller.st.j2", design, template.places, **values).encode())


def _check_names(names: list[str]) -> None:
    """IEC 61131-3 knows no difference between upper and lower case."""
    taken = dict.fromkeys(RESERVED["st"], "a word of the language")
    for name in names:
        if not NAME.fullmatch(name):
            raise UserError(f"--to st: {name} is no identifier of IEC 61131-3; rename it")
        other = taken.setdefault(name.casefold(), name)
        if other is not name:
            raise UserError(
                f"--to st: IEC 61131-3 takes {name} for {other}; rename it in the design file"
            )


FORMATS = (Format("st", "Structured Text of IEC 61131-3, one function block", write, ".st"),)
