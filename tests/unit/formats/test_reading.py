"""Controllers of other programs, read back as designs."""

import numpy as np
import pytest
from imported_files import CHANGE, GAUSSIAN, TABLE, TEXTS, output, triangles

from hfc_design.files.loop_setup import load_design
from hfc_design.formats.reading import Wish, imported
from hfc_design.runtime import Controller


def controller_of(path, **wish):
    return imported(path, Wish(**wish)).controller


def test_flat_gaussians_are_a_hierarchy_of_one_unit_alone():
    """The pyfuzzylite file's own output at some points is the weighted average by hand."""
    design = imported(GAUSSIAN, Wish())
    unit = design.controller.units[0]
    assert design.controller.pd.kp == design.controller.pd.kd == 0.0
    assert (unit.row_input, unit.column_input) == ("deflection", "error")[::-1]
    terms = load_design("lin-lee-1999-table-1").controller.terms
    numbers = [(t.label, t.centre, t.half_width, t.rate) for t in design.controller.terms]
    for found, term in zip(numbers, terms, strict=True):
        assert found == (term.label, term.centre, term.half_width, pytest.approx(term.rate, 1e-15))
    rows = {"error": [], "deflection": []}
    for name, u in (("error", 0.3), ("deflection", -0.7)):
        distances = [max(abs(u - t.centre) - t.half_width, 0.0) for t in terms]
        rows[name] = [np.exp(-t.rate * d * d) for t, d in zip(terms, distances, strict=True)]
    column = sum(j * d for j, d in enumerate(rows["error"])) / sum(rows["error"])
    row = sum(i * d for i, d in enumerate(rows["deflection"])) / sum(rows["deflection"])
    signals = {"error": 0.3, "error_rate": 9.0, "deflection": -0.7}
    assert Controller(design).step(signals) == pytest.approx(row - column / 2, abs=1e-12)


@pytest.mark.parametrize("suffix", TEXTS)
def test_terms_in_any_order_are_sorted_and_the_table_with_them(tmp_path, suffix):
    file = tmp_path / f"mine.{suffix}"
    file.write_text(TEXTS[suffix])
    found = controller_of(file, signals=CHANGE)
    for terms in (found.error_terms, found.error_change_terms):
        edges = [(t.left, t.centre, t.right) for t in terms]
        assert edges == [row[1:] for row in triangles(range(7))]
    assert [list(row) for row in found.rules.centroids] == TABLE
    # With the signals named the other way round the table is the transposed one.
    other = controller_of(file, signals={"change": "error", "error": "error_change"})
    assert [list(row) for row in zip(*other.rules.centroids, strict=True)] == TABLE


#: (error, change, output) of the texts above in pyfuzzylite 8.0.6; Octave's fuzzy-logic-toolkit
#: 0.4.6 gives the same but for 1e-14, with linzmf and linsmf, which only MATLAB has, as trapmf.
THE_PROGRAMS_SAY = [
    (-4.425, -7.282, -2.7178249257424683),
    (-0.985, -6.168, -26.804041613344157),
    (-8.07, -0.866, 19.169686756311147),
    (10.236, 7.71, -14.39653818159953),
    (6.951, -4.729, -2.9608886974273987),
    (2.039, -3.551, 0.8227702208369054),
    (-5.788, -7.217, -1.05006906668974),
    (-4.89, 10.441, 2.197253485598709),
    (-9.5, 12.0, 23.46720670093304),
    (-6.0, 0.25, -19.279320662762114),
    (1.7, -0.9, 11.154143876630698),
]


@pytest.mark.parametrize("suffix", TEXTS)
def test_the_design_computes_what_the_real_programs_do(tmp_path, suffix):
    file = tmp_path / f"mine.{suffix}"
    file.write_text(TEXTS[suffix])
    runtime = Controller(imported(file, Wish(signals=CHANGE)))
    for error, change, wanted in THE_PROGRAMS_SAY:
        assert output(runtime, error, change) == pytest.approx(wanted, abs=1e-12)
