"""Round numbers, as users write them, and off by 1e-12: no decision hangs on their last bits."""

from itertools import pairwise

import numpy as np
import pytest
from shaken import shaken

from hfc_design.motion import gcode
from hfc_design.motion.axis_path import AxisPath, Bounds, look_ahead
from hfc_design.motion.limits import AxisLimits, MovedAxis
from hfc_design.motion.paths import Path, line
from hfc_design.motion.program import program, top_speed_fault
from hfc_design.motion.references import Step, Table, Trapezoidal
from hfc_design.motion.reversals import glitches, undisturbed
from hfc_design.motion.samples import PathSamples
from hfc_design.motion.trajectories import Line, Polyline, speed_fault
from plants import FEED_DRIVE

EVERY = (0.0001, 0.0003, 0.0007, 0.001, 0.002, 0.01)  # [s]


KEYS = ("distance", "velocity", "acceleration")


def clock(every, steps):
    return np.arange(steps) * every


@pytest.mark.parametrize("every", EVERY)
def test_a_step_comes_in_the_sample_of_its_time(every):
    for number in (1, 3, 7, 57, 290, 1001):
        for period, moment in shaken(every, float(f"{number * every:.9g}")):
            jump = Step(height=1.0, time_s=moment).samples(clock(period, 1100)).target
            assert int(np.argmax(jump)) == number


@pytest.mark.parametrize("every", EVERY)
def test_at_a_corner_of_a_table_the_next_slope_counts(tmp_path, every):
    """Rows at samples 3, 7 and 57, written with the digits that users write."""
    file = tmp_path / "table.csv"
    rows = [float(f"{k * every:.9g}") for k in (0, 3, 7, 57)]
    for times in shaken(*rows[1:]):
        file.write_text(
            "".join(f"{t},{v}\n" for t, v in zip((0.0, *times), (0, 3, 3, 0), strict=True))
        )
        rate = Table(file=file).samples(clock(every, 80)).reference_rate * every
        wanted = [1.0] * 3 + [0.0] * 4 + [-0.06] * 50 + [0.0] * 23
        np.testing.assert_allclose(rate, wanted, atol=1e-9)


@pytest.mark.parametrize(
    ("velocity", "acceleration"), [(0.3, 0.1), (0.7, 0.1), (0.6, 0.2), (6.0, 20.0), (0.9, 0.3)]
)
def test_a_move_rises_and_falls_for_as_many_samples_as_it_says(velocity, acceleration):
    """Its acceleration is fed forward: a sample of it more would be another motion."""
    rise = round(1000 * velocity / acceleration)
    even = 500
    distance = velocity * (rise + even) / 1000
    for numbers in shaken(distance, velocity, acceleration):
        move = Trapezoidal(**dict(zip(KEYS, numbers, strict=True)))
        told = move.samples(clock(0.001, 2 * rise + even + 20))
        signs = np.sign(told.reference_acceleration)
        assert [int((signs == sign).sum()) for sign in (1, -1)] == [rise, rise]
        assert np.flatnonzero(signs).tolist()[-1] == 2 * rise + even - 1


def square(size, feed):
    """A square at full feed, corners included."""
    points = ((0.0, 0.0), (size, 0.0), (size, size), (0.0, size), (0.0, 0.0))
    return Path.of(line(a, b, feed) for a, b in pairwise(points))


@pytest.mark.parametrize(("size", "feed"), [(20.0, 600.0), (0.3, 18.0), (0.7, 42.0)])
def test_at_a_corner_the_next_segment_counts(size, feed):
    """At 10 ms it comes to each corner in a whole number of samples."""
    number = round(size / (feed / 60.0) / 0.01)
    for a, b in shaken(size, feed):
        path = square(a, b)
        way = b / 60.0 * clock(0.01, 4 * number)
        np.testing.assert_array_equal(path.segment(way), np.repeat(range(4), number))


def test_a_line_along_an_axis_moves_no_other():
    """cos 90 deg is 6e-17, and an axis that is to move at that rate and stands would stick."""
    for angle, still in ((0.0, 1), (90.0, 0), (180.0, 1), (-90.0, 0)):
        told = Line(length_mm=100.0, angle_deg=angle, feed_mm_min=600.0)
        axes, _ = told.axis_samples(clock(0.01, 100), 0.01)
        assert not axes[still].target.any()
        assert not axes[still].reference_rate.any()


def test_a_drive_that_is_just_fast_enough_follows():
    for speed, feed in shaken(25.0, 1500.0):
        reference = Line(length_mm=100.0, angle_deg=0.0, feed_mm_min=feed)
        assert speed_fault(reference, (speed, speed)) is None
        slow = speed_fault(reference, (0.6 * speed, speed))
        assert slow.endswith("the largest feed here is 900 mm/min")
    for share in (0.1, 0.3, 0.6, 0.7):  # the limit left out is that of the drive
        axes = (MovedAxis("x", 1.0, False, 500.0), MovedAxis("y", 1.0, False, 700.0 * share))
        limits = {axis.name: AxisLimits(acceleration_per_s2=1000.0) for axis in axes}
        for y in (10.0, 30.0, 70.0):
            blocks = gcode.blocks(f"G1 X100 Y{y} F1000000")
            assert top_speed_fault(program(blocks, axes, limits, 0.002)) is None


def test_a_radius_that_is_off_by_just_what_is_allowed_is():
    for start, end in (*shaken(10.0, 10.01), *shaken(100.0, 100.1)):
        (block,) = gcode.blocks(f"G3 X{end - start!r} Y0 I{start!r} F100")
        assert block.centre == pytest.approx((start, 0.0))


def test_steps_that_add_up_to_where_the_axis_stands_move_it_nowhere():
    """0.1 + 0.2 is no 0.3; Z moves beside X by 6e-17, which nobody wrote."""
    text = "G91 G1 Z0.1 F100\nZ0.2\nG90 X10 Z0.3"
    assert len(gcode.segments(text, 1000.0)) == 1


@pytest.mark.parametrize("every", EVERY)
def test_the_time_after_a_reversal_has_its_samples(every):
    """One second of them, whenever it begins."""
    steps = round(1.0 / every)
    for begin in (0, 1, 41, 68, 205, 281, 5003):
        velocity = np.where(np.arange(begin + steps + 40) < begin, 0.0, 1.0)
        time = clock(every, len(velocity))
        late = ~undisturbed(time, velocity[None])
        assert int(late.sum()) == int(np.ceil(1.0 / every - 1e-6))


def test_a_spline_ends_in_the_sample_of_its_last_row(tmp_path):
    """Where its slope is not 0, and an axis that has come would be told to go on."""
    file = tmp_path / "table.csv"
    for times in shaken(0.1, 0.2, 0.3):
        file.write_text("".join(f"{t},{t**2}\n" for t in (0.0, *times)))
        rate = Table(file=file, interpolation="cubic").samples(clock(0.001, 320)).reference_rate
        assert rate[299] == pytest.approx(2.0 * 0.299)
        assert not rate[300:].any()


def test_a_circle_of_360_lines_has_no_corner():
    """By how much each is turned is 1 degree but for its last bits, and 2 are a corner."""
    for number, corners in ((360, 0), (180, 179)):
        turn = np.radians(np.arange(number + 1) * 360.0 / number + 0.1)
        points = tuple(zip(50.0 * np.cos(turn), 50.0 * np.sin(turn), strict=True))
        found = Polyline(points_mm=points, feed_mm_min=600.0).path.corners()
        assert found.sum() == corners


def test_what_is_passed_at_the_least_speed_is_passed():
    """12 mm/min are what 100 mm/s2 reach in two cycles of a millisecond."""
    for feed, rate in shaken(0.2, 100.0):
        bounds = Bounds(*(np.full(2, x) for x in (500.0, 500.0, rate)))
        path = AxisPath.of(gcode.blocks(f"G1 X1 F{60.0 * feed!r}\nX2"), ("x", "y"))
        found = look_ahead(path, bounds, 0.001)
        assert found.at(np.array([0.5 * found.duration]))[1] == pytest.approx(feed)


def test_a_glitch_is_looked_for_in_a_second():
    time = clock(0.01, 400)
    velocity = np.array([np.where(np.arange(400) < 41, 1.0, -1.0), np.ones(400)])
    error = np.where(np.arange(400) == 141, 5.0, 1.0)  # a second later: beyond
    blank = np.zeros((2, 400))
    samples = PathSamples(blank, velocity, blank, blank[0], blank[0], blank)
    (found,) = glitches(time, samples, error)
    assert found.error == 1.0


def test_half_a_unit_is_not_rounded_by_its_last_bit():
    for halves in shaken(0.5, 1.5, 2.5, -0.5, 1000.5):
        assert FEED_DRIVE.commanded(np.array(halves)).tolist() == [1.0, 2.0, 3.0, -1.0, 1001.0]
