"""FLL, FCL and FML without the programs that they are for.

JFML and jFuzzyLogic are on none of PyPI, Debian and npm, where make interop installs from. So FML
is read by fml_oracle.py and FCL by fcl_oracle.py of tests/helpers: readers of their own, written
from the standards and from what those two programs accept. Measured, worst of all designs and
relative to the largest output: FML 7e-16 in double precision, 7e-7 in the single precision that
JFML reckons in; FCL of jFuzzyLogic 8e-16; FCL of IEC 61131-7 4e-4 with polygons, 3e-16 with
triangles.
"""

from functools import partial

import numpy as np
import pytest
from fcl_oracle import Block
from fml_oracle import System, read
from wiring import DESIGNS, clamped, controller_error, design, unit_error, units

from hfc_design.formats import FORMATS


def errors(record, target, folder, evaluate):
    FORMATS[target].write(record, folder)
    suffix = target[:3]
    return unit_error(record, folder, suffix, evaluate), controller_error(record, folder, evaluate)


@pytest.mark.parametrize("name", DESIGNS)
@pytest.mark.parametrize(("kind", "allowed"), [(np.float64, 1e-12), (np.float32, 1e-6)])
def test_fml_reads_back(name, kind, allowed, tmp_path):
    record = design(name)
    evaluate = partial(read, partial(System, kind=kind))
    found = errors(record, "fml", tmp_path / "x", evaluate)
    assert max(found) <= allowed


@pytest.mark.parametrize("name", DESIGNS)
@pytest.mark.parametrize(("target", "allowed"), [("fcl", 1e-3), ("fcl-jfuzzylogic", 1e-12)])
def test_fcl_reads_back(name, target, allowed, tmp_path):
    def evaluate(file, row, column, points):
        if target != "fcl":  # a Gaussian has no end; points beyond it clamp by themselves
            unit = next(unit for unit in units(record) if unit.name == file.stem)
            points = clamped(unit, points)
        return Block(file).evaluate(**{row: points[:, 0], column: points[:, 1]})

    record = design(name)
    found = errors(record, target, tmp_path / "x", evaluate)
    assert max(found) <= (1e-12 if name.startswith("jee") else allowed)
