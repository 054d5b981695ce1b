"""A number in a dotted key names an entry of a list, in a design and in a scenario."""

import json

import pytest
from wording import refused, refused_command

from hfc_design import api as hfc
from hfc_design.core.overrides import flat, overridden
from hfc_design.files.design import BUILTIN, parse_design


def edited(name, edit):
    """The built-in design as somebody would change it in an editor."""
    data = json.loads((BUILTIN / f"{name}.json").read_text())
    edit(data["controller"])
    return parse_design(json.dumps(data), name).controller


def test_a_rule_of_a_hierarchy():
    def edit(controller):
        controller["units"][0]["consequents"][3][4] = -1.5

    found = hfc.load_design(
        "lin-lee-1999-table-1", ["controller.units.0.consequents.3.4=-1.5"]
    ).controller
    assert found == edited("lin-lee-1999-table-1", edit)
    assert found != hfc.load_design("lin-lee-1999-table-1").controller


def test_a_whole_row():
    row = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]

    def edit(controller):
        controller["units"][2]["consequents"][6] = row

    key = "controller.units.2.consequents.6"
    for change in ({key: row}, {key: tuple(row)}, [f"{key}={row}"]):
        assert hfc.load_design("lin-lee-1999-table-1", change).controller == edited(
            "lin-lee-1999-table-1", edit
        )


def test_labels_that_are_changed_too_are_not_lost():
    told = ["controller.rules.centroids.3.3=20", "controller.rules.labels.3.3=NL"]
    with refused():
        hfc.load_design("jee-koren-2004-flc", told)


def test_a_list_of_a_scenario():
    wave = {"amplitude": 20.0, "frequency_rad_s": 5.0}
    ramp = {"kind": "ramp", "velocity": 0.02}
    told = {"name": "own", "reference": ramp, "load": {"sines": [wave]}}
    found = hfc.load_scenario(told, ["load.sines.0.amplitude=33"])
    assert [(sine.amplitude, sine.frequency_rad_s) for sine in found.load.sines] == [(33.0, 5.0)]


def test_a_tuple_of_a_script():
    assert overridden({"a": ({"b": (1, 2)}, 3)}, {"a.0.b.1": 7}) == {"a": [{"b": [1, 7]}, 3]}


@pytest.mark.parametrize(
    "change",
    [
        "controller.units.0.consequents.7.4=1",
        "controller.units.4.id=1",
        "controller.units.-1.id=1",
        "controller.units.first.id=1",
        "controller.units.0.consequents.3.4.0=1",
        "controller.units.0.consequents.3.²=1",
    ],
)
def test_what_names_no_entry(change):
    line = refused_command("score", "lin-lee-1999-table-1", "--change", change)
    assert line.startswith(f"hfc: --change {change}: ")


def test_an_empty_table_of_a_batch_is_a_value():
    told = {"controller": {"kind": "x", "linear": {}}, "run": {"seed": 1}}
    assert flat(told) == {"controller.kind": "x", "controller.linear": {}, "run.seed": 1}
    assert flat({"controller": {}, "run": {"seed": 1}}) == {"run.seed": 1}  # nothing is replaced
