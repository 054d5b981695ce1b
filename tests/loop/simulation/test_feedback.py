"""Another encoder than the drive's own is fed back: what the control is told, and what is true."""

import numpy as np
import pytest
from wording import refused

import hfc_design.api as hfc


def by_error(axis, field):
    step = {"position": 0.005, "motor_position": 0.00125}[field]
    return axis.reference - step * np.round(getattr(axis.motion.state, field) / step)


def by_hand(axis, field):
    """Commands of the PID that sees a state field in steps of 5 or 1.25 um."""
    errors = by_error(axis, field)
    rate = np.diff(errors, prepend=0.0) / 0.005
    return 28.0 * errors + 85.0 * 0.005 * np.cumsum(errors) + 0.1 * rate


def test_each_axis_is_told_of_the_encoder_that_is_named():
    changes = {"simulation.duration_s": 2.5, "sensors.axes.y.feedback": "motor_position"}
    found = hfc.evaluate("huang-pid", hfc.load_scenario("milling-table-circle", changes))
    own = dict(zip(("position", "motor_position"), found.axes, strict=True))
    for field, axis in own.items():
        np.testing.assert_allclose(axis.motion.command, by_hand(axis, field), atol=1e-9)
        np.testing.assert_allclose(axis.sensed()["error"], by_error(axis, field), atol=1e-12)
        # What is judged is where the table is, whoever knows it.
        true = axis.happens.target - axis.motion.state.position
        np.testing.assert_allclose(axis.motion.error, true, atol=1e-12)
    # The contour error is the distance from the centre less the radius, of the tables and as the
    # control knows it.
    for key, seen in (("", ("position",) * 2), ("known_", own)):
        x, y = (getattr(a.motion.state, f) for a, f in zip(found.axes, seen, strict=True))
        off = np.hypot(x + 60.0, y) - 60.0
        assert found.metrics[f"{key}max_contour_error_mm"] == pytest.approx(np.abs(off).max())
        rms = np.sqrt(np.mean(off**2))
        assert found.metrics[f"{key}rms_contour_error_mm"] == pytest.approx(rms)
    known = found.metrics["known_rms_contour_error_mm"]
    assert found.metrics["rms_contour_error_mm"] != pytest.approx(known, rel=0.1)


@pytest.mark.parametrize(
    ("scenario", "encoder"), [("milling-table-circle", "velocity"), ("c-axis-ramp", "current")]
)
def test_an_unknown_encoder_is_one_line(scenario, encoder):
    with refused() as found:
        hfc.load_scenario(scenario, {"sensors.feedback": encoder})
    assert found.refusal.startswith(f"{scenario}: sensors.feedback = ")
