"""Sensors and limits: observers, converters, what is not allowed."""

import numpy as np
import pytest
from sensed import scenario
from wording import refused_command

import hfc_design.api as hfc
from hfc_design.files.design import Limits, design_json
from hfc_design.files.machine import measured_apart
from hfc_design.simulation.sensors import largest_command, observer_gains
from plants import C_AXIS, FEED_DRIVE

PERIOD = 1e-3


def test_observer_has_two_equal_poles():
    for bandwidth in (1.0, 30.0, 400.0):
        alpha, beta = observer_gains(bandwidth, PERIOD)
        poles = np.roots([1.0, alpha + beta - 2.0, 1.0 - alpha])
        assert poles == pytest.approx(np.exp(-2 * np.pi * bandwidth * PERIOD), abs=1e-6)


def test_largest_command_is_a_whole_number_of_steps():
    for command, resolution, wanted in (
        (120.0, 0.06, 120.0),
        (10.0, 0.6, 9.6),
        (1e300, 1e-20, 1e300),
    ):
        limits = Limits(command=command, resolution=resolution)
        assert largest_command(limits) == pytest.approx(wanted, rel=1e-15)
    assert largest_command(Limits(resolution=2.0)) is None


def test_signals_that_no_encoder_forms():
    assert measured_apart(C_AXIS) == ["current"]
    assert measured_apart(FEED_DRIVE) == []


def test_a_design_file_says_no_more_of_its_limits_than_it_has_to():
    assert Limits(command=5.0).model_dump() == {"command": 5.0}
    found = scenario("limits.resolution=0.5", "limits.delay_samples=1")
    text = design_json(hfc.with_gains(found, "pd", {"kp": 1.0, "kd": 1.0}))
    assert '"resolution": 0.5' in text
    plain = design_json(hfc.with_gains(scenario(), "pd", {"kp": 1.0, "kd": 1.0}))
    assert 'resolution"' not in plain.split('"provenance"')[0]
    assert "delay_samples" not in plain


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ("sensors.velocity='observer'", "sensors.observer_hz"),
        ("sensors.difference_samples=2", "sensors.difference_samples"),
        ("sensors.readings.deflection.noise=1", "sensors.readings.deflection"),
        ("sensors.readings.mood.noise=1", "sensors.readings.mood"),
        ("sensors.readings.current.noise=-1", "sensors.readings.current.noise"),
        ("limits={command=1,resolution=2}", "limits.resolution"),
    ],
)
def test_sensors_and_limits_that_are_not_allowed(change, where, tmp_path):
    found = refused_command("design", "c-axis-ramp", "--out", tmp_path / "run", "--set", change)
    assert found.startswith(f"hfc: c-axis-ramp: {where}")
    assert found.count("\n") == 1
