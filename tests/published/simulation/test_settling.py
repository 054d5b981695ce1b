"""What is called stable: known limit cycles are not, forced vibration is; the rule by hand."""

import pytest
from settled import of_nominal

from hfc_design.files.design import Design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.comparison import compare
from hfc_design.simulation.monte_carlo import robustness


@pytest.mark.parametrize(
    ("design", "name"),
    [
        ("lin-lee-1999-table-2", "c-axis-ramp-cutting"),
        ("pd-only", "c-axis-ramp"),
    ],
)
def test_the_same_machines_are_stable_in_48_substeps(design, name):
    """What is called stable is the loop's and not the step's: one of 100 may be at the border."""
    own, fine = (
        robustness(design, load_scenario(name, ["simulation.duration_s=2", *steps]), 0.2, 100)
        for steps in ([], ["simulation.substeps=48"])
    )
    assert 0 < own.stable.sum() < 100  # there is something to tell apart
    assert (own.stable != fine.stable).sum() <= 1


def test_a_comparison_says_why_a_design_is_not_stable():
    """Of a gain half as large again, which oscillates."""
    sharp = ["controller.pd.kp=1137", "controller.pd.kd=1114.5"]
    designs = {"calm": load_design("pd-only"), "sharp": load_design("pd-only", sharp)}
    scenario = load_scenario("c-axis-ramp", ["simulation.duration_s=3", "limits.command=60"])
    found = compare(designs, scenario, spread=0.01, machines=3)
    (note,) = [line for line in found.notes if "stable" in line]
    told = "nominal machine oscillates; of 3 others 3 oscillate, 3 are far off"
    assert note == f"sharp in c-axis-ramp, not stable: {told}"
    alone = robustness(designs["sharp"], scenario, 0.01, 3)
    assert alone.numbers()["reasons"] == {"oscillates": 3, "is far off": 3}
    assert alone.numbers()["nominal_reasons"] == ["oscillates"]


def test_integral_action_that_hunts_within_friction_is_not_stable():
    """A slow ramp: its rotor winds up the spring until the spindle breaks away."""
    record = load_design("pd-only").model_dump(mode="json")
    pid = {"kind": "pid+ff", "sample_time_s": 0.001, "kp": 700.0, "kd": 743.0}
    slow = load_scenario("c-axis-ramp", ["reference.velocity=0.002", "simulation.duration_s=10"])
    late = []
    for integral in (0.0, 300.0):
        record["controller"] = pid | {"ki": integral}
        measured, stable = of_nominal(Design.model_validate(record), slow)
        assert stable == (integral == 0.0)
        assert (measured["unsettled"] > 1.0) == (integral > 0.0)
        late.append(measured["late_error"])
    assert late[1] < 0.2 * late[0]  # the error alone would call it the better one
