"""Fuzzy Inference Systems of MATLAB and of Octave's fuzzy-logic-toolkit, and what runs them."""

import json
import re
from itertools import pairwise
from pathlib import Path
from typing import Any

from hfc_design.controllers.rules import FlatGaussian
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.formats.format import Format
from hfc_design.formats.fuzzy_files import Input, head, inputs, texts
from hfc_design.formats.writing import (
    RESERVED,
    rendered,
    rule_units,
    signal_units,
    write_folder,
)

#: exp(-700) is about the smallest number of full precision.
FADED = 700.0


def write(design: Design, path: Path) -> None:
    """Write a folder with one ``.fis`` a unit and ``controller.m``, which evaluates them all.

    A hierarchy also gets ``controller_tree.m``, which builds MATLAB's ``fistree``.

    Raises:
        UserError: a name is none of MATLAB, or there are inputs for which no rule fires.
    """
    files = texts(design, "fis")
    units = rule_units(design)
    tables = {unit.name: unit.table for unit in units}
    sides = {unit.name: inputs(unit, tables) for unit in units}
    for unit in units:
        # Where no rule fires a unit gives 0, Octave's evalfis an error, MATLAB's another value.
        if sum(map(_faintest, sides[unit.name])) > FADED:
            raise UserError(
                f"--to fis: the terms of {unit.name} leave gaps in which no rule fires, and the "
                "programs that read the format have no common value for these"
            )
    about = json.loads(files["controller.json"])
    signals, remembered = _signals(design, about)
    for name in signals:
        if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) or name in RESERVED["fis"]:
            raise UserError(f"--to fis: {name} is no name of a field in MATLAB; rename it")
    fields = ", ".join(f"{name} [{unit}]" for name, unit in signals.items())
    values: dict[str, object] = {"units": units, "head": head(design), "about": about}
    values |= {"sides": sides, "fields": fields, "remembered": remembered}
    files["controller.m"] = rendered("controller.m.j2", design, **values)
    wires = [(name, unit.name) for unit in units for name in (unit.row, unit.column)]
    if wires := [wire for wire in wires if wire[0] in tables]:
        files["controller_tree.m"] = rendered("controller_tree.m.j2", design, wires=wires, **values)
    write_folder(path, files)


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
    return 0.5 * (max(term.low - u, u - term.high, 0.0) / term.sigma) ** 2


def _signals(design: Design, about: dict[str, Any]) -> tuple[dict[str, str], list[str]]:
    """Signals that the command takes with their units, and what is remembered."""
    if "inputs" not in about:
        low = {"velocity": "BLU/s"} if about["low_velocity"] else {}
        return {"error": "BLU"} | low, ["error", "action", "integral"]
    units = signal_units(design)
    names = ["error", "error_rate", *(item["signal"] for item in about["inputs"])]
    earlier = {item["signal"] for item in about["inputs"] if item["samples_ago"]}
    return {name: units.get(name, "") for name in names}, sorted(earlier)


TEXT = "a folder for MATLAB and Octave, one .fis a unit, and controller.m"
FORMATS = (Format("fis", TEXT, write),)
