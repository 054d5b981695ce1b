"""Structured Text of IEC 61131-3: one function block that holds the whole controller.

LREAL, arrays of one dimension and no arrays as arguments: what every compiler gets right.
"""

import re
from pathlib import Path
from typing import Any, NamedTuple

from hfc_design.controllers.flc.record import (
    AflcDesign,
    FlcDesign,
    FuzzyRecord,
    PidDesign,
    SoflcDesign,
)
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import UserError
from hfc_design.files.design import Design, HierarchicalDesign, PdDesign
from hfc_design.formats.fcl import real
from hfc_design.formats.units import (
    RuleUnit,
    Triangle,
    built_in,
    comment,
    facts,
    identifier,
    rule_units,
)
from hfc_design.formats.writing import rendered
from plants import PLANTS

PREVIOUS = "previous_"
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


class Block(NamedTuple):
    """What the template needs: variables by name, and how the controller goes."""

    signals: list[str]
    constants: dict[str, Any]  # number, or numbers of an array
    remembered: list[str]
    within: list[str]
    units: list[RuleUnit]
    inputs: tuple[str, ...] = ()  # of a hierarchy
    form: str = ""


def write(design: Design, path: Path) -> None:
    """Write ``design`` as one function block to the file ``path``.

    An adaptation is left out: the block holds the table that it starts from and says so.

    Raises:
        UserError: a name is none of IEC 61131-3.
        RunError: the file cannot be written.
    """
    block = _block(design)
    name = "fb_" + re.sub("_+", "_", identifier(design.name)).strip("_")
    _check_names([name, *_declared(block)])
    units = PLANTS[design.plant.name].units if design.plant.name in PLANTS else {}
    names = {unit.name for unit in block.units}
    text = rendered(
        "controller.st.j2",
        design,
        **block._asdict()
        | {"signals": {signal: units.get(signal, "") for signal in block.signals}},
        block=name,
        kind=design.controller.kind,
        command_unit=units.get("command", ""),
        head=comment([*facts(design), *_notes(design)]),
        scaled=lambda source: source if source in names else f"scaled_{source}",
        literals=lambda row: ", ".join(map(real, row)),
    )
    write_whole(path, text.encode())


def _block(design: Design) -> Block:
    controller = built_in(design)
    if isinstance(controller, HierarchicalDesign):
        return _hierarchy(controller, rule_units(design))
    if isinstance(controller, FuzzyRecord):
        return _feed_drive(controller, rule_units(design))
    if isinstance(controller, PdDesign):
        gains = {"kp": controller.pd.kp, "kd": controller.pd.kd}
        return Block(["error", "error_rate"], gains, [], [], [])
    assert isinstance(controller, PidDesign)
    part = controller.pid
    gains = {
        "kp": part.k_p,
        "ki": part.k_i,
        "kd": part.k_d,
        "sample_time": controller.sample_time_s,
    }
    return Block(["error"], gains, ["previous_error", "error_sum"], [], [])


def _hierarchy(controller: HierarchicalDesign, units: list[RuleUnit]) -> Block:
    names = [identifier(item.name) for item in controller.inputs]
    signals = ["error", "error_rate", *(name.removeprefix(PREVIOUS) for name in names)]
    pd = controller.pd
    scales = {f"scale_{n}": item.scale for n, item in zip(names, controller.inputs, strict=True)}
    terms = {
        f"term_{key}": [getattr(term, key) for term in controller.terms]
        for key in ("centre", "half_width", "rate")
    }
    gains = {"kp": pd.kp, "kd": pd.kd, "output_scale": controller.output_scale}
    return Block(
        list(dict.fromkeys(signals)),
        gains | scales | terms | _tables(units),
        [name for name in names if name.startswith(PREVIOUS)],
        ["distance", *WITHIN, *(f"scaled_{n}" for n in names), *(unit.name for unit in units)],
        units,
        inputs=tuple(names),
    )


def _feed_drive(controller: FuzzyRecord, units: list[RuleUnit]) -> Block:
    constants: dict[str, Any] = {
        "integral_gain": controller.integral_gain,
        "sample_time": controller.sample_time_s,
    }
    unit = units[0]
    for name, terms in ((unit.row, unit.row_terms), (unit.column, unit.column_terms)):
        triangles = [term for term in terms if isinstance(term, Triangle)]
        # The outermost edges are infinite and not read.
        constants[f"{name}_left"] = [0.0, *(term.left for term in triangles[1:])]
        constants[f"{name}_centre"] = [term.centre for term in triangles]
        constants[f"{name}_right"] = [*(term.right for term in triangles[:-1]), 0.0]
    low = controller.low_velocity
    if low:
        constants |= {
            "forward": low.forward,
            "backward": low.backward,
            "breakaway": low.breakaway,
            "highest_velocity": low.highest_velocity_mm_s,
            "smallest_error": low.smallest_error,
        }
    return Block(
        ["error", "velocity"] if low else ["error"],
        constants | _tables(units),
        ["previous_error", "control_action", "integral"],
        ["degree", *WITHIN, "error_change", unit.name, *(["v"] if low else [])],
        units,
        form=controller.form if isinstance(controller, FlcDesign) else "PD",
    )


def _tables(units: list[RuleUnit]) -> dict[str, list[float]]:
    return {f"table_{unit.name}": [value for row in unit.table for value in row] for unit in units}


def _notes(design: Design) -> list[str]:
    controller = design.controller
    if isinstance(controller, HierarchicalDesign):
        adapts = controller.adaptation is not None
    else:
        adapts = isinstance(controller, AflcDesign | SoflcDesign)
    notes = ["the adaptation is not here: terms and rules are those that it starts from"]
    return notes if adapts else []


def _declared(block: Block) -> list[str]:
    names = ["reset", "command", *block.signals, *block.constants, *block.remembered]
    return names + (["i", "j", "in_column", "in_row", *block.within] if block.units else [])


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
