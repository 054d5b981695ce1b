"""FLL, FCL and FML of hierarchies; see tests/published/formats/test_fuzzy_files.py."""

import csv
import json
import re

import numpy as np
import pytest
from exported import texts
from fcl_oracle import Block
from fml_oracle import System
from wiring import silent
from wording import refused

from hfc_design.codegen.st import literal_of
from hfc_design.files.design import Design, design_json, named_design, parse_design
from hfc_design.formats import FORMATS

LANGUAGES = ["fll", "fcl", "fcl-jfuzzylogic", "fml"]


def test_manifest_and_surroundings_of_table_2():
    """Lin & Lee 1999, Table II: four units, five inputs, scales and gains as printed."""
    found = texts(named_design("lin-lee-1999-table-2"), "fll")
    lines = list(csv.reader(found["manifest.csv"].splitlines()))
    assert lines[0] == ["unit", "column_input", "row_input", "file"]
    assert lines[1] == ["unit_3", "error", "previous_spindle_velocity", "unit_3.fll"]
    assert lines[-1] == ["unit_0", "unit_1", "unit_2", "unit_0.fll"]
    about = json.loads(found["controller.json"])
    assert (about["kp"], about["kd"], about["output_scale"]) == (1002.076, 135.007, 10.0)
    assert about["inputs"][-1] == {
        "name": "previous_spindle_velocity",
        "signal": "spindle_velocity",
        "signal_unit": "rad/s",
        "samples_ago": 1,
        "scale": 10.0,
        "lowest": -1.0,
        "highest": 1.0,
    }
    units = {f"unit_{k}.fll" for k in (0, 1, 2, 3)}
    assert found.keys() == units | {"manifest.csv", "controller.json", "controller.m"}


@pytest.mark.parametrize("target", LANGUAGES)
def test_a_controller_without_rules_is_refused(target):
    for name in ("pd-only", "huang-soc", "huang-cross-coupled"):
        with refused() as found:
            texts(named_design(name), target)
        assert found.where.startswith(f"design {name} ")


@pytest.mark.parametrize(
    ("target", "old", "new"),
    [
        ("fll", "f1", "not"),
        ("fcl", "f1", "Term"),
        ("fcl", "f1", "F2"),
        ("fll", "deflection", "unit_3"),
        ("fml", "deflection", "u1_1"),
    ],
)
def test_names_that_a_language_cannot_tell_apart_are_refused(target, old, new):
    text = design_json(named_design("lin-lee-1999-table-1")).replace(f'"{old}"', f'"{new}"')
    with refused() as found:
        texts(parse_design(text, "x.json"), target)
    assert found.where == f"to='{target}'"


def test_a_real_has_a_point_and_reads_back():
    told = ["1.0E-5", "1.0E22", "-2.5E-300", "3.0", "0.1"]
    assert list(map(literal_of, (1e-5, 1e22, -2.5e-300, 3, 0.1))) == told


@pytest.mark.parametrize("target", LANGUAGES[1:])
def test_a_unit_gives_0_where_no_rule_fires(target, tmp_path):
    FORMATS[target].write(silent(1e300), tmp_path / "x")
    (file,) = (tmp_path / "x").glob("unit_7.*")
    at = np.array([0.1, 0.0])
    found = (System if target == "fml" else Block)(file).evaluate(
        previous_spindle_velocity=at, spindle_velocity=at
    )
    assert found.tolist() == [0.0, 0.4853]


def written(design):
    return texts(design, "fis")


def changed(name, change):
    data = named_design(name).model_dump(mode="json")
    change(data["controller"])
    return Design.model_validate(data)


def test_a_unit_of_table_1_is_as_it_would_be_written_by_hand():
    text = written(named_design("lin-lee-1999-table-1"))["unit_3.fis"]
    assert "[Input1]\nName='deflection'\nRange=[-1.0 1.0]\nNumMFs=7\n" in text
    assert "[Input2]\nName='unit_7'\n" in text
    sigma = 1 / 8**0.5  # f1: centre -1, half width 0.1, rate 4
    assert f"MF1='f1':'gauss2mf',[{sigma} -1.1 {sigma} -0.9]" in text
    rows = named_design("lin-lee-1999-table-1").controller.units[1].consequents
    assert f"MF16='u3_2':'constant',[{rows[2][1]}]" in text  # row 3, column 2
    assert "\n3 2, 16 (1) : 1\n" in text
    assert "\n7 7, 49 (1) : 1\n" in text


def test_the_tree_of_matlab_joins_every_unit_to_the_one_that_reads_it():
    files = written(named_design("lin-lee-1999-table-1"))
    wires = re.findall(r'"(.+)/(.+)", "(.+)/(.+)"; \.\.\.', files["controller_tree.m"])
    assert wires == [
        ("unit_7", "unit_7", "unit_3", "unit_7"),
        ("unit_3", "unit_3", "unit_1", "unit_3"),
        ("unit_1", "unit_1", "unit_0", "unit_1"),
    ]
    for source, output, target, entry in wires:
        assert f"[Output1]\nName='{output}'\n" in files[f"{source}.fis"]
        assert re.search(rf"\[Input\d\]\nName='{entry}'\n", files[f"{target}.fis"])
    read = re.findall(r"readfis\(fullfile\(folder, '(\w+)\.fis'\)\)", files["controller_tree.m"])
    assert read == ["unit_7", "unit_3", "unit_1", "unit_0"]


def test_what_is_none_of_matlab_is_refused():
    def narrow(controller):  # which leaves gaps
        for term in controller["terms"]:
            term |= {"half_width": 0.0, "rate": 1e6}

    def renamed(name):
        def rename(controller):
            controller["inputs"][1]["name"] = name
            for unit in controller["units"]:
                for key in ("column_input", "row_input"):
                    unit[key] = name if unit[key] == "deflection" else unit[key]

        return rename

    for change in (narrow, *map(renamed, ("end", "_error", "previous_9"))):
        with refused() as found:
            written(changed("lin-lee-1999-table-1", change))
        assert found.where == "to='fis'"
    with refused():
        written(named_design("pd-only"))  # no rules


def test_no_name_gets_code_into_a_file():
    evil = "x'); system('id\n[System]\n"
    good = named_design("lin-lee-1999-table-1")
    item = good.controller.inputs[1].model_copy(update={"name": evil})
    controller = good.controller.model_copy(
        update={"inputs": (good.controller.inputs[0], item, *good.controller.inputs[2:])}
    )
    with refused():
        written(good.model_copy(update={"controller": controller}))
    files = written(good.model_copy(update={"name": evil}))
    for name in files.keys() - {"controller.json"}:  # data; there it is a quoted string
        text = files[name]
        assert "system('id" not in text
        assert text.count("\n[System]") <= 1
