"""Circular tests on pure geometry: by hand, by every candidate, and what was planted is found."""

from itertools import combinations
from math import pi

import numpy as np
import pytest
from planted_circles import CAUSES, planted

from hfc_design.motion.circularity import (
    EITHER,
    SERVO,
    SQUARE,
    causes,
    deviations,
    full_turns,
    minimum_zone,
    nominal_circle,
)

R = 50.0
ANGLES = np.linspace(0.0, 2.0 * pi, 3600, endpoint=False)


def polar(radius, angle=ANGLES):
    return radius * np.stack([np.cos(angle), np.sin(angle)])


def shifted(points, x, y):
    return np.stack([points[0] + x, points[1] + y])


def with_backlash(b):
    """X is behind by half the backlash on its way back in the upper half, then on its way."""
    half = np.linspace(0.0, pi, 1801)
    return np.hstack([shifted(polar(R, half), b / 2, 0), shifted(polar(R, -half), -b / 2, 0)])


@pytest.mark.parametrize(
    ("points", "width"),
    [
        (polar(R) * [[1 + 4e-4], [1 - 4e-4]], 0.04),  # half axes of an ellipse, 20 um off each
        (shifted(polar(R), 3.0, -1.0), 0.0),  # a circle elsewhere
        (polar(R + 0.02 * np.cos(3 * ANGLES)), 0.04),
        (shifted(polar(R + 0.02 * np.cos(5 * ANGLES)), 0.3, -0.1), 0.04),
        (with_backlash(0.03), 0.03),  # the steps are as high wherever the centre is
    ],
)
def test_minimum_zones_by_hand(points, width):
    assert minimum_zone(points) == pytest.approx(width, abs=1e-9 * R)


def test_a_spike_is_the_zone_less_what_its_neighbours_give():
    """The centre moves half the height towards the spike, until the far side is as far as it."""
    height, points = 0.02, polar(np.full(3600, R))
    points[:, 0] *= 1 + height / R
    centre = height / 2
    neighbour = np.hypot(*(points[:, 1] - [centre, 0.0]))
    assert minimum_zone(points) == pytest.approx(R + height - centre - neighbour, abs=1e-9 * R)


def test_minimum_zones_of_few_points_by_every_candidate():
    """A zone has two of the points on each circle, or three on one of them."""
    random = np.random.default_rng(0)
    for _ in range(3):
        angle = np.sort(random.uniform(0, 2 * pi, 9))
        points = polar(R + random.normal(0, 0.05, 9), angle)
        squares, best = (points**2).sum(axis=0), np.inf
        for one, two in combinations(combinations(range(9), 2), 2):
            rows = 2 * np.stack([points[:, b] - points[:, a] for a, b in (one, two)])
            if abs(np.linalg.det(rows)) > 1e-9:
                centre = np.linalg.solve(rows, [squares[b] - squares[a] for a, b in (one, two)])
                best = min(best, np.ptp(np.hypot(*(points - centre[:, None]))))
        assert minimum_zone(points) == pytest.approx(best, abs=1e-9 * R)


def test_deviations_of_both_directions_by_hand():
    """A circle too large and off its centre, and back one too small."""
    turns = {1: shifted(polar(R + 0.03), 0.04, 0.0), -1: polar(R - 0.01)}
    found = deviations(turns, R)
    assert [*found] == [
        *("G(XY)", "G(YX)", "G(b)"),
        *("Fmax(XY)", "Fmin(XY)", "Fmax(YX)", "Fmin(YX)", "D"),
    ]
    assert (found["G(XY)"], found["G(YX)"]) == pytest.approx((0.0, 0.0), abs=1e-9 * R)
    # The larger circle is 0.07 beyond on one side and 0.01 within on the other of the centre.
    assert found["Fmax(XY)"] == pytest.approx(0.07, abs=1e-9 * R)
    assert found["Fmin(XY)"] == pytest.approx(-0.01, abs=1e-9 * R)
    assert (found["Fmax(YX)"], found["Fmin(YX)"]) == pytest.approx((-0.01, -0.01), abs=1e-9 * R)
    # Radii that differ by 0.04 and centres by 0.04: the sum, from any centre between both.
    assert found["G(b)"] == pytest.approx(0.08, abs=1e-9 * R)
    assert found["D"] == pytest.approx(0.01, abs=1e-5)
    centred = deviations(turns, R, centred=True)
    assert centred["Fmax(XY)"] == pytest.approx(0.03, abs=1e-9 * R)
    assert [*deviations({-1: turns[-1]}, R)] == ["G(YX)", "Fmax(YX)", "Fmin(YX)"]


def test_run_up_and_feed_out_do_not_count():
    """From the centre to the circle, 450 deg, a rest, back by 380 deg, and away."""
    there, back = np.radians(np.arange(0.0, 451.0)), np.radians(np.arange(450.0, 69.0, -1.0))
    out = np.stack([np.linspace(0.0, R, 60), np.zeros(60)])
    path = np.hstack([out, polar(R, there), np.tile(polar(R, there[-1:]), 40), polar(R, back)])
    turns, longest = full_turns(path, R)
    assert np.degrees(longest) == pytest.approx(450.0)
    for side, first in ((1, 45.0), (-1, 440.0)):
        part = path[:, turns[side]]
        swept = np.degrees(np.unwrap(np.arctan2(part[1], part[0])))
        assert side * (swept[-1] - swept[0]) == pytest.approx(360.0, abs=1.1)
        assert swept[0] % 360.0 == pytest.approx(first % 360.0, abs=1.1)
    found, radius = nominal_circle(shifted(path, 200.0, -30.0))
    assert (*found, radius) == pytest.approx((200.0, -30.0, R), abs=1e-9)
    assert full_turns(polar(R, there[:340]), R)[0] == {}


def test_the_planted_cause_is_named_in_95_of_100():
    random = np.random.default_rng(0)
    right, off = 0, []
    for k in range(100):
        cause = CAUSES[k % len(CAUSES)]
        radius, turns, sizes = planted(random, cause)
        found = causes(turns, radius)[0]
        right += found.name == cause
        off.append(found.size / sizes[cause] - 1)
    assert right >= 95
    assert np.quantile(np.abs(off), 0.9) < 0.25  # also in how large it is


def test_one_direction_alone_leaves_two_causes_together():
    random = np.random.default_rng(1)
    for cause in (SERVO, SQUARE):
        radius, turns, sizes = planted(random, cause, directions=(-1,))
        found = causes(turns, radius)
        assert found[0].name == EITHER
        assert found[0].size == pytest.approx(sizes[cause], rel=0.25)
        assert not {SERVO, SQUARE} & {one.name for one in found}
