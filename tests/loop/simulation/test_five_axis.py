"""Five axes through a program in the closed loop: what PID control does by hand."""

import numpy as np
import pytest
from five_axes import five_axes

import hfc_design.api as hfc


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


def test_a_scenario_spells_out_what_counts_only():
    text = hfc.load_scenario("five-axis-program").model_dump(mode="json")["reference"]
    assert "acceleration_mm_s2" not in text
    assert "limits" not in hfc.load_scenario("feed-drive-contour").model_dump()["reference"]
    assert hfc.load_scenario(hfc.load_scenario("five-axis-blade").model_dump(mode="json"))
