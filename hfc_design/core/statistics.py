"""Statistics of shares, of paired numbers and of many tests; SciPy is imported when used."""

from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats

#: Every interval holds what it is of with at least this probability.
LEVEL = 0.95
#: Pairs whose signs are all tried.
FEW = 13
Interval = tuple[float, float]


class Paired(NamedTuple):
    """Distribution of (n,) ratios of two things on the same n occasions, relative to 1."""

    ratio: float  # the median; nan of nothing, or between 0 and infinity
    interval: Interval | None  # of the median; None where n is too small for one
    p: float  # Wilcoxon's signed-rank test of the logarithms, two-sided


def share_interval(hits: int, count: int) -> Interval:
    """Confidence interval of a share from ``hits`` of ``count`` (Clopper & Pearson 1934).

    Exact: it contains the true share with a probability of at least ``LEVEL``, for every share.
    """
    from scipy.stats import binomtest

    if not count:
        return 0.0, 1.0
    low, high = binomtest(hits, count).proportion_ci(LEVEL, method="exact")
    return float(low), float(high)


def median_interval(values: Floats) -> Interval | None:
    """Confidence interval of the median from a sample of (n,) ``values``; None for fewer than six.

    Its ends are two of the ordered values; the binomial distribution gives the probability that the
    median is between them (the sign test turned around). It is exact, and infinite values are
    allowed.
    """
    from scipy.stats import binom

    place = int(binom.ppf((1.0 - LEVEL) / 2.0, len(values), 0.5)) if len(values) else 0
    if not place:
        return None
    ranked = np.sort(values)
    return float(ranked[place - 1]), float(ranked[len(values) - place])


def paired(logarithms: Floats) -> Paired:
    """Test of (n,) logarithms of ratios, infinite ones too: these rank beyond all others.

    Equal pairs (0) keep their ranks and then count for neither side (Pratt 1959). p is exact up to
    ``FEW`` pairs, and up to 50 without ties; else it is by the normal approximation.
    """
    finite = np.abs(logarithms[np.isfinite(logarithms)])
    beyond = 2.0 * finite.max(initial=0.0) + 1.0
    p = _signed_ranks(np.clip(logarithms, -beyond, beyond))
    interval = median_interval(logarithms)
    with np.errstate(over="ignore"):
        low_high = interval and (float(np.exp(interval[0])), float(np.exp(interval[1])))
        return Paired(_median_ratio(logarithms), low_high, p)


def _signed_ranks(values: Floats) -> float:
    """The two-sided p of Wilcoxon's test."""
    from scipy.stats import rankdata, wilcoxon

    if len(values) > FEW and values.any():
        return float(wilcoxon(values, zero_method="pratt").pvalue)
    # All signs: SciPy takes seconds for that where values are tied.
    ranks = rankdata(np.abs(values))[values != 0.0]
    signs = np.arange(2 ** len(ranks))[:, None] >> np.arange(len(ranks)) & 1
    sums, seen = signs @ ranks, ranks @ (values[values != 0.0] > 0.0)
    return float(min(2 * np.mean(sums <= seen), 2 * np.mean(sums >= seen), 1.0))


def _median_ratio(logarithms: Floats) -> float:
    if not len(logarithms):
        return float("nan")
    ranked = np.sort(logarithms)
    with np.errstate(invalid="ignore"):  # one of each infinity
        middle = 0.5 * (ranked[(len(ranked) - 1) // 2] + ranked[len(ranked) // 2])
    return float(np.exp(middle))


def holm(p: Floats) -> Floats:
    """Holm's step-down correction of (n,) p-values for n tests (Holm 1979)."""
    order = np.argsort(p, kind="stable")
    steps = np.maximum.accumulate(p[order] * (len(p) - np.arange(len(p))))
    corrected = np.empty(len(p))
    corrected[order] = np.minimum(steps, 1.0)
    return corrected
