"""The FIS export without a program that reads it; with Octave: tests/interop/test_fis.py."""

import re

from exported import texts
from wording import refused

from hfc_design.files.design import Design, named_design


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
