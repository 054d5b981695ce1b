"""What is called stable: known limit cycles are not, forced vibration is; the rule by hand."""

import pytest
from settled import of_nominal

from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario

SHORT = ["simulation.duration_s=3"]


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
