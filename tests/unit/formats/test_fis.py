"""The FIS export without a program that reads it; with Octave: tests/interop/test_fis.py."""

import re

import pytest

from hfc_design.core.records import UserError
from hfc_design.files.design import Design, named_design
from hfc_design.formats import FORMATS


@pytest.fixture
def written(tmp_path):
    def write(design):
        FORMATS["fis"].write(design, tmp_path / "out")
        return {file.name: file.read_text() for file in (tmp_path / "out").iterdir()}

    return write


def changed(name, change):
    data = named_design(name).model_dump(mode="json")
    change(data["controller"])
    return Design.model_validate(data)


def test_a_unit_of_table_1_is_as_it_would_be_written_by_hand(written):
    text = written(named_design("lin-lee-1999-table-1"))["unit_3.fis"]
    assert "[Input1]\nName='deflection'\nRange=[-1.0 1.0]\nNumMFs=7\n" in text
    assert "[Input2]\nName='unit_7'\n" in text
    sigma = 1 / 8**0.5  # f1: centre -1, half width 0.1, rate 4
    assert f"MF1='f1':'gauss2mf',[{sigma} -1.1 {sigma} -0.9]" in text
    rows = named_design("lin-lee-1999-table-1").controller.units[1].consequents
    assert f"MF16='u3_2':'constant',[{rows[2][1]}]" in text  # row 3, column 2
    assert "\n3 2, 16 (1) : 1\n" in text
    assert "\n7 7, 49 (1) : 1\n" in text


def test_the_tree_of_matlab_joins_every_unit_to_the_one_that_reads_it(written):
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


def test_the_same_design_gives_the_same_bytes(tmp_path):
    for folder in ("a", "b"):
        FORMATS["fis"].write(named_design("lin-lee-1999-table-2"), tmp_path / folder)
    for file in (tmp_path / "a").iterdir():
        assert file.read_bytes() == (tmp_path / "b" / file.name).read_bytes()


def test_terms_with_gaps_are_refused(written):
    def narrow(controller):
        for term in controller["terms"]:
            term |= {"half_width": 0.0, "rate": 1e6}

    with pytest.raises(UserError, match="to='fis': the terms of unit_7 leave gaps"):
        written(changed("lin-lee-1999-table-1", narrow))


@pytest.mark.parametrize("name", ["pd-only", "jee-koren-2004-pid"])
def test_a_design_without_rules_is_refused(written, name):
    with pytest.raises(UserError, match="no rule tables"):
        written(named_design(name))


@pytest.mark.parametrize("name", ["end", "_error", "previous_9"])
def test_a_name_that_is_none_of_matlab_is_refused(written, name):
    def rename(controller):
        controller["inputs"][1]["name"] = name
        for unit in controller["units"]:
            for key in ("column_input", "row_input"):
                unit[key] = name if unit[key] == "deflection" else unit[key]

    with pytest.raises(UserError, match="to='fis': "):
        written(changed("lin-lee-1999-table-1", rename))


def test_no_name_gets_code_into_a_file(written):
    evil = "x'); system('id\n[System]\n"
    good = named_design("lin-lee-1999-table-1")
    item = good.controller.inputs[1].model_copy(update={"name": evil})
    controller = good.controller.model_copy(
        update={"inputs": (good.controller.inputs[0], item, *good.controller.inputs[2:])}
    )
    with pytest.raises(UserError):
        written(good.model_copy(update={"controller": controller}))
    files = written(good.model_copy(update={"name": evil}))
    for name in files.keys() - {"controller.json"}:  # data; there it is a quoted string
        text = files[name]
        assert "system('id" not in text
        assert text.count("\n[System]") <= 1
