"""What is called stable: known limit cycles are not, forced vibration is; the rule by hand."""

import numpy as np
import pytest

from hfc_design.files.design import Design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import controller_of, load_design, with_converter
from hfc_design.simulation import population
from hfc_design.simulation.closed_loop import closed_loop
from hfc_design.simulation.settling import STABILITY, faults, measuring

SHORT = ["simulation.duration_s=3"]


def of_nominal(design, scenario):
    """Of the nominal machine ``STABILITY`` and whether it is stable, in float64."""
    scenario = with_converter(scenario, design)
    controller, gains = controller_of(design, scenario)
    loop = measuring(closed_loop(scenario, controller))
    machines = population.one_machine(scenario.plant.values())
    judged = population.scores(loop, machines, [scenario.samples()], gains, np.float64)
    stable = ~np.logical_or.reduce(
        [*faults(judged.values[0], judged.failed[0], [scenario]).values()]
    )
    names = [one.name for one in STABILITY]
    return dict(zip(names, judged.values[0, 0, 0, -3:], strict=True)), bool(stable[0, 0])


def pd_only(gain):
    return load_design(
        "pd-only", [f"controller.pd.kp={758 * gain}", f"controller.pd.kd={743 * gain}"]
    )


@pytest.mark.parametrize("name", ["c-axis-ramp", "c-axis-ramp-cutting"])
def test_a_loop_beyond_the_limit_of_its_gain_is_not_stable_and_forced_vibration_is(name):
    scenario = load_scenario(name, [*SHORT, "limits.command=60"])
    measured, stable = of_nominal(pd_only(1.0), scenario)
    assert stable
    assert measured["unsettled"] < 0.03
    swinging, swings = of_nominal(pd_only(1.5), scenario)  # in hand, below its limit, tracking
    assert not swings
    assert swinging["unsettled"] > 0.3
    assert swinging["limit_share"] == 0.0
    assert swinging["late_error"] < measured["late_error"]
    between, swings = of_nominal(pd_only(2.0), scenario)
    assert not swings
    assert between["limit_share"] > 0.1


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
