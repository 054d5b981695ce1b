"""Intervals against exact variances; slopes that are lost, alike or not finite."""

import numpy as np
import pytest
from carts import CART, fit_with
from wording import refused

from hfc_design.identify.fit import VAGUE, covariance_of
from hfc_design.identify.identifiability import certainty, unseen
from hfc_design.identify.identified import check_slopes
from hfc_design.identify.parameters import free_parameters

NAMES = ("mass", "viscous_friction", "force_gain")
WAVES = np.stack([np.sin(0.02 * k * np.arange(800)) for k in (1, 2, 3)], axis=1)


def fit_of(slopes, names=NAMES, residual=None, scale=1.0):
    """A fit with slopes (steps, names), white noise of 1, and no slope by delay and lag."""
    steps = len(slopes)
    noise = np.random.default_rng(0).normal(0.0, 1.0, steps) if residual is None else residual
    return fit_with(
        free_parameters(CART, {}, names),
        noise,
        np.append(slopes, np.zeros((steps, 2)), axis=1),
        scale=scale,
    )


def coloured(share, steps):
    """(logs, steps) residuals, each ``share`` of the one before and white noise."""
    noise = np.random.default_rng(5).normal(0.0, 1.0, (40, steps))
    for k in range(1, steps):
        noise[:, k] += share * noise[:, k - 1]
    return noise


@pytest.mark.parametrize("share", [0.0, 0.9])
def test_coloured_residuals_are_counted(share):
    """The variance of a slow sine's share: J'RJ / (J'J)^2, R = share^|lag| / (1 - share^2).

    Weights of Newey and West that fall to 0 at 2 % of the log leave out some of it, by hand.
    """
    steps = 4000
    wave = np.sin(2.0 * np.pi * 7.0 * np.arange(steps) / steps)
    lags, pairs = np.abs(np.arange(1 - steps, steps)), np.correlate(wave, wave, "full")
    true = share**lags / (1.0 - share**2)
    weighed = true * np.maximum(1.0 - lags / (0.02 * steps), 0.0)
    exact, expected = (r @ pairs / (wave @ wave) ** 2 for r in (true, weighed))
    assert 0.85 * exact < expected <= exact
    fits = (fit_of(wave[:, None], ["mass"], x, x.std()) for x in coloured(share, steps))
    variances, inflated = zip(*map(covariance_of, fits), strict=True)
    assert np.mean([x[0, 0] for x in variances]) == pytest.approx(expected, rel=0.06)
    white = expected * (wave @ wave) * (1.0 - share**2)  # ordinary least squares have 1
    assert np.mean([x[0] for x in inflated]) == pytest.approx(white, rel=0.06)


@pytest.mark.parametrize(("sign", "middle"), [(-1.0, 1.99), (1.0, 198.01)])
def test_newey_and_west_by_hand(sign, middle):
    """100 samples, so lags of 0 and 1 with weights 1 and 1/2; a mean of +1 -1 +1 ... or of +1.

    The products of neighbours add up to +-99: 100 + 2 (1/2) 99 (+-99 / 100) around the mean.
    """
    fit = fit_of(np.ones((100, 1)), ["mass"], sign ** np.arange(100.0))
    covariance, inflated = covariance_of(fit)
    before = VAGUE**-2
    assert covariance[0, 0] == pytest.approx((middle + before) / (100.0 + before) ** 2, rel=1e-12)
    assert inflated[0] == pytest.approx((middle + before) / (100.0 + before), rel=1e-12)


def test_what_is_not_told_is_seen_beside_what_is_told_very_well():
    """Sum of two numbers to 1e-11, their difference not: each is off by VAGUE / sqrt(2).

    In the normal matrix, of 1e22, the difference would be known to 1e-3.
    """
    wave = WAVES[:, :1] / np.linalg.norm(WAVES[:, 0])
    fit = fit_of(1e11 * wave @ np.ones((1, 2)), NAMES[:2])
    expected = VAGUE / np.sqrt(2.0)
    covariance, inflated = covariance_of(fit)
    errors = [expected, expected, VAGUE, VAGUE]
    assert np.sqrt(np.diag(covariance)) == pytest.approx(errors, rel=1e-6)
    assert inflated == pytest.approx(1.0, rel=1e-6)
    known = certainty(fit)
    assert known.state == ("no", "no")
    assert known.untold[0].shares == pytest.approx({"mass": 1.0, "viscous_friction": -1.0})


def test_a_parameter_without_a_slope_is_not_told_and_the_others_are():
    fit = fit_of(WAVES * [3.0, 0.0, 2.0])
    known = certainty(fit)
    assert known.state == ("yes", "no", "yes")
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
        check_slopes(fit_of(slopes))
    check_slopes(fit_of(WAVES))


def test_no_variance_is_negative_however_far_slopes_lie_apart():
    rng = np.random.default_rng(1)
    for _ in range(20):
        sizes = 10.0 ** rng.uniform(-12, 12, 3)
        mixed = WAVES @ np.diag(sizes) @ np.linalg.qr(rng.normal(size=(3, 3)))[0]
        covariance, inflated = covariance_of(fit_of(mixed))
        assert (np.diag(covariance) > 0.0).all()
        assert np.isfinite(covariance).all()
        assert (inflated > 0.0).all()
