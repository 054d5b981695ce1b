"""MAT files read by Octave, which evaluates a hierarchy from what it finds there."""

import numpy as np
import pytest
from wiring import UNITS, design, units

from hfc_design.formats import FORMATS

HIERARCHIES = [name for name in UNITS if hasattr(design(name).controller, "inputs")]


@pytest.mark.parametrize("name", HIERARCHIES)
def test_octave_evaluates_a_hierarchy_from_the_file(name, octave, tmp_path):
    record = design(name)
    FORMATS["mat"].write(record, tmp_path / "design.mat")
    inputs = [item.name for item in record.controller.inputs]
    points = np.random.default_rng(2).uniform(-1.0, 1.0, (2000, len(inputs)))
    corners = np.array(np.meshgrid(*[[-1.0, 0.0, 1.0]] * len(inputs))).reshape(len(inputs), -1).T
    points = np.concatenate([points, corners])
    np.savetxt(tmp_path / "points", points, fmt="%.17g")
    found = octave("evaluate_mat.m", tmp_path / "design.mat", tmp_path / "points", tmp_path / "out")
    for point, outputs in zip(points, found, strict=True):
        values = dict(zip(inputs, point, strict=True))
        for unit, output in zip(units(record), outputs, strict=True):
            values[unit.name] = unit.expected(values[unit.row], values[unit.column])
            assert abs(output - values[unit.name]) <= 1e-12


@pytest.mark.parametrize("name", ["jee-koren-2004-flc", "jee-koren-2004-aflc"])
def test_octave_reads_terms_and_rules(name, octave, tmp_path):
    record = design(name)
    FORMATS["mat"].write(record, tmp_path / "design.mat")
    found = octave("evaluate_mat_feed.m", tmp_path / "design.mat", tmp_path / "out")
    terms = [*record.controller.error_terms, *record.controller.error_change_terms]
    left, centre, right = found
    assert centre.tolist() == [term.centre for term in terms]
    assert left.tolist() == [-np.inf if term.left is None else term.left for term in terms]
    assert right.tolist() == [np.inf if term.right is None else term.right for term in terms]
