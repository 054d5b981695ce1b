"""What designs are called side by side, which machine they share, and what is said to differ."""

from design_files import written
from wording import refused

from hfc_design.files.design_set import differences, labelled, shared_machine
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario


def test_axes_of_a_machine_are_told_apart(tmp_path):
    change = {"plant.parameters.gain": 30.0}
    first = load_design("jee-koren-2004-pid")
    other = load_design(written(tmp_path / "o.json", "jee-koren-2004-pid", change))
    scenario = load_scenario("feed-drive-circle", {"plant.parameters": {}})
    shared = shared_machine({"a": first, "b": other}, scenario)
    (x, y), (before_x, _) = (
        shared.plant.values(),
        shared_machine({"a": other}, scenario).plant.values(),
    )
    assert x.gain == y.gain == first.plant.parameters.get("gain", 28.3)
    assert before_x.gain == 30.0
    found = list(differences(other, scenario, shared))
    assert found == [
        f"made for another machine: {a}.gain 30.0, here 28.3 (BLU/s)/unit" for a in "xy"
    ]


def test_another_plant_or_sample_time_is_refused(tmp_path):
    scenario = load_scenario("c-axis-ramp")
    with refused():
        shared_machine(labelled(["pd-only", "jee-koren-2004-pid"]), scenario)
    slow = written(tmp_path / "slow.json", changes={"controller.sample_time_s": 0.002})
    with refused():
        shared_machine(labelled(["pd-only", slow]), scenario)
