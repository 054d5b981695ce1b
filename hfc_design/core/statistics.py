"""Statistics of shares, of paired numbers and of many tests."""

from typing import NamedTuple

import numpy as np
import scipy  # which imports its parts when they are used

from hfc_design.core.numbers import Floats

#: Every interval contains the true value with at least this probability.
LEVEL = 0.95
#: Most pairs for which all combinations of signs are enumerated.
FEW = 13
Interval = tuple[float, float]


class Paired(NamedTuple):
    """Statistics of (n,) ratios of two quantities that were measured on the same n occasions."""

    ratio: float  # the median; nan if n is 0, or if it is the mean of 0 and infinity
    interval: Interval | None  # confidence interval of the median; None: n is too small
    p: float  # Wilcoxon's signed-rank test of the logarithms, two-sided


def share_interval(hits: int, count: int) -> Interval:
    """Return the confidence interval of a share: ``hits`` of ``count`` (Clopper & Pearson 1934).

    Exact: it contains the true share with a probability of at least ``LEVEL``, for every share.
    """
    if not count:
        return 0.0, 1.0
    low, high = scipy.stats.binomtest(hits, count).proportion_ci(LEVEL, method="exact")
    return float(low), float(high)


def median_interval(values: Floats) -> Interval | None:
    """Return the confidence interval of the median from (n,) ``values``; None if n is below six.

    Its ends are two of the ordered values; the binomial distribution gives the probability that the
    median is between them (the inverse of the sign test). The interval is exact, and infinite
    values are allowed.
    """
    place = int(scipy.stats.binom.ppf((1.0 - LEVEL) / 2.0, len(values), 0.5)) if len(values) else 0
    if not place:
        return None
    ranked = np.sort(values)
    return float(ranked[place - 1]), float(ranked[len(values) - place])


def paired(logarithms: Floats) -> Paired:
    """Return the statistics of ratios from their (n,) logarithms; infinite ones rank beyond all.

    Ratios of 1 (logarithm 0) are ranked too, but then count for neither side (Pratt 1959). p is
    exact up to ``FEW`` pairs, and up to 50 without ties; else it uses the normal approximation.
    """
    finite = np.abs(logarithms[np.isfinite(logarithms)])
    beyond = 2.0 * finite.max(initial=0.0) + 1.0
    p = _signed_ranks(np.clip(logarithms, -beyond, beyond))
    interval = median_interval(logarithms)
    with np.errstate(over="ignore"):
        low_high = interval and (float(np.exp(interval[0])), float(np.exp(interval[1])))
        return Paired(_median_ratio(logarithms), low_high, p)


def _signed_ranks(values: Floats) -> float:
    """Return the two-sided p of Wilcoxon's signed-rank test of (n,) ``values``."""
    if len(values) > FEW and values.any():
        return float(scipy.stats.wilcoxon(values, zero_method="pratt").pvalue)
    # All combinations of signs; SciPy takes seconds for them where values are tied.
    ranks = scipy.stats.rankdata(np.abs(values))[values != 0.0]
    signs = np.arange(2 ** len(ranks))[:, None] >> np.arange(len(ranks)) & 1
    sums, seen = signs @ ranks, ranks @ (values[values != 0.0] > 0.0)
    return float(min(2 * np.mean(sums <= seen), 2 * np.mean(sums >= seen), 1.0))


def _median_ratio(logarithms: Floats) -> float:
    if not len(logarithms):
        return float("nan")
    ranked = np.sort(logarithms)
    with np.errstate(invalid="ignore"):  # the mean of -inf and inf
        middle = 0.5 * (ranked[(len(ranked) - 1) // 2] + ranked[len(ranked) // 2])
    return float(np.exp(middle))


def holm(p: Floats) -> Floats:
    """Return (n,) p-values of n tests with Holm's step-down correction (Holm 1979)."""
    order = np.argsort(p, kind="stable")
    steps = np.maximum.accumulate(p[order] * (len(p) - np.arange(len(p))))
    corrected = np.empty(len(p))
    corrected[order] = np.minimum(steps, 1.0)
    return corrected
