"""Structured Text of IEC 61131-3: one function block that holds the whole controller.

LREAL, arrays of one dimension and no arrays as arguments: what every compiler gets right.
"""

import re

from hfc_design.controllers.kind import Template, needed
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Json
from hfc_design.files.design import Design
from hfc_design.formats.fcl import real
from hfc_design.formats.writing import NO_CODE, Format, check_names, head, rendered, signals_read

#: What the block itself calls by these names within a sample.
WITHIN = ["weighted", "part", "firing_row", "firing_column"]
CLASH = "IEC 61131-3 takes {name} for {other}"
LEFT_OUT = "the adaptation is not here: terms and rules are those that it starts from"
#: What a kind's values say of the block's variables, beside what only its template reads.
USUAL: Json = {"constants": {}, "remembered": [], "within": [], "units": []}


def block(design: Design) -> str:
    """``design`` as one function block.

    An adaptation is left out: the block holds the table that it starts from and says so.

    Raises:
        UserError: the kind has no such code, or a name is none of the language.
    """
    template: Template = needed(design.kind.st, design, NO_CODE.format("Structured Text"))
    values = USUAL | template.values(design.controller)
    units, constants, within = values["units"], dict(values["constants"]), [*values["within"]]
    constants |= {f"table_{unit.name}": [u for row in unit.table for u in row] for unit in units}
    if design.limits.command is not None:
        constants["largest"] = design.limits.command
    if units:
        within += [*WITHIN, *(unit.name for unit in units)]
    signals = signals_read(design)
    name = "fb_" + re.sub("_+", "_", identifier(design.name)).strip("_")
    names = [*signals, *constants, *values["remembered"], *within]
    indices = ["i", "j", "in_column", "in_row"] if units else []
    check_names("st", [name, "reset", "command", *names, *indices], CLASH)
    notes = [LEFT_OUT] if values.get("leaves_out") else []
    values |= {
        "signals": signals,
        "constants": constants,
        "within": within,
        "block": name,
        "head": head(design, notes),
        "literals": lambda row: ", ".join(map(real, row)),
    }
    return rendered("controller.st.j2", design, template.places, **values)


FORMATS = (Format("st", "Structured Text of IEC 61131-3, one function block", block, ".st"),)
