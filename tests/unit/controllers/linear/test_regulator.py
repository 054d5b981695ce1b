"""Regulators of a model that is reduced by hand, and SciPy's Riccati equation."""

from math import nan

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from hfc_design.controllers.linear.regulator import measured, regulators
from hfc_design.stability.nominal import Nominal, Steady

T, PULL, LEFT, BRAKE, DRIVEN, STRAIGHT = 0.01, 30.0, 0.2, 0.5, 2.0, 0.1

#: A position, its velocity, and a current that is fast: p' = p + T v, v' = v + T PULL i + STRAIGHT
#: u, i' = LEFT i - BRAKE v + DRIVEN u.
MODEL = Nominal(
    1.0,
    np.array([[1.0, T, 0.0], [0.0, 1.0, T * PULL], [0.0, -BRAKE, LEFT]]),
    np.array([0.0, STRAIGHT, DRIVEN]),
    {
        "error": np.array([-1.0, 0.0, 0.0]),
        "error_rate": np.array([0.0, -1.0, 0.0]),
        "current": np.array([0.0, 0.0, 1.0]),
    },
    *[Steady(nan, np.full(3, nan))] * 4,
)


def test_what_is_not_measured_is_settled():
    """The current is (DRIVEN u - BRAKE v) / (1 - LEFT)."""
    found, force = measured(MODEL, [], "design"), T * PULL / (1.0 - LEFT)
    assert found.names == ("error", "error_rate")
    np.testing.assert_allclose(found.a, [[1.0, T], [0.0, 1.0 - force * BRAKE]], atol=1e-14)
    np.testing.assert_allclose(found.b, [0.0, -STRAIGHT - force * DRIVEN], atol=1e-14)


def test_what_is_measured_keeps_its_own_motion():
    found = measured(MODEL, None, "design")
    assert found.names == ("error", "error_rate", "current")
    turn = np.diag([-1.0, -1.0, 1.0])
    np.testing.assert_allclose(found.a, turn @ MODEL.a @ turn, atol=1e-14)
    np.testing.assert_allclose(found.b, turn @ MODEL.b, atol=1e-14)


@pytest.mark.parametrize("names", [[], None])
def test_gains_are_those_of_the_riccati_equation(names):
    model, random = measured(MODEL, names, "design"), np.random.default_rng(1)
    b, weights = model.b[:, None], random.uniform(0.1, 10.0, (5, len(model.b)))
    for own, found in zip(weights, regulators(model, weights), strict=True):
        value = solve_discrete_are(model.a, b, np.diag(own**2), np.eye(1))
        wanted = -(b.T @ value @ model.a) / (1.0 + b.T @ value @ b)
        np.testing.assert_allclose(found, wanted[0], rtol=1e-8)
