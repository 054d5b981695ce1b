"""What of a log stands in the scenario that is made of it."""

from types import SimpleNamespace

import numpy as np
import pytest
from carts import EVERY, recorded

from hfc_design.identify.request import task_of
from hfc_design.identify.scenario import differences, linear_part, motions_like

PLACE = 1e-6 * np.round(2e4 * np.sin(0.02 * np.arange(2000)))


@pytest.mark.parametrize("samples", [1, 4, 16])
def test_a_velocity_is_a_difference_over_samples(samples):
    """By the control, which prints six digits; one that is measured apart is none."""
    told = recorded(PLACE, PLACE)
    rate = np.zeros(len(PLACE))
    rate[samples:] = (PLACE[samples:] - PLACE[:-samples]) / (samples * EVERY)
    with_rate = told._replace(outputs=told.outputs | {"velocity": np.round(rate, 6)})
    expected = {"difference_samples": samples} if samples > 1 else {}
    assert differences(with_rate, "velocity") == expected
    assert differences(told, "velocity") == {}
    smooth = 0.4 * np.cos(0.02 * np.arange(2000))
    assert differences(told._replace(outputs={"velocity": smooth} | told.outputs), "velocity") == {}


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
    assert linear_part(*own.scenario.machine.drives, told) == read
