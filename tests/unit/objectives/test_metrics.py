"""Every metric by hand on small motions."""

import numpy as np
import pytest

from hfc_design.motion.phases import settled_samples
from hfc_design.objectives.metric import ALONE, AxisRecord, MotionRecord
from hfc_design.objectives.tables import columns, values
from plants import C_AXIS, Machine


def measured(error, speed=None, commanded=None, error_rate=None, command=None, **options):
    """The metrics of a motion sampled every 0.1 s; what is not given is 0, the command 1."""
    steps = len(error)

    def filled(values, value):
        return np.full(steps, value) if values is None else np.array(values, float)

    time, drive = 0.1 * np.arange(steps), options.get("plant", C_AXIS)
    settled = settled_samples(time, options.get("settled_after", 0.0))
    axis = AxisRecord(
        *("", drive, time, settled),
        reference=np.zeros(steps),
        reference_rate=filled(commanded, 1.0),
        error=np.array(error, float),
        error_rate=filled(error_rate, 0.0),
        velocity=filled(speed, 1.0),
        command=filled(command, 1.0),
        limits=(-np.inf, np.inf),
    )
    return values(columns(Machine("", ("",), (drive,)), ALONE), MotionRecord((axis,), None))


def test_tracking_error():
    found = measured([3.0, -4.0, 0.0, 0.0])
    assert found["rms_error_rad"] == 2.5
    assert found["max_error_rad"] == 4.0
    assert found["iae_rad_s"] == pytest.approx(0.7)  # (3 + 4) rad in samples of 0.1 s
    assert found["final_error_rad"] == 0.0
    assert measured([1.0, -0.25])["final_error_rad"] == -0.25


def test_settling_time_is_when_the_error_last_came_below_a_tenth():
    assert measured([10, 5, 0.5, 2, 0.9, -1.0, 0.1])["settling_time_s"] == pytest.approx(0.4)
    assert measured([10, 0.1, 0.1])["settling_time_s"] == pytest.approx(0.1)


def test_velocity_ripple_counts_once_settled():
    found = measured([1, 1, 1, 1], error_rate=[100, 100, 3, -4], settled_after=0.2)
    assert found["velocity_ripple_rad_s"] == pytest.approx(12.5**0.5)


def test_stick_events_are_counted_at_their_start():
    """Below a tenth of the commanded 0.02: samples 2-3, 5 and 8-9."""
    speed = 0.02 * np.array([1, 1, 0, 0.05, 1, -0.09, 0.1, 1, 0, 0])
    found = measured(np.ones(10), speed=speed, commanded=np.full(10, 0.02))
    assert found["stick_events"] == 3
    assert found["stick_share"] == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("speed", "commanded", "settled_after", "events", "share"),
    [
        pytest.param([0, 0, 0, 1, 1, 0, 1, 1], 1, 0.3, 1, 0.2, id="before it has settled: not"),
        pytest.param([0, 0, 0, 0, 1, 1], 1, 0.2, 1, 0.5, id="when the settled part begins: once"),
        pytest.param([-1, -1, -1, -1], 1, 0.0, 0, 0.0, id="turning the wrong way: not"),
        pytest.param([0, 0, 0, 0], 0, 0.0, 0, 0.0, id="standing as commanded: not"),
    ],
)
def test_what_counts_as_sticking(speed, commanded, settled_after, events, share):
    commanded = np.full(len(speed), float(commanded))
    found = measured(np.ones(len(speed)), speed, commanded, settled_after=settled_after)
    assert found["stick_events"] == events
    assert found["stick_share"] == pytest.approx(share)


def test_voltage():
    found = measured([1, 1, 1], command=[3, -4, 0])
    assert found["peak_voltage_V"] == 4.0
    assert found["control_effort_V2s"] == pytest.approx(2.5)  # 25 V2 for 0.1 s each
    assert found["rms_voltage_change_V"] == pytest.approx(((49 + 16) / 2) ** 0.5)


@pytest.mark.parametrize("part", ["error", "speed", "command"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_diverged_motion_has_no_metrics(part, value):
    parts = {"error": [1.0, 1.0], part: [1.0, value]}
    assert measured(**parts) == dict.fromkeys(measured([0.0, 1.0]))


def test_single_sample():
    found = measured([0.5])
    assert found["rms_error_rad"] == 0.5
    assert found["settling_time_s"] is None
    assert found["control_effort_V2s"] == 0.0
    assert found["rms_voltage_change_V"] is None


def test_never_settles():
    assert measured([10.0, 0.5, 5.0])["settling_time_s"] is None


def test_no_error_at_all_has_settled_at_once():
    found = measured([0.0, 0.0, 0.0])
    assert found["settling_time_s"] == 0.0
    assert found["max_error_rad"] == 0.0


def test_run_shorter_than_settled_after_is_looked_at_as_a_whole():
    speed = [0, 1, 0, 1]
    found = measured(np.ones(4), speed=speed, error_rate=[1, 1, 1, 1], settled_after=1.0)
    assert found["stick_events"] == 2
    assert found["stick_share"] == 0.5
    assert found["velocity_ripple_rad_s"] == 1.0
