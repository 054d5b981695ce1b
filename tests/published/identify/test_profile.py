"""How a fit grows worse, against a grid that SciPy fits the other parameters on."""

import numpy as np
import pytest
from carts import Cart, cart_fit, driven, forced, noisy
from scipy.optimize import minimize_scalar

from hfc_design.identify.certainty import certainty
from hfc_design.identify.profile import LIMIT, profiles

STEPS, NOISE = 400, 4e-3  # so short and so noisy that it is no parabola


def test_a_profile_is_that_of_a_grid():
    true = Cart(mass=2.6, viscous_friction=6.0)
    force = forced(STEPS)
    place = noisy(driven(true, force), NOISE, 8)
    one = cart_fit(["mass", "viscous_friction"], place, force)
    known = certainty(one.fit)

    def squares(mass, friction):
        return STEPS * np.var(place - driven(Cart(mass, friction), force))  # its zero is unknown

    def least(mass):
        bounds = np.log([0.01, 100.0])
        best = minimize_scalar(
            lambda x: squares(mass, np.exp(x)), bounds=bounds, method="bounded",
            options={"xatol": 1e-9},
        )  # fmt: skip
        return best.fun

    (profile,) = [own for own in profiles(one, known) if own.name == "mass"]
    middle = len(profile.values) // 2
    floor = least(profile.values[middle])
    grid = np.array([STEPS * (least(x) - floor) / floor for x in profile.values])
    grid /= known.inflated[0]
    np.testing.assert_allclose(profile.worse, grid, rtol=0.01, atol=1e-3)
    k = one.fit.free.names.index("mass")
    ends = np.interp([known.low[k], known.high[k]], *profile.supposed)
    assert ends == pytest.approx(LIMIT, rel=2e-3)  # straight lines between 61 points
    sides = profile.worse[[0, -1]]
    assert sides.max() / sides.min() > 1.02  # no parabola in the logarithm of the mass
    low, high = profile.interval
    for end in (low, high):  # between places the root of it is taken for a line
        assert STEPS * (least(end) - floor) / floor / known.inflated[0] == pytest.approx(
            LIMIT, rel=0.05
        )
