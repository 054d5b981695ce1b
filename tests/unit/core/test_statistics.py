"""Intervals and tests against enumeration, published tables and SciPy's other ways to them."""

from itertools import product
from math import comb

import numpy as np
import pytest
import scipy.stats

from hfc_design.core.statistics import holm, median_interval, paired, share_interval


def test_holm_by_hand():
    # 0.01 * 4; 0.02 * 3; 0.03 * 2 is less than that, so the same; 0.9 * 1
    assert holm(np.array([0.03, 0.01, 0.9, 0.02])) == pytest.approx([0.06, 0.04, 0.9, 0.06])
    assert holm(np.array([0.8, 0.7])) == pytest.approx([1.0, 1.0])
    assert len(holm(np.empty(0))) == 0


@pytest.mark.parametrize(("hits", "count"), [(0, 10), (3, 10), (10, 10), (197, 200)])
def test_a_share_just_inside_is_not_refused_by_the_binomial_tails(hits, count):
    def tail(share, places):
        return sum(comb(count, k) * share**k * (1 - share) ** (count - k) for k in places)

    low, high = share_interval(hits, count)
    assert 0.0 <= low <= hits / count <= high <= 1.0
    if hits:
        assert tail(low, range(hits, count + 1)) == pytest.approx(0.025)
    else:
        assert low == 0.0
    if hits < count:
        assert tail(high, range(hits + 1)) == pytest.approx(0.025)
    else:
        assert high == 1.0


def test_nothing_says_nothing_of_a_share():
    assert share_interval(0, 0) == (0.0, 1.0)


@pytest.mark.parametrize(("count", "place"), [(6, 1), (8, 1), (9, 2), (20, 6), (100, 40)])
def test_the_ranks_of_the_median_are_those_of_the_sign_test(count, place):
    """As the tables of the sign test have them (Conover 1999, A3)."""
    values = np.random.default_rng(count).permutation(np.arange(1.0, count + 1))
    assert median_interval(values) == (place, count + 1 - place)
    assert 2 * scipy.stats.binom.cdf(place - 1, count, 0.5) <= 0.05
    assert 2 * scipy.stats.binom.cdf(place, count, 0.5) > 0.05


def test_five_values_have_no_interval():
    assert median_interval(np.arange(5.0)) is None


def test_signed_ranks_by_enumeration():
    values = np.array([0.3, -0.1, 0.7, 0.5, 0.9, -0.2, 1.1])
    ranks = scipy.stats.rankdata(np.abs(values))
    seen = ranks[values > 0].sum()
    sums = [ranks[np.array(signs)].sum() for signs in product([True, False], repeat=7)]
    p = 2 * min(np.mean(np.array(sums) >= seen), np.mean(np.array(sums) <= seen))
    assert paired(values).p == pytest.approx(p)
    assert paired(values).ratio == pytest.approx(np.exp(0.5))


@pytest.mark.parametrize("values", [[0.0, 0.0, 1.0, 2.0, 2.0], [np.inf, np.inf, -1.0, 0.0], [3.0]])
def test_signed_ranks_with_ties_and_zeros_by_enumeration(values):
    values = np.array(values)
    ranks = scipy.stats.rankdata(np.abs(values))
    seen, moved = ranks[values > 0].sum(), ranks[values != 0]
    signs = product([True, False], repeat=len(moved))
    sums = np.array([moved[np.array(own)].sum() for own in signs])
    p = 2 * min(np.mean(sums >= seen), np.mean(sums <= seen))
    assert paired(values).p == pytest.approx(min(p, 1.0))


def test_who_fails_loses_by_more_than_any_other():
    values = np.log([0.5, 0.8, 0.9, 1.2, 0.7, 0.6])
    lost = paired(np.append(values, np.inf))
    far = paired(np.append(values, 100.0))
    assert lost.p == far.p
    assert lost.ratio == pytest.approx(0.8)
    assert lost.interval == (0.5, np.inf)
    assert paired(np.full(9, np.inf)).ratio == np.inf
    assert paired(np.full(9, -np.inf))[:2] == (0.0, (0.0, 0.0))


def test_equal_pairs_decide_nothing():
    assert paired(np.zeros(30)) == (1.0, (1.0, 1.0), 1.0)
    none = paired(np.empty(0))
    assert np.isnan(none.ratio)
    assert none[1:] == (None, 1.0)
    # Pratt's ranks: the zeros lift those of the others, which still are one-sided.
    few = paired(np.append(np.zeros(5), np.arange(1.0, 11.0)))
    assert 1e-3 < few.p < 0.02
