"""What designs are called side by side, which machine they share, and what is said to differ."""

from design_files import written
from wording import refused

from hfc_design.files.design_set import labelled, shared_machine
from hfc_design.files.named_scenario import load_scenario


def test_another_plant_or_sample_time_is_refused(tmp_path):
    scenario = load_scenario("c-axis-ramp")
    with refused():
        shared_machine(labelled(["pd-only", "jee-koren-2004-pid"]), scenario)
    slow = written(tmp_path / "slow.json", changes={"controller.sample_time_s": 0.002})
    with refused():
        shared_machine(labelled(["pd-only", slow]), scenario)
