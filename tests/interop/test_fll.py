"""FLL read back by pyfuzzylite and by the C++ tool fuzzylite.

Measured, the worst of all designs and relative to the largest output: pyfuzzylite 7e-16. The C++
tool drops rules that fire at less than 1e-6: against the unit without these 8e-16, against the unit
itself 2e-7 with the published tables and 9e-6 with random ones, 3e-7 in the command.
"""

import numpy as np
import pytest
from fuzzylite_tool import in_python, in_tool
from wiring import UNITS, controller_error, design, silent, unit_error

from hfc_design.formats import FORMATS


@pytest.fixture(params=["pyfuzzylite", "fuzzylite"])
def reader(request, program, tmp_path):
    """(evaluate, firing up to which it drops a rule)."""
    if request.param == "pyfuzzylite":
        return evaluated, 0.0
    tool = program("fuzzylite")
    return lambda *job: in_tool(tool, tmp_path / "points.fld", "fll", *job), 1e-6


def evaluated(file, row, column, points):
    inputs = {row: points[:, 0].tolist(), column: points[:, 1].tolist()}
    return np.array(in_python("evaluate_fll.py", file=str(file), inputs=inputs))


@pytest.mark.parametrize("name", UNITS)
def test_every_unit_and_the_controller_read_back(name, reader, tmp_path):
    evaluate, least = reader
    record, folder = design(name), tmp_path / "out"
    FORMATS["fll"].write(record, folder)
    assert unit_error(record, folder, "fll", evaluate, least) <= 1e-12
    assert controller_error(record, folder, evaluate) <= (2e-6 if least else 1e-12)


def test_a_unit_gives_0_where_no_rule_fires(reader, tmp_path):
    evaluate, _ = reader
    FORMATS["fll"].write(silent(), tmp_path / "out")
    file = tmp_path / "out" / "unit_7.fll"
    names = "previous_spindle_velocity", "spindle_velocity"
    assert evaluate(file, *names, np.array([[0.1, 0.1], [0.0, 0.0]])).tolist() == [0.0, 0.4853]
