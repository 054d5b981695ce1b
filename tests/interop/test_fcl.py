"""FCL of IEC 61131-7 read back by the C++ tool fuzzylite.

The tool does not know the standard's comments, so they are taken away; else the file is as it is.
Measured, the worst of all designs and relative to the largest output: 4e-4 with the terms of LL
as polygons, 8e-7 and 1e-4 in the command of the published and the random designs; 3e-16 with
triangles.

jFuzzyLogic is on none of PyPI, Debian and npm: tests/published/formats/test_fuzzy_files.py reads
its dialect by a grammar of its own.
"""

import re

import pytest
from fuzzylite_tool import in_tool
from wiring import UNITS, controller_error, design, unit_error

from hfc_design.formats import FORMATS


@pytest.fixture
def run(program, tmp_path):
    tool = program("fuzzylite")

    def evaluate(file, *rest):
        bare = tmp_path / "bare.fcl"
        bare.write_text(re.sub(r"\(\*.*?\*\)", "", file.read_text(), flags=re.DOTALL))
        return in_tool(tool, tmp_path / "points.fld", "fcl", bare, *rest)

    return evaluate


@pytest.mark.parametrize("name", UNITS)
def test_every_unit_and_the_controller_read_back(name, run, tmp_path):
    record, folder = design(name), tmp_path / "out"
    FORMATS["fcl"].write(record, folder)
    unit, whole = unit_error(record, folder, "fcl", run), controller_error(record, folder, run)
    allowed = 1e-12 if name.startswith("jee") else 1e-3
    assert max(unit, whole) <= allowed
