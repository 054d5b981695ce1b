"""Random numbers against what they should be on average, at five standard deviations.

Seeds are fixed: a test that passes once always does, and what is wrong by chance alone one in two
million would see.
"""

import numpy as np
import scipy.stats

FIVE_SIGMA = 2.0 * scipy.stats.norm.sf(5.0)


def mean_is(samples, wanted):
    """Asserts the means of samples, which are independent along their first axis."""
    samples = np.asarray(samples, float)
    allowed = 5.0 * samples.std(axis=0) / np.sqrt(len(samples)) + 1e-12
    off = np.abs(samples.mean(axis=0) - wanted)
    assert (off <= allowed).all(), f"{samples.mean(axis=0)} is not {wanted}, +/- {allowed}"


def normal(samples):
    """Asserts that independent samples are standard normal."""
    found = np.ravel(samples)
    _like(found, "norm")
    mean_is(found, 0.0)
    mean_is(found**2, 1.0)  # to which the comparison above is nearly blind


def uniform(samples, low=0.0, high=1.0):
    """Asserts that independent samples are uniform between two bounds."""
    found = (np.ravel(samples) - low) / (high - low)
    _like(found, "uniform")
    mean_is(found, 1 / 2)
    mean_is(found**2, 1 / 3)
    nothing = 15.0 / len(found)  # one in three million leaves a gap as wide at an end
    assert 0.0 <= found.min() < nothing
    assert 1.0 - nothing < found.max() <= 1.0


def _like(samples, name):
    found = scipy.stats.kstest(samples, name)
    assert found.pvalue > FIVE_SIGMA, found
