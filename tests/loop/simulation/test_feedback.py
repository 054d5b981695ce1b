"""Another encoder than the drive's own is fed back: what the control is told, and what is true."""

import numpy as np
import pytest

import hfc_design.api as hfc

PID = hfc.load_design("huang-pid")
SHORT = "milling-table-circle", {"simulation.duration_s": 4.0}


def evaluated(feedback):
    name, changes = SHORT
    return hfc.evaluate(PID, hfc.load_scenario(name, changes | feedback))


def by_hand(axis, field):
    """Commands of the PID that sees a state field in steps of 5 or 1.25 um."""
    step = {"position": 0.005, "motor_position": 0.00125}[field]
    seen = step * np.round(getattr(axis.motion.state, field) / step)
    errors = axis.reference - seen
    rate = np.diff(errors, prepend=0.0) / 0.005
    return 28.0 * errors + 85.0 * 0.005 * np.cumsum(errors) + 0.1 * rate


def test_an_axis_may_have_its_own():
    found = evaluated({"sensors.axes.y.feedback": "motor_position"})
    for axis, field in zip(found.axes, ("position", "motor_position"), strict=True):
        np.testing.assert_allclose(axis.motion.command, by_hand(axis, field), atol=1e-9)


def test_the_contour_error_is_told_as_it_is_and_as_the_control_knows_it():
    """The distance from the centre less the radius, of the tables and of the motors."""
    found = evaluated({"sensors.feedback": "motor_position"})
    for key, field in (("", "position"), ("known_", "motor_position")):
        x, y = (getattr(axis.motion.state, field) for axis in found.axes)
        off = np.hypot(x + 60.0, y) - 60.0
        assert found.metrics[f"{key}max_contour_error_mm"] == pytest.approx(np.abs(off).max())
        rms = np.sqrt(np.mean(off**2))
        assert found.metrics[f"{key}rms_contour_error_mm"] == pytest.approx(rms)
    assert found.metrics["rms_contour_error_mm"] > 2 * found.metrics["known_rms_contour_error_mm"]
    assert not any(key.startswith("known") for key in evaluated({}).metrics)
