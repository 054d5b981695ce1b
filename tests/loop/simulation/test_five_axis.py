"""Five axes through a program in the closed loop: what PID control does by hand, and bad input."""

import numpy as np
import pytest

import hfc_design.api as hfc

PID = "lin-gai-2009-pid"


@pytest.fixture
def scenario(tmp_path):
    """Made of a program, on five axes that start at 0."""

    def made(text, *changes, name="part.ngc"):
        (tmp_path / name).write_text(text)
        reference = {"kind": "gcode", "file": str(tmp_path / name)}
        limits = {axis: {"acceleration_per_s2": 800.0} for axis in "xyzac"}
        data = {
            "plant": {"name": "five-axis"},
            "reference": reference | {"limits": limits},
            "simulation": {"duration_s": 1.0, "sample_time_s": 0.002},
            "limits": {"command": 8.0},
            "controller": {"kind": "pid"},
        }
        return hfc.load_scenario(data, list(changes))

    return made


def test_following_errors_are_those_of_the_gain(scenario):
    """At constant speed (v + what friction and damping cost) / 33.33; k_i adds less than 1 %."""
    found = hfc.evaluate(PID, scenario("G1 X50 Y20 A40 F3600"))
    at = np.searchsorted(found.time, 0.7)
    share = 60.0 / np.hypot(50.0, 20.0)
    for k, rate in ((0, 50 * share), (1, 20 * share), (3, 40 * share)):
        axis = found.axes[k]
        p, unit = axis.parameters, np.pi / 180.0 if k == 3 else 1e-3
        lost = (p.coulomb_friction + p.viscous_friction * rate * unit) / p.amplifier_gain / unit
        assert axis.happens.reference_rate[at] == pytest.approx(rate)
        assert axis.motion.error[at] == pytest.approx((rate + lost) / 33.33, rel=0.01)
    # with equal gains the errors lie along the path, but for what friction costs each axis
    assert found.metrics["max_contour_error_mm"] < 0.06
    assert found.metrics["x_max_error_mm"] > 1.6


def test_the_published_program_at_rest_limits_and_ends():
    found = hfc.evaluate(PID, "five-axis-program")
    for axis, (start, end) in {"x": (-1.0, -0.648), "z": (-150.0, -171.732)}.items():
        own = found.axes["xyzac".index(axis)]
        assert own.motion.state.position[0] == start
        assert own.reference[-1] == pytest.approx(end)
        assert own.motion.state.position[-1] == pytest.approx(end, abs=0.08)
    for axis in "xyzac":
        unit = "deg" if axis in "ac" else "mm"
        assert found.metrics[f"{axis}_overshoot_{unit}"] == 0.0
    assert found.metrics["limit_share"] == 0.0
    assert found.metrics["velocity_share"] < 1.0
    header = hfc.trajectory_csv(found).split("\n")[0]
    assert "z_voltage_V,a_reference_deg,a_position_deg,a_error_deg" in header
    printed = hfc.evaluate(PID, "five-axis-program-printed")
    assert printed.metrics["c_max_error_deg"] > 3 * found.metrics["c_max_error_deg"]


def test_a_scenario_spells_out_what_counts_only():
    text = hfc.load_scenario("five-axis-program").model_dump(mode="json")["reference"]
    assert "acceleration_mm_s2" not in text
    assert "limits" not in hfc.load_scenario("feed-drive-contour").model_dump()["reference"]
    assert hfc.load_scenario(hfc.load_scenario("five-axis-blade").model_dump(mode="json"))
