"""FLL, FCL and FML without the programs that they are for.

JFML and jFuzzyLogic are on none of PyPI, Debian and npm, where make interop installs from. So FML
is read by fml_oracle.py and FCL by fcl_oracle.py of tests/helpers: readers of their own, written
from the standards and from what those two programs accept. Measured, worst of all designs and
relative to the largest output: FML 7e-16 in double precision, 7e-7 in the single precision that
JFML reckons in; FCL of jFuzzyLogic 8e-16; FCL of IEC 61131-7 4e-4 with polygons, 3e-16 with
triangles.
"""

import csv
import json

import numpy as np
import pytest
from fcl_oracle import Block
from fml_oracle import System
from wiring import (
    design,
    silent,
)

from hfc_design.core.records import UserError
from hfc_design.files.design import design_json, named_design, parse_design
from hfc_design.formats import FORMATS
from hfc_design.formats.fcl import real

LANGUAGES = ["fll", "fcl", "fcl-jfuzzylogic", "fml"]


def written(record, target, folder):
    FORMATS[target].write(record, folder)
    return folder


def test_manifest_and_surroundings_of_table_2(tmp_path):
    """Lin & Lee 1999, Table II: four units, five inputs, scales and gains as printed."""
    folder = written(named_design("lin-lee-1999-table-2"), "fll", tmp_path / "x")
    with (folder / "manifest.csv").open() as file:
        lines = list(csv.reader(file))
    assert lines[0] == ["unit", "column_input", "row_input", "file"]
    assert lines[1] == ["unit_3", "error", "previous_spindle_velocity", "unit_3.fll"]
    assert lines[-1] == ["unit_0", "unit_1", "unit_2", "unit_0.fll"]
    about = json.loads((folder / "controller.json").read_text())
    assert (about["kp"], about["kd"], about["output_scale"]) == (1002.076, 135.007, 10.0)
    assert about["steps"][-1] == "command = kp * error + kd * error_rate + output_scale * unit_0"
    assert about["inputs"][-1] == {
        "name": "previous_spindle_velocity",
        "signal": "spindle_velocity",
        "signal_unit": "rad/s",
        "samples_ago": 1,
        "scale": 10.0,
        "lowest": -1.0,
        "highest": 1.0,
    }
    assert {path.name for path in folder.iterdir()} == {
        "manifest.csv",
        "controller.json",
        *(f"unit_{k}.fll" for k in (0, 1, 2, 3)),
    }


@pytest.mark.parametrize("target", LANGUAGES)
def test_the_same_design_gives_the_same_bytes(target, tmp_path):
    record = design("random-1")
    first, second = (written(record, target, tmp_path / name) for name in "ab")
    files = sorted(path.name for path in first.iterdir())
    assert len(files) == 6
    for name in files:
        assert (first / name).read_bytes() == (second / name).read_bytes()
        assert b"\n\n\n" not in (first / name).read_bytes()


@pytest.mark.parametrize("target", LANGUAGES)
@pytest.mark.parametrize("name", ["jee-koren-2004-pid", "pd-only"])
def test_a_controller_without_rules_is_refused(name, target, tmp_path):
    with pytest.raises(UserError, match="no rule tables"):
        written(named_design(name), target, tmp_path / "x")
    assert not (tmp_path / "x").exists()


def renamed(old, new):
    text = design_json(named_design("lin-lee-1999-table-1"))
    return parse_design(text.replace(f'"{old}"', f'"{new}"'), "x.json")


@pytest.mark.parametrize(
    ("target", "old", "new", "message"),
    [
        ("fll", "f1", "not", "not is a word of that format"),
        ("fcl", "f1", "Term", "Term is a word of that format"),
        ("fcl-jfuzzylogic", "f1", "gauss2", "gauss2 is a word of that format"),
        ("fcl", "f1", "F2", "two names are f2"),
        ("fcl-jfuzzylogic", "f1", "_f1", "_f1 is no identifier"),
        ("fll", "deflection", "unit_3", "two names are unit_3"),
        ("fml", "deflection", "u1_1", "two things are called u1_1"),
    ],
)
def test_names_that_a_language_cannot_tell_apart_are_refused(target, old, new, message, tmp_path):
    with pytest.raises(UserError, match=message):
        written(renamed(old, new), target, tmp_path / "x")


def test_a_real_has_a_point_and_reads_back():
    assert list(map(real, (1e-5, 1e22, -2.5e-300, 3, 0.1))) == [
        "1.0E-5",
        "1.0E22",
        "-2.5E-300",
        "3.0",
        "0.1",
    ]


@pytest.mark.parametrize("target", LANGUAGES[1:])
@pytest.mark.parametrize("rate", [1e6, 1e300])
def test_a_unit_gives_0_where_no_rule_fires(rate, target, tmp_path):
    folder = written(silent(rate), target, tmp_path / "x")
    (file,) = folder.glob("unit_7.*")
    at = np.array([0.1, 0.0])
    found = (System if target == "fml" else Block)(file).evaluate(
        previous_spindle_velocity=at, spindle_velocity=at
    )
    assert found.tolist() == [0.0, 0.4853]
