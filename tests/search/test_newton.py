"""Gauss-Newton proposals against problems whose answer is known."""

import numpy as np
import pytest
import scipy.optimize

from hfc_design.search.newton import HORIZONS, LENGTHS, Linear, proposals

RNG = np.random.default_rng(7)
JACOBIAN = RNG.standard_normal((200, 6))
TRUTH = RNG.standard_normal(6)
NOTHING = np.zeros(6, bool)


def exact(point):
    return Linear(JACOBIAN @ (point - TRUTH), JACOBIAN)


def test_full_step_with_little_damping_solves_a_linear_problem():
    start = RNG.standard_normal(6)
    error = JACOBIAN @ (start - TRUTH)
    points, damping = proposals(start, Linear(error, JACOBIAN), NOTHING, 1e-9, 28)
    assert points.shape == (28, 6)
    assert np.allclose(points[np.argmin(damping)], TRUTH, atol=1e-8)


def test_iterated_steps_minimise_the_sum_of_absolute_errors():
    noise = RNG.standard_t(2, 200)  # heavy tails: least squares is far from the answer
    point = np.zeros(6)
    for _ in range(200):
        error = JACOBIAN @ (point - TRUTH) + noise
        points, _ = proposals(point, Linear(error, JACOBIAN), NOTHING, 1e-9, 40)
        sums = np.abs(JACOBIAN @ (points - TRUTH).T + noise[:, None]).sum(axis=0)
        point = points[sums.argmin()]
    # Oracle: the same problem as a linear program, min sum t with -t <= e <= t.
    identity = np.eye(200)
    offset = noise - JACOBIAN @ TRUTH
    result = scipy.optimize.linprog(
        np.concatenate([np.zeros(6), np.ones(200)]),
        np.block([[JACOBIAN, -identity], [-JACOBIAN, -identity]]),
        np.concatenate([-offset, offset]),
        bounds=[(None, None)] * 6 + [(0, None)] * 200,
    )
    found = np.abs(JACOBIAN @ (point - TRUTH) + noise).sum()
    assert found == pytest.approx(result.fun, rel=1e-4)


def test_frozen_parameters_stay():
    frozen = np.array([True, False, False, True, False, False])
    start = RNG.standard_normal(6)
    points, _ = proposals(start, exact(start), frozen, 1.0, 40)
    assert np.array_equal(points[:, frozen], np.tile(start[frozen], (40, 1)))
    assert (points[:, ~frozen] != start[~frozen]).any(axis=0).all()


def test_parameters_without_influence_stay_put():
    jacobian = JACOBIAN.copy()
    jacobian[:, 2] = 0.0
    start = RNG.standard_normal(6)
    points, _ = proposals(start, Linear(jacobian @ (start - TRUTH), jacobian), NOTHING, 1.0, 12)
    assert np.isfinite(points).all()
    assert np.allclose(points[:, 2], start[2], atol=1e-12)


@pytest.mark.parametrize("count", [1, 2, 5, 40, 41])
def test_any_number_of_proposals(count):
    start = RNG.standard_normal(6)
    points, damping = proposals(start, exact(start), NOTHING, 2.0, count)
    assert points.shape == (count, 6)
    assert damping.shape == (count,)
    assert damping.min() >= 2e-3
    assert damping.max() <= 2e3
    assert len(LENGTHS) * len(HORIZONS) == 6
