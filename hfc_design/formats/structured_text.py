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
from hfc_design.formats.units import comment, facts, signal_units
from hfc_design.formats.writing import rendered

#: No two underscores in a row, none at the end.
NAME = re.compile(r"[A-Za-z](_?[A-Za-z0-9])*")
_WORDS = """
abs acos action add and array asin at atan bool by byte case concat configuration constant
continue cos date delete dint dint_to_lreal div do dt dword else elsif en end_action end_case
end_configuration end_for end_function end_function_block end_if end_program end_repeat
end_resource end_step end_struct end_transition end_type end_var end_while eno eq exit exp expt
false find for from function function_block ge gt if initial_step insert int interval le left
len limit lint ln log lreal lt lword max mid min mod move mul mux ne non_retain not of on or
priority program read_only read_write real ref_to repeat replace resource retain return right
rol ror sel shl shr sin single sint sqrt step string struct sub super tan task then this time
time_of_day to tod transition trunc true type udint uint ulint until usint var var_access
var_config var_external var_global var_in_out var_input var_output var_temp while with word
wstring xor ld ldn st stn s r jmp cal ret
"""
#: Keywords, types and functions of IEC 61131-3.
RESERVED = set(_WORDS.split())
#: What the block itself calls by these names within a sample.
WITHIN = ["weighted", "part", "firing_row", "firing_column"]
LEFT_OUT = "the adaptation is not here: terms and rules are those that it starts from"


#: What a kind's values say of the block's variables, beside what only its template reads.
USUAL: dict[str, Any] = {"constants": {}, "remembered": [], "within": [], "units": []}


def write(design: Design, path: Path) -> None:
    """Write ``design`` as one function block to the file ``path``.

    An adaptation is left out: the block holds the table that it starts from and says so.

    Raises:
        UserError: the kind has no Structured Text, or a name is none of IEC 61131-3.
        RunError: the file cannot be written.
    """
    lacks = "json holds its gains, its law is in Python only"
    template: Template = needed(design.kind.st, design, lacks)
    values = USUAL | template.values(design.controller)
    units = values["units"]
    limit = design.limits.command
    values["constants"] = values["constants"] | {
        f"table_{unit.name}": [value for row in unit.table for value in row] for unit in units
    }
    if limit is not None:
        values["constants"] = values["constants"] | {"largest": limit}
    if units:
        values["within"] = [*values["within"], *WITHIN, *(unit.name for unit in units)]
    signals = [identifier(name) for name in design.kind.reads(design.controller)]
    name = "fb_" + re.sub("_+", "_", identifier(design.name)).strip("_")
    names = [*signals, *values["constants"], *values["remembered"], *values["within"]]
    indices = ["i", "j", "in_column", "in_row"] if units else []
    _check_names([name, "reset", "command", *names, *indices])
    known = signal_units(design)
    notes = [LEFT_OUT] if values.get("leaves_out") else []
    text = rendered(
        "controller.st.j2",
        design,
        template.places,
        signals={signal: known.get(signal, "") for signal in signals},
        block=name,
        limit=limit,
        command_unit=known.get("command", ""),
        head=comment([*facts(design), *notes]),
        literals=lambda row: ", ".join(map(real, row)),
        **values,
    )
    write_whole(path, text.encode())


def _check_names(names: list[str]) -> None:
    """IEC 61131-3 knows no difference between upper and lower case."""
    taken = dict.fromkeys(RESERVED, "a word of the language")
    for name in names:
        if not NAME.fullmatch(name):
            raise UserError(f"--to st: {name} is no identifier of IEC 61131-3; rename it")
        other = taken.setdefault(name.casefold(), name)
        if other is not name:
            raise UserError(
                f"--to st: IEC 61131-3 takes {name} for {other}; rename it in the design file"
            )


FORMATS = (Format("st", "Structured Text of IEC 61131-3, one function block", write, ".st"),)
