"""Paths and their motion: by hand, by SciPy's quadrature and by differences."""

import tomllib
from math import cos, pi, radians, sin, sqrt
from pathlib import Path as FilePath

import numpy as np
import pytest
import tomli_w
from drawn_paths import chained, segments
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from hfc_design.core.records import Record, checked
from hfc_design.motion.paths import Path, arc, line, motion
from hfc_design.motion.trajectories import (
    Circle,
    Line,
    PathReference,
    Polyline,
    speed_fault,
)
from plants import FEED_DRIVE

TILT = 26.6


class Holder(Record):
    reference: PathReference


def near(wanted, abs=1e-12):
    return pytest.approx(np.array(wanted), abs=abs)


def test_circle_of_the_paper_takes_20_s_a_cycle():
    """JK04 section 5.2: R 40 mm at 0.754 m/min; ccw from (40, 0), full feed at once."""
    circle = Circle(radius_mm=40.0, feed_mm_min=754.0, cycles=3)
    assert circle.duration_s == pytest.approx(3 * 2 * pi * 40 * 60 / 754)
    assert circle.duration_s == pytest.approx(60.0, rel=1e-3)
    at = circle.samples(np.array([0.0, circle.duration_s / 12, circle.duration_s / 3, 100.0]))
    speed = 754.0 / 60.0
    assert at.position == near([[40, 0, 40, 40], [0, 40, 0, 0]])
    assert at.velocity == near([[0, -speed, 0, 0], [speed, 0, speed, 0]])
    assert at.tangent == near([[0, -1, 0, 0], [1, 0, 1, 1]])
    assert (at.curvature == 1 / 40).all()
    assert at.distance == near([0, 20 * pi, 80 * pi, 240 * pi], abs=1e-9)


def test_circle_clockwise():
    circle = Circle(radius_mm=20.0, feed_mm_min=600.0, direction="cw", cycles=0.5)
    at = circle.samples(np.array([0.0, pi, 2 * pi]))  # 10 mm/s over 20 pi mm
    assert circle.duration_s == pytest.approx(2 * pi)
    assert at.position == near([[20, 0, -20], [0, -20, 0]])
    assert at.velocity[:, :2] == near([[0, -10], [-10, 0]])
    assert (at.curvature == -1 / 20).all()


def test_polyline_stops_at_its_corner():
    """30 mm and 40 mm at 10 mm/s and 20 mm/s2: 0.5 s and 2.5 mm to speed up or brake."""
    square = Polyline(
        points_mm=[(0, 0), (30, 0), (30, 40)], feed_mm_min=600.0, acceleration_mm_s2=20.0
    )
    assert square.duration_s == pytest.approx(3.5 + 4.5)
    at = square.samples(np.array([0.0, 0.25, 0.5, 3.0, 3.25, 3.5, 4.0, 7.75, 8.0]))
    assert at.position[0] == near([0, 0.625, 2.5, 27.5, 29.375, 30, 30, 30, 30])
    assert at.position[1] == near([0, 0, 0, 0, 0, 0, 2.5, 39.375, 40])
    assert at.velocity[0] == near([0, 5, 10, 10, 5, 0, 0, 0, 0])
    assert at.velocity[1] == near([0, 0, 0, 0, 0, 0, 10, 5, 0])


@pytest.mark.parametrize(
    ("jump_deg", "stops"), [(0.9, False), (-0.9, False), (1.1, True), (-1.1, True)]
)
def test_a_corner_starts_at_one_degree(jump_deg, stops):
    """Programs with three digits of a millimetre are not quite smooth where they should be."""
    turn = radians(jump_deg)
    bent = Polyline(
        points_mm=[(0, 0), (5, 0), (5 + 5 * cos(turn), 5 * sin(turn))],
        feed_mm_min=600.0,
        acceleration_mm_s2=20.0,
    )
    assert bent.duration_s == pytest.approx(2.0 if stops else 1.5)


def test_a_segment_too_short_for_its_feed_is_a_triangle():
    """5 mm at 20 mm/s2 peaks at 10 mm/s after 0.5 s whatever the feed."""
    short = Polyline(points_mm=[(0, 0), (0, -5)], feed_mm_min=6000.0, acceleration_mm_s2=20.0)
    assert short.duration_s == pytest.approx(1.0)
    assert short.motion.peak.tolist() == pytest.approx([10.0])


def test_tangent_arc_is_entered_at_the_lower_feed():
    """A line at 20 mm/s into a quarter circle at 10 mm/s, 20 mm/s2 (speeds squared over 40).

    The line: 10 mm up, 7.5 mm down to 10 mm/s, 12.5 mm even; the arc: 2.5 mm down at its end.
    """
    path = Path.of(
        [
            line((0.0, 0.0), (30.0, 0.0), 1200.0),
            arc((30.0, 0.0), (30.0, 8.0), pi / 2, 600.0),
        ]
    )
    assert not path.corners().any()
    moves = motion(path, 20.0)
    first = 1.0 + 12.5 / 20.0 + 0.5
    assert moves.duration == pytest.approx(first + (4 * pi - 2.5) / 10 + 0.5)
    way, speed, _ = moves.at(np.array([1.0, first, moves.duration]))
    assert way == near([10.0, 30.0, 30.0 + 4 * pi])
    assert speed == near([20.0, 10.0, 0.0])
    end = path.at(np.array([path.knots[-1]]))
    assert end.position == near([[38.0], [8.0]])
    assert end.tangent == near([[0.0], [1.0]])


@settings(deadline=None)
@given(segments, st.sampled_from([30.0, 500.0]), st.sampled_from([None, 60.0, 9000.0]))
def test_motion_keeps_its_limits_and_its_speed_is_the_derivative(parts, acceleration, jerk):
    path, end = chained(parts)
    moves = motion(path, acceleration, jerk)
    time = np.linspace(0.0, moves.duration, 400)
    way, speed, change = moves.at(time)
    assert (np.diff(way) >= 0).all()
    if jerk:
        assert (np.abs(np.diff(change)) <= jerk * time[1] * (1 + 1e-9) + 1e-9).all()
    assert way[-1] == pytest.approx(path.knots[-1])
    assert speed[-1] == 0.0
    step = time[1]
    assert (np.abs(np.diff(speed)) <= acceleration * step * (1 + 1e-9) + 1e-9).all()
    k = np.clip(np.searchsorted(path.knots, way, side="right") - 1, 0, len(parts) - 1)
    inside = np.abs(way[:, None] - path.knots).min(axis=1) > 1e-9
    rounding = 1e-9 if jerk else 1e-12  # of differences of ways
    assert (speed <= path.feed[k] / 60 * (1 + rounding))[inside].all()
    for knot in path.knots[1:-1][path.corners()]:  # it stops there
        near_it = np.interp(knot, way, time)
        assert moves.at(np.array([near_it]))[1] < acceleration * step
    h = 1e-6
    middle = time[1:-1]
    slope = (moves.at(middle + h)[0] - moves.at(middle - h)[0]) / (2 * h)
    np.testing.assert_allclose(speed[1:-1], slope, atol=acceleration * h + 1e-6)
    assert path.at(path.knots[-1:]).position[:, 0] == near([end.real, end.imag], abs=1e-9)


@settings(deadline=None)
@given(segments)
def test_tangent_and_curvature_are_the_derivatives_of_the_position(parts):
    path, _ = chained(parts)
    h = 1e-4
    distance = np.linspace(0.0, path.knots[-1], 50)
    distance = distance[np.abs(distance[:, None] - path.knots).min(axis=1) > 2 * h]
    place, before, after = path.at(distance), path.at(distance - h), path.at(distance + h)
    slope = (after.position - before.position) / (2 * h)
    np.testing.assert_allclose(place.tangent, slope, atol=1e-7)
    bend = (after.tangent - before.tangent) / (2 * h)
    left = np.stack([-place.tangent[1], place.tangent[0]])
    np.testing.assert_allclose(bend, place.curvature * left, atol=1e-7)


@settings(deadline=None)
@given(segments)
def test_largest_components_by_sampling(parts):
    path, _ = chained(parts)
    for k, length in enumerate(path.length):
        points = np.linspace(0.0, length, 2001)
        tangent = path.on(np.full(len(points), k), points).tangent
        sampled = np.abs(tangent).max(axis=1)
        assert path.largest_components()[:, k] == near(sampled, abs=1e-5)


def drive_speed(gain, friction):
    """Speed [mm/s] that a feed drive reaches with its largest command."""
    parameters = FEED_DRIVE.parameters(gain=gain, coulomb=friction)
    return FEED_DRIVE.top_speed(parameters) * FEED_DRIVE.millimetres(parameters)


def test_a_feed_that_the_drive_cannot_follow_is_refused_with_the_allowed_one():
    drives = [drive_speed(28.3, 15.0)] * 2
    assert speed_fault(Circle(radius_mm=20.0, feed_mm_min=1901.0), drives) is None
    assert speed_fault(Circle(radius_mm=20.0, feed_mm_min=1950.0), drives) == (
        "a feed of 1950 mm/min needs X at 32.5 mm/s, but its drive reaches "
        "31.7 mm/s; the largest feed here is 1901 mm/min"
    )
    assert speed_fault(Circle(radius_mm=20.0, feed_mm_min=1950.0), [40.0, 32.0]) == (
        "a feed of 1950 mm/min needs Y at 32.5 mm/s, but its drive reaches "
        "32 mm/s; the largest feed here is 1920 mm/min"
    )
    along_x = Line(length_mm=9.0, angle_deg=0.0, feed_mm_min=600.0)
    assert speed_fault(along_x, [drives[0], 1e-9]) is None
    stuck = speed_fault(along_x, [0.0, drives[1]])
    assert "needs X at 10 mm/s, but its drive reaches 0 mm/s; the largest feed" in stuck
    diagonal = Line(length_mm=9.0, angle_deg=45.0, feed_mm_min=2600.0)  # 1901.76 * sqrt(2) = 2689
    assert speed_fault(diagonal, drives) is None
    too_fast = diagonal.model_copy(update={"feed_mm_min": 2690.0})
    assert speed_fault(too_fast, drives).endswith("largest feed here is 2689 mm/min")
    # Too short to get there: sqrt(100 mm/s2 * 5 mm) = 22 mm/s.
    short = Polyline(points_mm=[(0, 0), (5, 0)], feed_mm_min=9e9)
    assert speed_fault(short, [sqrt(500.0) + 1e-9] * 2) is None
    assert "needs X at 22" in speed_fault(short, [22.0] * 2)


@pytest.mark.parametrize(
    ("kind", "values"),
    [
        (Circle, {"radius_mm": 0.0, "feed_mm_min": 1.0}),
        (Circle, {"radius_mm": 1.0, "feed_mm_min": 1.0, "direction": "left"}),
        (Line, {"length_mm": 1.0, "angle_deg": float("nan"), "feed_mm_min": 1.0}),
        (Polyline, {"points_mm": [(0, 0), (1, 0), (1, 0)], "feed_mm_min": 1.0}),
        (Polyline, {"points_mm": [(0, 0), (1, 0)], "feed_mm_min": 1.0, "acceleration_mm_s2": 0}),
    ],
)
def test_impossible_paths_are_refused(kind, values):
    with pytest.raises(ValidationError):
        kind(**values)


@pytest.mark.parametrize(
    "reference",
    [
        Circle(radius_mm=20.0, feed_mm_min=377.0, direction="cw", cycles=2.5),
        Line(length_mm=9.0, angle_deg=TILT, feed_mm_min=600.0, acceleration_mm_s2=50.0),
        Polyline(points_mm=[(0, 0), (0.1, -3.7)], feed_mm_min=600.0, jerk_mm_s3=900.0),
    ],
)
def test_a_reference_survives_toml(reference):
    text = tomli_w.dumps({"reference": reference.model_dump(mode="json", exclude_none=True)})
    back = checked(Holder, tomllib.loads(text), "mine.toml", FilePath()).reference
    assert type(back) is type(reference)
    assert back == reference
