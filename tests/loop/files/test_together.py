"""What designs are called side by side, which machine they share, and what is said to differ."""

import json

import pytest

from hfc_design.core.records import UserError
from hfc_design.files.design import design_json
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.files.together import differences, labelled, on_one_machine


def written(path, like="pd-only", changes=None, **parts):
    """A built-in design with other values as a file."""
    data = json.loads(design_json(load_design(like, changes)))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(data | parts))
    return str(path)


def test_axes_of_a_machine_are_told_apart(tmp_path):
    change = {"plant.parameters.gain": 30.0}
    first = load_design("jee-koren-2004-pid")
    other = load_design(written(tmp_path / "o.json", "jee-koren-2004-pid", change))
    scenario = load_scenario("feed-drive-circle", {"plant.parameters": {}})
    shared = on_one_machine({"a": first, "b": other}, scenario)
    (x, y), (before_x, _) = (
        shared.plant.values(),
        on_one_machine({"a": other}, scenario).plant.values(),
    )
    assert x.gain == y.gain == first.plant.parameters.get("gain", 28.3)
    assert before_x.gain == 30.0
    found = list(differences(other, scenario, shared))
    assert found == [
        f"made for another machine: {a}.gain 30.0, here 28.3 (BLU/s)/unit" for a in "xy"
    ]


def test_another_plant_or_sample_time_is_refused(tmp_path):
    scenario = load_scenario("c-axis-ramp")
    with pytest.raises(UserError, match=r"is for the plant feed-drive, scenario c-axis-ramp has"):
        on_one_machine(labelled(["pd-only", "jee-koren-2004-pid"]), scenario)
    slow = written(tmp_path / "slow.json", changes={"controller.sample_time_s": 0.002})
    with pytest.raises(UserError, match=r"runs every 0\.002 s"):
        on_one_machine(labelled(["pd-only", slow]), scenario)
