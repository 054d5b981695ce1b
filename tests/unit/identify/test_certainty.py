"""Intervals and what is not told: against exact variances, and combinations known by hand."""

import numpy as np
import pytest
from carts import CART

from hfc_design.identify.fit import VAGUE, Fit, covariance_of
from hfc_design.identify.parameters import free

STEPS, LEFT = 4000, 0.9  # samples; what is left of a disturbance after a sample


def coloured(share):
    """(logs, steps) residuals, each ``share`` of the one before and white noise."""
    noise = np.random.default_rng(5).normal(0.0, 1.0, (40, STEPS))
    for k in range(1, STEPS):
        noise[:, k] += share * noise[:, k - 1]
    return noise


@pytest.mark.parametrize("share", [0.0, LEFT])
def test_coloured_residuals_are_counted(share):
    """The variance of a slow sine's share: J'RJ / (J'J)^2, R = share^|lag| / (1 - share^2).

    Weights of Newey and West that fall to 0 at 2 % of the log leave out some of it, by hand.
    """
    wave = np.sin(2.0 * np.pi * 7.0 * np.arange(STEPS) / STEPS)
    lags, pairs = np.abs(np.arange(1 - STEPS, STEPS)), np.correlate(wave, wave, "full")
    true = share**lags / (1.0 - share**2)
    weighed = true * np.maximum(1.0 - lags / (0.02 * STEPS), 0.0)
    exact, expected = (r @ pairs / (wave @ wave) ** 2 for r in (true, weighed))
    assert 0.85 * exact < expected <= exact
    wanted = free(CART, {}, ["mass"])
    slopes = np.stack([wave, *np.zeros((2, STEPS))], axis=1)[:, None]
    variances, inflated = [], []
    for residual in coloured(share):
        scale = np.array([residual.std()])
        fit = Fit(wanted, np.zeros(3), residual[:, None], slopes, scale, 1)
        covariance, more = covariance_of(fit)
        variances.append(covariance[0, 0])
        inflated.append(more[0])
    assert np.mean(variances) == pytest.approx(expected, rel=0.06)
    white = expected * (wave @ wave) * (1.0 - share**2)  # ordinary least squares have 1
    assert np.mean(inflated) == pytest.approx(white, rel=0.06)


@pytest.mark.parametrize(("sign", "middle"), [(-1.0, 1.99), (1.0, 198.01)])
def test_newey_and_west_by_hand(sign, middle):
    """100 samples, so lags of 0 and 1 with weights 1 and 1/2; a mean of +1 -1 +1 ... or of +1.

    The products of neighbours add up to +-99: 100 + 2 (1/2) 99 (+-99 / 100) around the mean.
    """
    wanted = free(CART, {}, ["mass"])
    slopes = np.stack([np.ones(100), *np.zeros((2, 100))], axis=1)[:, None]
    residual = sign ** np.arange(100.0)
    fit = Fit(wanted, np.zeros(3), residual[:, None], slopes, np.ones(1), 1)
    covariance, inflated = covariance_of(fit)
    before = VAGUE**-2
    assert covariance[0, 0] == pytest.approx((middle + before) / (100.0 + before) ** 2, rel=1e-12)
    assert inflated[0] == pytest.approx((middle + before) / (100.0 + before), rel=1e-12)
