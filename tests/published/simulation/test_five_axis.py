"""Five axes through a program in the closed loop: published programs."""

import numpy as np
import pytest
from five_axes import five_axes

import hfc_design.api as hfc
from hfc_design.files.loop_setup import load_design

PID = "lin-gai-2009-pid"


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


def test_following_errors_are_those_of_the_gain(tmp_path):
    """At constant speed (v + what friction and damping cost) / 33.33; k_i adds less than 1 %."""
    found = hfc.evaluate("lin-gai-2009-pid", five_axes(tmp_path, "G1 X50 Y20 A40 F3600"))
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


def test_gravity_and_unbalance_are_felt_where_axes_are_coupled():
    """Z sags by no more than 30 kg over 7e4 N s/m over 33.33 1/s, and what friction adds."""
    alone = load_design(PID)
    together = load_design(PID, {"plant.name": "five-axis-coupled"})
    where = hfc.load_scenario("five-axis-program", {"plant.name": "five-axis-coupled"})
    free = hfc.evaluate(alone, "five-axis-program").axes[2].motion.error
    found = hfc.evaluate(together, where).axes[2].motion.error
    sag = 1e3 * 30 * 9.81 / 7e4 / 33.33
    assert found[40:300] - free[40:300] == pytest.approx(sag, rel=0.2)


def test_a_population_does_what_one_machine_does():
    """In float32, and by the fitness of the contour, of which the tables' orientation is a part."""
    found = hfc.evaluate(PID, "five-axis-program")
    spread = hfc.robustness(PID, "five-axis-program", spread=0.3, samples=12)
    assert spread.stable.all()
    assert spread.nominal["rms_contour_error_mm"] == found.metrics["rms_contour_error_mm"]
    values = spread.values["rms_contour_error_mm"]
    assert (
        0.5
        < values.min() / found.metrics["rms_contour_error_mm"]
        < 1.0
        < values.max() / values.min()
    )


def test_an_x_y_machine_may_have_limits_of_each_axis():
    """The same program, a little slower or faster; and its contour by either way of measuring."""
    known = {"simulation.duration_s": 40.0}
    axes = "{acceleration_per_s2 = 100.0, velocity_per_min = 3000}"
    limits = [f"reference.limits.{axis}={axes}" for axis in "xy"]
    file = str(hfc.load_scenario("feed-drive-contour").reference.file)
    own = [f"reference={{kind='gcode', file='{file}'}}", *limits, "simulation.duration_s=40.0"]
    found = hfc.evaluate("jee-koren-2004-pid", hfc.load_scenario("feed-drive-contour", own))
    before = hfc.evaluate("jee-koren-2004-pid", hfc.load_scenario("feed-drive-contour", known))
    ratio = found.metrics["rms_contour_error_BLU"] / before.metrics["rms_contour_error_BLU"]
    assert 0.5 < ratio < 2.0
