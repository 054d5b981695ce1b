"""Fuzzy Inference Systems of MATLAB and of Octave's fuzzy-logic-toolkit, and what runs them."""

import json
import re
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

from hfc_design.controllers.rules import FlatGaussian, RuleUnit
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.formats.format import Format
from hfc_design.formats.fuzzy_files import Input, head, inputs, texts
from hfc_design.formats.units import rule_units, signal_units
from hfc_design.formats.writing import rendered, write_folder

#: Keywords of MATLAB and Octave; a signal is the field of a struct.
RESERVED = {
    *("break", "case", "catch", "classdef", "continue", "do", "else", "elseif", "end", "for"),
    *("function", "global", "if", "otherwise", "parfor", "persistent", "return", "spmd", "switch"),
    *("try", "until", "while", "unwind_protect", "end_try_catch", "end_unwind_protect", "enum"),
    *("endfunction", "endif", "endfor", "endwhile", "endswitch", "endparfor", "endclassdef"),
    *("events", "endevents", "methods", "endmethods", "properties", "endproperties"),
    *("enumeration", "endenumeration", "import", "unwind_protect_cleanup", "__FILE__", "__LINE__"),
}
#: exp(-700) is about the smallest number of full precision.
FADED = 700.0


def write(design: Design, path: Path) -> None:
    """Write a folder with one ``.fis`` a unit and ``controller.m``, which evaluates them all.

    A hierarchy also gets ``controller_tree.m``, which builds MATLAB's ``fistree``.

    Raises:
        UserError: the design has no rule tables, a name is none of MATLAB, or there are inputs
            for which no rule fires.
        RunError: the folder cannot be written.
    """
    files = texts(design, "fis", "fis", RESERVED)
    units = rule_units(design)
    tables = {unit.name: unit.table for unit in units}
    entering = {unit.name: inputs(unit, tables) for unit in units}
    for unit in units:
        _check_rules_fire(unit, entering[unit.name])
    about = json.loads(files["controller.json"])
    signals, remembered = _signals(design, about)
    for name in signals:
        if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) or name in RESERVED:
            raise UserError(f"--to fis: {name} is no name of a field in MATLAB; rename it")
    write_text = partial(rendered, design=design, units=units, head=head(design))
    files["controller.m"] = write_text(
        "controller.m.j2",
        about=about,
        fields=", ".join(f"{name} [{unit}]" for name, unit in signals.items()),
        remembered=remembered,
        span=lambda unit, k: _span(entering[unit.name][k]),
    )
    if wires := _wires(units):
        files["controller_tree.m"] = write_text("controller_tree.m.j2", wires=wires)
    write_folder(path, files)


def _check_rules_fire(unit: RuleUnit, sides: tuple[Input, Input]) -> None:
    """Where no rule fires a unit gives 0, Octave's evalfis an error, MATLAB's another value."""
    if sum(_faintest(side) for side in sides) > FADED:
        raise UserError(
            f"--to fis: the terms of {unit.name} leave gaps in which no rule fires, and the "
            "programs that read the format have no common value for these"
        )


def _faintest(side: Input) -> float:
    """-ln of the lowest that the highest degree of an input can be (LL eq. 3)."""
    terms = [term for term in side.terms if isinstance(term, FlatGaussian)]
    if not terms:
        return 0.0  # triangles leave no gap, see flc.record
    ends = (edge for term in terms for edge in (term.low, term.high))
    marks = sorted({side.lowest, side.highest, *ends})
    middles = [0.5 * (a + b) for a, b in pairwise(marks)]
    return max(min(_exponent(term, u) for term in terms) for u in [*marks, *middles])


def _exponent(term: FlatGaussian, u: float) -> float:
    distance = max(term.low - u, u - term.high, 0.0)
    return 0.5 * (distance / term.sigma) ** 2


def _signals(design: Design, about: dict[str, Any]) -> tuple[dict[str, str], list[str]]:
    """Signals that the command takes with their units, and what is remembered."""
    if "inputs" not in about:
        low = {"velocity": "BLU/s"} if about["low_velocity"] else {}
        return {"error": "BLU"} | low, ["error", "action", "integral"]
    units = signal_units(design)
    names = ["error", "error_rate", *(item["signal"] for item in about["inputs"])]
    earlier = {item["signal"] for item in about["inputs"] if item["samples_ago"]}
    return {name: units.get(name, "") for name in names}, sorted(earlier)


def _span(side: Input) -> str:
    return f"[{side.lowest!r}, {side.highest!r}]"


def _wires(units: list[RuleUnit]) -> list[tuple[str, str]]:
    """(unit, unit that reads it)."""
    names = {unit.name for unit in units}
    return [
        (source, unit.name)
        for unit in units
        for source in (unit.row, unit.column)
        if source in names
    ]


FORMATS = (
    Format("fis", "a folder for MATLAB and Octave, one .fis a unit, and controller.m", write),
)
