"""Fits that tell little: slopes that are lost, alike or not finite, values at 0, bounds."""

import numpy as np
import pytest
from carts import CART
from wording import refused

from hfc_design.identify.fit import VAGUE, Fit, covariance_of
from hfc_design.identify.identifiability import certainty, errors_of, root_of, unseen
from hfc_design.identify.identified import _check_slopes
from hfc_design.identify.parameters import free
from plants import PLANTS

STEPS = 800
WAVES = np.stack([np.sin(0.02 * k * np.arange(STEPS)) for k in (1, 2, 3)], axis=1)


def fit_of(slopes, names=("mass", "viscous_friction", "force_gain")):
    """A fit with slopes (steps, names), white noise of 1, and no slope by delay and lag."""
    residual = np.random.default_rng(0).normal(0.0, 1.0, (STEPS, 1))
    wanted = free(CART, {}, names)
    slopes = np.append(slopes, np.zeros((STEPS, 2)), axis=1)[:, None]
    return Fit(wanted, np.zeros(len(names) + 2), residual, slopes, np.ones(1), 1)


def test_what_is_not_told_is_seen_beside_what_is_told_very_well():
    """Sum of two numbers to 1e-11, their difference not: each is off by VAGUE / sqrt(2).

    In the normal matrix, of 1e22, the difference would be known to 1e-3.
    """
    wave = WAVES[:, :1] / np.linalg.norm(WAVES[:, 0])
    fit = fit_of(1e11 * wave @ np.ones((1, 2)), ("mass", "viscous_friction"))
    expected = VAGUE / np.sqrt(2.0)
    covariance, inflated = covariance_of(fit)
    errors = [expected, expected, VAGUE, VAGUE]
    assert np.sqrt(np.diag(covariance)) == pytest.approx(errors, rel=1e-6)
    assert inflated == pytest.approx(1.0, rel=1e-6)
    assert errors_of(root_of(fit.jacobian, fit.scale))[:2] == pytest.approx(expected, rel=1e-6)
    known = certainty(fit)
    assert known.told == (False, False)
    assert known.untold[0].shares == pytest.approx({"mass": 1.0, "viscous_friction": -1.0})


def test_no_variance_is_negative_however_far_slopes_lie_apart():
    rng = np.random.default_rng(1)
    for _ in range(20):
        sizes = 10.0 ** rng.uniform(-12, 12, 3)
        mixed = WAVES @ np.diag(sizes) @ np.linalg.qr(rng.normal(size=(3, 3)))[0]
        covariance, inflated = covariance_of(fit_of(mixed))
        assert (np.diag(covariance) > 0.0).all()
        assert np.isfinite(covariance).all()
        assert (inflated > 0.0).all()


def test_a_parameter_without_a_slope_is_not_told_and_the_others_are():
    fit = fit_of(WAVES * [3.0, 0.0, 2.0])
    known = certainty(fit)
    assert known.told == (True, False, True)
    assert known.untold[0].shares == {"viscous_friction": 1.0}
    assert unseen(fit).tolist() == [False, True, False]
    # Least squares of two orthogonal columns.
    errors = 1.0 / np.linalg.norm(WAVES[:, [0, 2]] * [3.0, 2.0], axis=0)
    sandwich = np.sqrt(known.inflated[[0, 2]])
    np.testing.assert_allclose(known.error[[0, 2]], errors * sandwich, rtol=0.02)


def test_a_slope_that_is_no_number_is_named():
    slopes = WAVES.copy()
    slopes[7, 1] = np.nan
    with refused(ValueError):
        _check_slopes(fit_of(slopes))
    _check_slopes(fit_of(WAVES))


def test_only_what_units_explain_is_said_to_be_far_from_where_it_began():
    """Machines of 97 times the mass of the built-in stage exist, and of 0.004 times the drag."""
    wanted = free(CART, {}, ("mass", "viscous_friction"))
    for factor, told in ((97.3, 0), (0.0042, 0), (1.5, 0), (1020.0, 1), (1e-3, 1), (1 / 57, 1)):
        numbers = np.append(np.log([factor, 1.0]), [0.0, 0.0])
        assert list(wanted.away(numbers)) == ["mass"] * told


def test_what_is_not_looked_for_is_said_with_its_value():
    """A mass beside a wrong gain is wrong by the same factor; exact ones are known."""
    stage = PLANTS["positioning-stage"]
    told = free(stage, {"offset": -2.0}, ["mass", "coulomb_friction"]).rest()
    assert told.startswith("not looked for: ")
    for words in ("amplifier_gain 35.1507 N/V", "offset -2 N", "viscous_friction 203.5 N s/m"):
        assert words in told
    assert "mass" not in told
    every = [name for name in stage.parameters._fields if name not in stage.exact]
    assert free(stage, {"stiction_rise": 1.0}, every).rest() == ""
