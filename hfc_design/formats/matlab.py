"""MATLAB and Octave export: fuzzy inference systems, and a MAT file of the whole design."""

import io
import math
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.io import savemat

from hfc_design.controllers.rules import FlatGaussian
from hfc_design.core.records import UserError, option
from hfc_design.files.design import Design
from hfc_design.formats.fuzzy_files import Input, inputs, texts, unit_head
from hfc_design.formats.scripts import function, named
from hfc_design.formats.writing import Format, facts, rendered, rule_units

EDGES = {"left": -math.inf, "right": math.inf}
#: Largest -ln of a firing strength: exp(-700) is nearly the smallest normal number.
FADED = 700.0


def systems(design: Design) -> dict[str, str]:
    """Return a folder with one ``.fis`` per unit, and ``controller.m``, which works without them.

    A hierarchy also gets ``controller_tree.m``, which builds MATLAB's ``fistree``.

    Raises:
        UserError: there are no rule tables, a name is invalid, or no rule fires for some inputs.
    """
    files, units = texts(design, "fis"), rule_units(design)
    sides = inputs(units)
    for name, pair in sides.items():
        # Where no rule fires, a unit gives 0, Octave's evalfis an error, MATLAB's another value.
        if sum(map(_faintest, pair)) > FADED:
            gaps = f"the terms of {name} leave gaps in which no rule fires"
            others = "programs that read the format disagree on the output there"
            raise UserError(f"{option('to', 'fis')}: {gaps}; {others}")
    values: dict[str, object] = {"units": units, "head": unit_head(design)}
    files["controller.m"] = function(design, "controller")
    wires = [(name, unit.name) for unit in units for name in (unit.row, unit.column)]
    if wires := [wire for wire in wires if wire[0] in sides]:
        files["controller_tree.m"] = rendered("controller_tree.m.j2", design, wires=wires, **values)
    return files


def _faintest(side: Input) -> float:
    """Return -ln of the least value, over an input's range, of its highest degree (LL eq. 3)."""
    terms = [term for term in side.terms if isinstance(term, FlatGaussian)]
    if not terms:
        return 0.0  # triangles leave no gap, see flc.record
    ends = (edge for term in terms for edge in (term.low, term.high))
    marks = sorted({side.lowest, side.highest, *ends})
    middles = [0.5 * (a + b) for a, b in pairwise(marks)]
    return max(min(_exponent(term, u) for term in terms) for u in [*marks, *middles])


def _exponent(term: FlatGaussian, u: float) -> float:
    return 0.5 * (max(term.low - u, u - term.high, 0.0) / term.sigma) ** 2


def variables(design: Design) -> bytes:
    """Return a design as a MAT file (version 5), without score and origin; SciPy reads it too.

    Variables: ``design`` (name, plant, facts), ``controller`` (as in the design file; a missing
    edge of a term is infinite), ``limits`` (command, command_rate) if set, and with rule tables
    ``units`` (name, column_input, row_input, table) in evaluation order, and ``wiring``.

    Raises:
        UserError: a name cannot be that of a field in MATLAB.
    """
    lines = np.array(facts(design), dtype=object)
    plant = design.plant.model_dump(mode="json")
    data: dict[str, object] = {"design": {"name": design.name, "plant": plant, "facts": lines}}
    data["controller"] = design.controller.model_dump(mode="json")
    limits = {key: getattr(design.limits, key) for key in ("command", "command_rate")}
    if any(limits.values()):
        data["limits"] = {key: x for key, x in limits.items() if x is not None}
    if rules := design.kind.rule_base:
        units = rules.units(design.controller)
        data["units"] = [
            {
                "name": unit.name,
                "column_input": unit.column,
                "row_input": unit.row,
                "table": [list(row) for row in unit.table],
            }
            for unit in units
        ]
        # (units, 2): numbers of column and row source: inputs from 1 on, then the units.
        names = [*rules.inputs(design.controller), *(unit.name for unit in units)]
        wiring = [[names.index(unit.column) + 1.0, names.index(unit.row) + 1.0] for unit in units]
        data["wiring"] = np.array(wiring)
    buffer: Any = io.BytesIO()  # the type stubs allow only paths
    savemat(buffer, {key: _matlab(value) for key, value in data.items()}, long_field_names=True)
    head = f"MATLAB 5.0 MAT-file, {facts(design)[0]}".encode("ascii")
    return head.ljust(116)[:116] + buffer.getvalue()[116:]  # SciPy would write the date


def _matlab(value: Any) -> object:
    """Return a value for ``savemat``: records become structs, numbers arrays, labels cells."""
    if value is None:
        return np.zeros((0, 0))
    if isinstance(value, dict):
        return _struct(value)
    if isinstance(value, list) and value and isinstance(value[0], dict):
        records = [_struct(record) for record in value]
        fields = [(field, object) for field in records[0]]
        return np.array([[tuple(record.values()) for record in records]], dtype=fields)
    if isinstance(value, list):
        numbers = np.array(value)
        return np.atleast_2d(numbers.astype(float if numbers.dtype.kind in "fi" else object))
    return value if isinstance(value, str | np.ndarray) else float(value)


def _struct(record: dict[str, object]) -> dict[str, object]:
    parts = ((key, EDGES.get(key) if value is None else value) for key, value in record.items())
    return {named("mat", key): _matlab(value) for key, value in parts}


FIS = "a folder for MATLAB and Octave, one .fis per unit, and controller.m"
MAT = "a MAT file with tables, terms, gains and wiring"
FORMATS = (Format("fis", FIS, systems), Format("mat", MAT, variables, ".mat"))
