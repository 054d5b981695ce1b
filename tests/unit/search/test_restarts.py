"""Distributions that begin anew, on functions whose minima are known."""

import numpy as np
import pytest

from hfc_design.search.multistart_cma import ISLANDS, SAMPLES, multistart


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


@pytest.mark.parametrize("evaluations", [10, 200, 1000, 1234])
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
