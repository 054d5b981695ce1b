"""What is found in logs of a cart, against least squares by SciPy on its closed form."""

import numpy as np
import pytest
from carts import Cart, cart_fit, driven, forced, noisy
from scipy.optimize import curve_fit

from hfc_design.identify.identifiability import certainty

TRUE = Cart(mass=2.6, viscous_friction=6.0, force_gain=1.3, pull=-0.4)
NAMES, HELD = ["mass", "viscous_friction"], {"force_gain": 1.3, "pull": -0.4}
STEPS = 800


@pytest.mark.parametrize("bandwidth", [0.0, 5.0])
def test_a_delay_of_two_samples_is_found(bandwidth):
    force = forced(STEPS)
    late = driven(TRUE, np.r_[force[0], force[0], force[:-2]])
    one = cart_fit(NAMES, late, force, HELD, late=True, bandwidth=bandwidth)
    np.testing.assert_allclose(one.values, [2.6, 6.0], rtol=1e-3)
    assert one.late == pytest.approx(2.0, abs=0.01)


def test_mass_and_friction_are_those_of_scipy():
    """And their standard errors, under white noise."""
    force = forced(STEPS)
    place = noisy(driven(TRUE, force), 2e-4, 2)

    def model(_, mass, friction, zero):
        return zero + driven(TRUE._replace(mass=mass, viscous_friction=friction), force)

    values, covariance = curve_fit(model, np.arange(STEPS), place, p0=(2.0, 8.0, 0.0))
    fit = cart_fit(NAMES, place, force, HELD)
    np.testing.assert_allclose(fit.free.values(fit.numbers), values[:2], rtol=1e-6)
    known = certainty(fit)
    white = known.error * known.value / np.sqrt(known.inflated[:-2])
    np.testing.assert_allclose(white, np.sqrt(np.diag(covariance))[:2], rtol=0.01)
