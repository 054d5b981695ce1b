"""What is looked for, and what somebody knows."""

from types import SimpleNamespace

import numpy as np
import pytest

from hfc_design.identify.request import looked_for, task_of
from hfc_design.identify.scenario import _linear, motions_like


def wanted(plant, changes, free=None):
    return looked_for(task_of(plant, None, changes, None, None, free, None, 0))


def test_a_load_is_looked_for_where_no_parameter_is_one():
    assert "load" in wanted("milling-table", ()).names
    assert "load" not in wanted("positioning-stage", ()).names
    assert "load" in wanted("positioning-stage", (), ["mass", "load"]).names


def test_what_is_set_is_known_and_listed():
    changes = {"plant.parameters.torque_gain": 2.5, "load.constant": 530, "limits.lag_s": 0.0005}
    found = wanted("milling-table", changes | {"plant.parameters.lead": 10.0})
    assert not {"torque_gain", "load", "lead"} & {*found.names}
    assert found.sought.tolist() == [1.0, 0.0]
    for told in ("load 530 N", "torque_gain 2.5 N m/V", "lead 10 mm/rev"):
        assert told in found.rest()
    assert "table_mass 100 kg" in found.wanted()
    assert "lag_s known to be" in found.wanted()


def test_a_start_is_said_beside_the_name():
    found = wanted("milling-table", (), ["table_mass=180", "load=20"])
    assert found.starts["table_mass"] == 180.0
    assert found.values(found.begun) == pytest.approx([180.0, 20.0])


@pytest.mark.parametrize(("error", "height"), [(0.002, 0.1), (1.0, 3.0)])
def test_the_scale_tells_a_step_that_is_made(error, height):
    """Three times the error of the log's loop, and a hundred steps of the scale at least."""
    told = SimpleNamespace(place=np.array([0.0, 10.0]), step=0.001)
    found = motions_like(told, speed=5.0, acceleration=50.0, duration=3.0, error=error)
    assert found[-1]["reference"] == {"kind": "step", "height": height}


@pytest.mark.parametrize(
    ("feedback", "logged", "read"),
    [
        ("position", ["position"], {}),  # a motor has an encoder of its own
        ("motor_position", ["motor_position", "position"], {}),
        ("motor_position", ["motor_position"], {"signals": []}),
        ("motor_position", ["motor_position", "motor_velocity"], {"signals": []}),
    ],
)
def test_a_law_reads_no_scale_that_no_log_shows(feedback, logged, read):
    own = task_of("milling-table", None, {"sensors.feedback": feedback}, None, None, None, None, 0)
    told = SimpleNamespace(outputs=dict.fromkeys(logged))
    assert _linear(*own.scenario.machine.drives, told) == read


def test_beside_a_rotor_alone_a_law_reads_its_current():
    changes = {"sensors.feedback": "rotor_angle"}
    own = task_of("c-axis", None, changes, None, None, None, None, 0)
    told = SimpleNamespace(outputs={"rotor_angle": None})
    assert _linear(*own.scenario.machine.drives, told) == {"signals": ["current"]}
