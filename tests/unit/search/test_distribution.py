"""CMA-ES against what is known of it: its constants, its speed on quadratic functions."""

import numpy as np
import pytest

from hfc_design.search.distribution import begun, constants, drawn, learnt
from hfc_design.search.multistart_cma import ISLANDS, SAMPLES, multistart


def minimised(function, size, samples, generations, seed=0, start=1.0, step=0.5):
    distribution, rng = begun(np.full(size, start), step), np.random.default_rng(seed)
    for _ in range(generations):
        points = drawn(distribution, samples, rng)
        distribution = learnt(distribution, points, -function(points))
    return distribution


def test_constants_of_the_tutorial():
    """Hansen 2016, table 1 with n = 10 and 10 samples, by hand."""
    found = constants(10, 10)
    raw = np.log(5.5) - np.log(np.arange(1, 6))
    weights = raw / raw.sum()
    mass = 1.0 / np.sum(weights**2)
    assert found.weights == pytest.approx(weights)
    assert found.mass == pytest.approx(mass)
    assert found.step_rate == pytest.approx((mass + 2) / (10 + mass + 5))
    assert found.damping == pytest.approx(1.0 + found.step_rate)
    assert found.path_rate == pytest.approx((4 + mass / 10) / (10 + 4 + 2 * mass / 10))
    assert found.rank_one == pytest.approx(2 / (11.3**2 + mass))
    assert found.rank_mu == pytest.approx(2 * (mass - 2 + 1 / mass) / (12**2 + mass))
    assert found.length == pytest.approx(3.0847, abs=1e-4)  # mean of chi with 10 degrees


@pytest.mark.parametrize(
    ("size", "spread", "generations"),
    [(10, 1e6, 500), (60, 1e3, 600)],  # the whole, variances
)
def test_it_learns_how_long_the_axes_of_an_ellipsoid_are(size, spread, generations):
    axes = spread ** (np.arange(size) / (size - 1))
    found = minimised(lambda x: x**2 @ axes, size, 16, generations)
    assert found.mean**2 @ axes < 1e-6
    variances = found.covariance.diagonal() if size == 10 else found.covariance[:, 0]
    slope = np.polyfit(np.log(axes), np.log(variances), 1)[0]
    assert slope == pytest.approx(-1.0, abs=0.1)  # as the inverse Hessian


def test_the_average_of_three_means_by_hand():
    """Each has 3 / (age + 3) of it when it comes: a tenth, three tenths, six tenths."""
    distribution, rng, means = begun(np.ones(2), 0.5), np.random.default_rng(1), []
    assert distribution.average == pytest.approx(distribution.mean)
    for _ in range(3):
        points = drawn(distribution, 6, rng)
        distribution = learnt(distribution, points, rng.standard_normal(6))
        means.append(distribution.mean)
    assert distribution.average == pytest.approx(np.array([0.1, 0.3, 0.6]) @ np.array(means))


def rastrigin(points):
    """0 at 0.7 in every number, one of many hills; the others are lower by 1 and more."""
    x = points - 0.7
    return -(x**2 + 10.0 * (1.0 - np.cos(2.0 * np.pi * x))).sum(axis=1)


def test_the_highest_of_many_hills_is_found():
    rng = np.random.default_rng(0)
    first = rng.uniform(-3.0, 3.0, (200, 3))
    tried = multistart(first, rastrigin, 12_000, rng)
    assert tried.score.max() > -0.01
    assert tried.points[tried.score.argmax()] == pytest.approx([0.7] * 3, abs=0.01)
    lucky = rng.uniform(-3.0, 3.0, (12_000, 3))
    assert tried.score.max() > rastrigin(lucky).max()


@pytest.mark.parametrize("evaluations", [10, 1234])
def test_no_more_is_asked_than_is_allowed_and_all_is_told(evaluations):
    asked = []

    def counted(points):
        asked.append(points)
        return rastrigin(points)

    rng = np.random.default_rng(1)
    first = rng.uniform(-3.0, 3.0, (10, 2))
    tried = multistart(first, counted, evaluations, rng)
    total = sum(map(len, asked))
    assert total <= max(evaluations, 10)
    assert total > evaluations - ISLANDS * SAMPLES
    assert np.array_equal(tried.points, np.concatenate(asked))
    assert np.array_equal(tried.score, rastrigin(tried.points))


def test_where_nothing_is_finite_nothing_is_climbed():
    rng = np.random.default_rng(2)
    tried = multistart(rng.normal(size=(20, 2)), lambda x: np.full(len(x), -np.inf), 1000, rng)
    assert len(tried.points) == 20
    assert not np.isfinite(tried.score).any()


def test_it_turns_with_the_function():
    """Rosenbrock's valley is bent: without correlations it takes ten times as long."""

    def rosenbrock(x):
        return np.sum(100.0 * (x[:, 1:] - x[:, :-1] ** 2) ** 2 + (1.0 - x[:, :-1]) ** 2, axis=1)

    found = minimised(rosenbrock, 6, 12, 500, start=0.0)
    assert found.mean == pytest.approx(np.ones(6), abs=1e-3)
