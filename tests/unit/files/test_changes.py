"""A number in a dotted key names an entry of a list, in a design and in a scenario."""

import json

import pytest
from wording import refused, refused_command

from hfc_design import api as hfc
from hfc_design.core.overrides import flat
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


def test_labels_that_are_changed_too_are_not_lost():
    told = ["controller.rules.centroids.3.3=20", "controller.rules.labels.3.3=NL"]
    with refused():
        hfc.load_design("jee-koren-2004-flc", told)


@pytest.mark.parametrize(
    "change",
    [
        "controller.units.0.consequents.7.4=1",
        "controller.units.-1.id=1",
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
