"""Another encoder than the drive's own is fed back: what the control is told, and what is true."""

import pytest

import hfc_design.api as hfc
from hfc_design.core.records import UserError

PID = hfc.load_design("huang-pid")
SHORT = "milling-table-circle", {"simulation.duration_s": 4.0}


def evaluated(feedback):
    name, changes = SHORT
    return hfc.evaluate(PID, hfc.load_scenario(name, changes | feedback))


def test_an_unknown_encoder_is_one_line():
    told = "sensors.feedback = 'velocity': is no encoder of the milling-table; it has position, "
    with pytest.raises(UserError, match=f"{told}motor_position"):
        evaluated({"sensors.feedback": "velocity"})
    with pytest.raises(UserError, match="is no encoder of the c-axis; it has "):
        hfc.load_scenario("c-axis-ramp", {"sensors.feedback": "current"})
