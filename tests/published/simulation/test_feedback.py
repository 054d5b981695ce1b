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


@pytest.mark.parametrize("field", ["position", "motor_position"])
def test_the_control_is_told_of_the_encoder_that_is_named(field):
    found = evaluated({"sensors.feedback": field})
    for axis in found.axes:
        np.testing.assert_allclose(axis.motion.command, by_hand(axis, field), atol=1e-9)
        np.testing.assert_allclose(axis.told()["error"], by_error(axis, field), atol=1e-12)
        # What is judged is where the table is, whoever knows it.
        true = axis.happens.target - axis.motion.state.position
        np.testing.assert_allclose(axis.motion.error, true, atol=1e-12)


def by_error(axis, field):
    step = {"position": 0.005, "motor_position": 0.00125}[field]
    return axis.reference - step * np.round(getattr(axis.motion.state, field) / step)
