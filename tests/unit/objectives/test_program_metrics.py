"""What is read off a motion through a program of any axes, by hand."""

import numpy as np
import pytest

from hfc_design.motion import gcode
from hfc_design.motion.limits import AxisLimits, MovedAxis
from hfc_design.motion.program import program
from hfc_design.motion.tool_path import program_errors
from hfc_design.objectives.metric import PROGRAM, AxisRecord, MotionRecord
from hfc_design.objectives.recorded import overshoot
from hfc_design.objectives.tables import columns, values
from plants import PLANTS

MACHINE = PLANTS["five-axis"]
AXES = tuple(MovedAxis(axis, 1.0, axis in "ac", 500.0) for axis in MACHINE.axes)
LIMITS = {axis: AxisLimits(velocity_per_min=6000, acceleration_per_s2=800.0) for axis in "xyzac"}
TIME = np.arange(0.0, 1.2, 0.002)


def metrics(off, command=1.0):
    """Of a machine that is ``off`` (5,) its places all along a line of 30 mm with 10 deg of A."""
    found = program(gcode.blocks("G1 X30 A10 F3000"), AXES, LIMITS, 0.002)
    samples = found.samples(TIME)
    places = samples.position + np.reshape(off, (5, 1))
    axes = [
        AxisRecord(
            *(axis, drive, TIME, np.ones_like(TIME, bool), reference, rate),
            *(reference - place, np.zeros_like(TIME), rate),
            *(np.full_like(TIME, command), (-8.0, 8.0)),
        )
        for axis, drive, reference, place, rate in zip(
            MACHINE.axes, MACHINE.drives, samples.position, places, samples.velocity, strict=True
        )
    ]
    motion = MotionRecord(tuple(axes), program_errors(found, TIME, places, "mm"))
    return values(columns(MACHINE, PROGRAM), motion)


def test_errors_of_a_machine_that_is_off_by_a_constant():
    found = metrics([0.3, 0.03, 0.04, 0.2, 0.0])
    # 0.3 mm ahead along the path, so 0.1 deg of the 0.2 are in place; at its end 0.3 mm off it
    assert found["rms_contour_error_mm"] == pytest.approx(np.hypot(0.05, 0.3), rel=0.4)
    assert found["max_contour_error_mm"] == pytest.approx(np.hypot(0.05, 0.3))
    assert found["max_orientation_error_deg"] == pytest.approx(0.2)
    assert found["x_rms_error_mm"] == pytest.approx(0.3)
    assert found["a_max_error_deg"] == pytest.approx(0.2)
    assert found["x_overshoot_mm"] == pytest.approx(0.3)
    assert found["y_overshoot_mm"] == 0.0  # nothing is to move there
    assert found["worst_glitch_mm"] is None
    assert found["peak_voltage_V"] == 1.0
    assert found["velocity_share"] == pytest.approx(0.5)  # 3,000 of 6,000 mm/min
    assert found["limit_share"] == 0.0
    assert metrics([0.0] * 5, command=-8.0)["limit_share"] == 1.0


def test_a_diverged_motion_has_no_numbers():
    assert set(metrics([np.inf, 0.0, 0.0, 0.0, 0.0]).values()) == {None}


def test_overshoot_is_beyond_a_reversal_or_the_end():
    reference = np.array([0.0, 1.0, 2.0, 1.0, 0.0, 0.0, 0.0])
    late = np.array([0.0, 0.5, 1.5, 2.25, 0.5, -0.1, 0.0])  # beyond 2 after it, beyond 0 at the end
    assert overshoot(reference, late) == pytest.approx(0.25)
    assert overshoot(reference, np.minimum(late, 2.0)) == pytest.approx(0.1)
    assert overshoot(reference, np.clip(late, 0.0, 2.0)) == 0.0
    assert overshoot(np.zeros(5), np.ones(5)) == 0.0
    assert overshoot(np.array([3.0, 2.0, 2.0]), np.array([3.0, 2.5, 1.8])) == pytest.approx(0.2)


def test_an_axis_that_never_went_beyond_a_reversal_has_no_overshoot():
    reference = np.array([0.0, -7.0, -2.0, -3.0, -99.0, -99.0])  # down, up to -2, down again
    assert overshoot(reference, np.array([0.0, 0.0, 0.0, 0.0, -50.0, -99.0])) == 0.0  # held at 0
    rises = np.array([0.0, -1.0, -0.7, -1.0, -50.0, -99.0])  # by 0.3 beyond -2, from where it was
    assert overshoot(reference, rises) == pytest.approx(0.3)
    comes = np.array([0.0, -5.0, -1.5, -2.0, -50.0, -99.0])  # from before -2 to 0.5 beyond
    assert overshoot(reference, comes) == pytest.approx(0.5)
