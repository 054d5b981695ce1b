"""Contour errors by hand and against a dense search along the path."""

from math import pi, sqrt

import numpy as np
import pytest
from drawn_paths import chained, segments
from hypothesis import given, settings
from hypothesis import strategies as st

from hfc_design.motion.contour import (
    REACH,
    local_error,
    nearest,
    nearest_on_path,
)
from hfc_design.motion.paths import Path, arc, line
from hfc_design.motion.reversals import glitches, reversing, undisturbed
from hfc_design.motion.trajectories import Circle, Line, PathSamples, Polyline

SQUARE = [(0, 0), (10, 0), (10, 10), (0, 10), (0, 0)]


def commanded(path, distance):
    distance = np.asarray(distance, dtype=float)
    at = path.at(distance)
    still = 0 * at.position
    return PathSamples(at.position, still, at.tangent, at.curvature, distance, still)


def off_path(path, distance, points):
    """Nearest-point errors at actual points (x, y) while the path is at these lengths."""
    actual = np.array(points, dtype=float).T
    return nearest_on_path(path, commanded(path, distance), actual).error.tolist()


@pytest.mark.parametrize("curvature", [0.0, 0.05, -0.05, 2.0])
def test_local_error_is_exact_on_lines_and_circles(curvature):
    """At (3, 4) going along (0.6, 0.8); left is (-0.8, 0.6)."""
    for dx, dy in [(0.3, 0.1), (-0.2, 0.4), (0.0, 0.0), (-0.8 / 2, 0.6 / 2), (-3.0, 1.0)]:
        if curvature:
            centre = np.array([3 - 0.8 / curvature, 4 + 0.6 / curvature])
            radius = np.hypot(*(np.array([3 + dx, 4 + dy]) - centre))
            wanted = (1 / abs(curvature) - radius) * np.sign(curvature)
        else:
            wanted = -0.8 * dx + 0.6 * dy
        got = local_error(dx, dy, 0.6, 0.8, curvature)
        assert isinstance(got, float)
        # At the centre itself the root turns a rounding of 1e-16 into 1e-8.
        assert got == pytest.approx(wanted, abs=1e-7 if wanted == 0.5 else 1e-12)


@pytest.mark.parametrize("direction", ["ccw", "cw"])
def test_circle_counts_the_distance_from_its_centre(direction):
    circle = Circle(radius_mm=20.0, feed_mm_min=600.0, direction=direction, cycles=2)
    samples = circle.samples(np.arange(4.0))
    actual = np.array([[20.5, 0.0, -12.0, 0.0], [0.0, 19.0, 16.0, -21.0]])
    point, error = nearest(circle, samples, actual)
    assert error.tolist() == pytest.approx([0.5, -1, 0, 1])
    np.testing.assert_allclose(point, [[20, 0, -12, 0], [0, 20, 16, -20]], atol=1e-12)
    # To the left is inside of a circle that is run counter-clockwise.
    left = nearest_on_path(circle.path, circle.samples(np.full(4, 2.0)), actual).error
    sign = -1 if direction == "ccw" else 1
    assert (sign * left).tolist() == pytest.approx([0.5, -1, 0, 1], abs=1e-12)


def test_line_counts_the_normal_distance_also_beyond_its_end():
    ray = Line(length_mm=10.0, angle_deg=30.0, feed_mm_min=600.0)
    samples = ray.samples(np.array([0.0, 0.5, 9.0]))
    along, left = np.array([sqrt(3) / 2, 0.5]), np.array([-0.5, sqrt(3) / 2])
    actual = np.stack([-2 * along + 0.3 * left, 4 * along - 0.1 * left, 12 * along], axis=1)
    point, error = nearest(ray, samples, actual)
    assert error.tolist() == pytest.approx([0.3, -0.1, 0.0], abs=1e-12)
    foot = np.stack([-2 * along, 4 * along, 12 * along], axis=1)
    np.testing.assert_allclose(point, foot, atol=1e-12)


def test_square_with_a_machine_that_lags():
    square = Polyline(points_mm=SQUARE, feed_mm_min=600.0)
    path = square.path
    # Before the corner, inside and outside of it, in the wedge outside, on the bisector inside.
    points = [(9.0, 0.2), (9.7, 0.4), (10.3, -0.4), (10.2, 1.0), (9.5, 0.5)]
    wanted = [0.2, 0.3, -0.5, -0.2, 0.5]
    assert off_path(path, [9.5, 10.5, 10.5, 11.5, 10.5], points) == pytest.approx(wanted)


def test_side_at_a_sharp_corner():
    """Turns left by 135 deg: ahead of the corner everything is outside, that is, right."""
    path = Path.of([line((-5.0, 0.0), (0.0, 0.0), 60.0), line((0.0, 0.0), (-4.0, 4.0), 60.0)])
    angles = np.radians([-80.0, -45.0, 0.0, 40.0])
    points = [(0.1 * np.cos(a), 0.1 * np.sin(a)) for a in angles]
    assert off_path(path, [5.0] * 4, points) == pytest.approx([-0.1] * 4)
    assert off_path(path, [5.0], [(-0.2, 0.05)]) == pytest.approx([0.05])


def test_path_that_crosses_itself_keeps_to_the_branch_being_cut():
    """A figure of two crossing lines; 0.05 mm above the crossing the other branch is nearer."""
    path = Path.of(
        [
            line((-10.0, 0.0), (10.0, 0.0), 60.0),
            arc((10.0, 0.0), (10.0, 5.0), 3 * pi / 2, 60.0),
            line((5.0, 5.0), (5.0, -9.0), 60.0),
        ]
    )
    crossing = 15.0  # at (5, 0), on the first line
    assert off_path(path, [crossing], [(5.01, 0.05)]) == pytest.approx([0.05])
    again = path.knots[2] + 5.0
    assert off_path(path, [again], [(5.01, 0.05)]) == pytest.approx([0.01])  # east of southward


@settings(deadline=None)
@given(segments, st.floats(0.0, 1.0), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_nearest_point_by_dense_search(parts, share, dx, dy):
    path, _ = chained(parts)
    now = share * path.knots[-1]
    samples = commanded(path, [now])
    actual = samples.position + np.array([[dx], [dy]])
    reach = REACH * np.hypot(dx, dy)
    dense = np.linspace(max(now - reach, 0.0), min(now + reach, path.knots[-1]), 20_001)
    gaps = np.hypot(*(path.at(dense).position - actual))
    pitch = dense[1] - dense[0]
    found = nearest_on_path(path, samples, actual)
    error = abs(found.error[0])
    assert np.hypot(*(actual - found.point))[0] == pytest.approx(error)
    assert gaps.min() - pitch - 1e-9 <= error <= gaps.min() + 1e-9
    k = gaps.argmin()
    off = max(10 * pitch, 1e-9)  # mm; nearer than that, rounding decides the side
    if 0 < k < 20_000 and gaps[k] > off and not path.corners().any():
        away = actual - path.at(dense[k : k + 1]).position
        tangent = path.at(dense[k : k + 1]).tangent
        left = tangent[0] * away[1] - tangent[1] * away[0]
        second = gaps[(np.abs(dense - dense[k]) > 20 * pitch)].min(initial=np.inf)
        if second > gaps[k] + pitch:  # else two sides are equally near
            assert np.sign(left[0]) == np.sign(found.error[0])


def test_a_diverged_motion_has_no_finite_error():
    square = Polyline(points_mm=SQUARE, feed_mm_min=600.0)
    samples = square.samples(np.array([1.0, 2.0, 3.0]))
    actual = np.array([[1.0, np.nan, np.inf], [0.0, 0.0, 0.0]])
    error = nearest(square, samples, actual).error
    assert np.isfinite(error).tolist() == [True, False, False]


def test_glitches_of_a_circle_are_at_its_quadrants():
    """20 s a cycle from (R, 0): Y reverses at 5 s and 15 s, X at 10 s, Y and X after a cycle."""
    circle = Circle(radius_mm=40.0, feed_mm_min=60 * 2 * pi * 40 / 20, cycles=1.3)
    time = np.arange(0.0, 26.0, 0.01)
    samples = circle.samples(time)
    error = np.zeros(len(time))
    error[[520, 1050, 1580, 1200]] = [0.3, -0.4, 0.1, 9.0]  # the last is no glitch
    found = glitches(time, samples, error)
    assert [glitch.axis for glitch in found] == ["Y", "X", "Y", "X", "Y"]
    assert [glitch.time_s for glitch in found] == pytest.approx([5, 10, 15, 20, 25], abs=0.011)
    assert [glitch.error for glitch in found] == [0.3, -0.4, 0.1, 0.0, 0.0]


def test_the_path_error_leaves_out_what_follows_a_start_or_a_reversal():
    """The circle above: a second after 0 s, of both axes, and after each of its quadrants."""
    circle = Circle(radius_mm=40.0, feed_mm_min=60 * 2 * pi * 40 / 20, cycles=1.3)
    time = np.arange(0.0, 26.0, 0.01)
    found = undisturbed(time, circle.samples(time).velocity)
    left_out = [(begin, begin + 1.0) for begin in (0, 5, 10, 15, 20, 25)]
    for begin, end in left_out:
        inside = (time > begin + 0.011) & (time < end - 0.011)
        assert not found[inside].any()
    assert (~found).sum() == pytest.approx(600, abs=12)
    turns = reversing(time, circle.samples(time).velocity)
    assert (turns[time < 4.9].any(), turns.sum()) == (False, pytest.approx(500, abs=12))
    assert not (turns & found).any()
