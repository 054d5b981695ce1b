"""Gauss-Newton proposals against problems whose answer is known."""

from types import SimpleNamespace

import numpy as np
import pytest
import scipy.optimize

from hfc_design.controllers.genome import Space
from hfc_design.search.newton import (
    HORIZONS,
    LENGTHS,
    Linear,
    individuals,
    proposals,
    some_numbers,
)

RNG = np.random.default_rng(7)
JACOBIAN = RNG.standard_normal((200, 6))
TRUTH = RNG.standard_normal(6)


def exact(point):
    return Linear(JACOBIAN @ (point - TRUTH), JACOBIAN)


def test_full_step_with_little_damping_solves_a_linear_problem():
    start = RNG.standard_normal(6)
    error = JACOBIAN @ (start - TRUTH)
    points, damping = proposals(start, Linear(error, JACOBIAN), 1e-9, 28)
    assert points.shape == (28, 6)
    assert np.allclose(points[np.argmin(damping)], TRUTH, atol=1e-8)


def test_iterated_steps_minimise_the_sum_of_absolute_errors():
    noise = RNG.standard_t(2, 200)  # heavy tails: least squares is far from the answer
    point = np.zeros(6)
    for _ in range(200):
        error = JACOBIAN @ (point - TRUTH) + noise
        points, _ = proposals(point, Linear(error, JACOBIAN), 1e-9, 40)
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


@pytest.mark.parametrize("chosen", [None, np.array([0, 1, 4])])
def test_frozen_parameters_and_those_that_were_not_chosen_stay(chosen):
    frozen = np.array([True, False, False, True, False, False])
    start = RNG.standard_normal((1, 6))
    linear = exact(start[0])
    if chosen is not None:
        linear = Linear(linear.error, linear.jacobian[:, chosen], chosen)
    stays = frozen | ~np.isin(np.arange(6), np.arange(6) if chosen is None else chosen)
    ends = np.full(6, np.inf)
    space = Space(lambda x: x, lambda points, like: points, frozen, -ends, ends)
    points, _ = individuals(SimpleNamespace(space=lambda: space), start, linear, 1.0, 40)
    assert np.array_equal(points[:, stays], np.tile(start[0, stays], (40, 1)))
    assert (points[:, ~stays] != start[0, ~stays]).any(axis=0).all()


def test_some_numbers_are_drawn_of_those_that_may_move():
    frozen = np.arange(10) < 4
    ends = np.append(np.full(9, 1.0), 2.0)
    space = Space(lambda x: x, None, frozen, -ends, ends)
    genome = SimpleNamespace(space=lambda: space)
    one = np.array([[0.0, 1.0, 0.0, 0.0, 0.0, 0.5, -0.5, 1.0, 0.999, -2.0]])  # two at their ends
    drawn = [some_numbers(genome, one, 3, np.random.default_rng(k)) for k in range(50)]
    assert all(len(np.unique(each)) == 3 for each in drawn)
    assert set(np.concatenate(drawn)) == {4, 5, 6, 8}
    assert some_numbers(genome, one, 64, RNG).tolist() == [4, 5, 6, 8]


def test_parameters_without_influence_stay_put():
    jacobian = JACOBIAN.copy()
    jacobian[:, 2] = 0.0
    start = RNG.standard_normal(6)
    points, _ = proposals(start, Linear(jacobian @ (start - TRUTH), jacobian), 1.0, 12)
    assert np.isfinite(points).all()
    assert np.allclose(points[:, 2], start[2], atol=1e-12)


@pytest.mark.parametrize("count", [1, 41])
def test_any_number_of_proposals(count):
    start = RNG.standard_normal(6)
    points, damping = proposals(start, exact(start), 2.0, count)
    assert points.shape == (count, 6)
    assert damping.shape == (count,)
    assert damping.min() >= 2e-3
    assert damping.max() <= 2e3
    assert len(LENGTHS) * len(HORIZONS) == 6
