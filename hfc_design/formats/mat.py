"""A MAT file (version 5) with everything that a design file holds, for MATLAB, Octave and SciPy.

Variables: ``design`` (name, plant, facts), ``controller`` (as in the design file; a missing edge of
a term is infinite), ``limits`` where the design has one, and of a rule base ``units`` (name,
column_input, row_input, table) in evaluation order with ``wiring``.
"""

import io
import math
from typing import Any

import numpy as np
from scipy.io import savemat

from hfc_design.files.design import Design
from hfc_design.formats.writing import Format, facts, matlab_name

EDGES = {"left": -math.inf, "right": math.inf}


def variables(design: Design) -> bytes:
    """The MAT file; UserError: a name is none of a field in MATLAB."""
    lines = np.array(facts(design), dtype=object)
    plant = design.plant.model_dump(mode="json")
    data: dict[str, object] = {"design": {"name": design.name, "plant": plant, "facts": lines}}
    data["controller"] = design.controller.model_dump(mode="json")
    if design.limits.command is not None:
        data["limits"] = {"command": design.limits.command}
    if rules := design.kind.rules:
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
        # (units, 2) column and row source: 1, 2, ... the inputs, then the units in their order.
        names = [*rules.inputs(design.controller), *(unit.name for unit in units)]
        wiring = [[names.index(unit.column) + 1.0, names.index(unit.row) + 1.0] for unit in units]
        data["wiring"] = np.array(wiring)
    buffer: Any = io.BytesIO()  # the stubs know paths only
    savemat(buffer, {key: _matlab(value) for key, value in data.items()}, long_field_names=True)
    head = f"MATLAB 5.0 MAT-file, {facts(design)[0]}".encode("ascii")
    return head.ljust(116)[:116] + buffer.getvalue()[116:]  # SciPy puts the date there


def _matlab(value: Any) -> object:
    """Records as structs, lists of them as struct arrays, numbers as arrays, labels as cells."""
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
    return {matlab_name("mat", key): _matlab(value) for key, value in parts}


FORMATS = (Format("mat", "a MAT file with tables, terms, gains and wiring", variables, ".mat"),)
