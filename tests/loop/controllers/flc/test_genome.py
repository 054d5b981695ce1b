"""First, mutated, mixed and nudged tables of a feed drive: how their numbers are spread.

In closed form, where nothing meets a bound: the drive is so slow that its stable range takes the
published table as it is, and steps are small. What the bounds do is in test_search.py.
"""

import numpy as np
import pytest
import scipy.integrate
from chance import mean_is, normal, uniform
from scipy.stats import norm

from hfc_design.controllers.genome import taken
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import individuals

COUNT = 20_000
STEP = 1e-4
LARGEST, LARGEST_INTEGRAL = 127.0, 8.0  # of a command, of the gain
PLACES = np.linspace(-1.0, 1.0, 7)
#: A share between 1 / 49 and 1 that is uniform by its logarithm: its mean.
SHARE = (1 - 1 / 49) / np.log(49)
#: Cells of the published table that no sector bounds.
FREE = np.ix_([1, 5], [0, 1, 5, 6])
SLOW = ["plant.parameters.gain=10.0", "reference.feed_mm_min=100.0"]


@pytest.fixture(scope="module")
def own():
    """Of the kind that adapts, whose genome is that of the other with limits of its own."""
    kind = ["controller.kind=aflc", "controller.symmetric=false"]
    most = f"controller.largest_integral_gain={LARGEST_INTEGRAL}"
    return individuals.genome_of(load_scenario("feed-drive-circle", [*SLOW, *kind, most]))


def published(own, count=COUNT):
    """The published table, away from all bounds."""
    found = taken(own.empty(), np.zeros(count, int))
    found = found._replace(share=np.full(count, 0.9), k_i=np.ones(count))
    return own.blended(found, found, np.zeros(count))


def mutated(own, population, seed=21):
    step = np.full(len(population.tree), STEP)
    return own.mutated(population, step, np.random.default_rng(seed))


def test_the_first_ones_are_the_published_table_with_other_widths(own):
    """All widths of an input by one factor exp(n Z), n from 0 to 1, Z normal."""
    start, found = own.empty(), own.fresh(np.zeros(COUNT, int), np.random.default_rng(22))
    assert np.array_equal(found.joints[0], start.joints[0])
    factor = by_side(found.joints[..., 0] / start.joints[..., 0])
    for wider in (0.0, 0.5, 1.0):  # narrower ones may meet the smallest width
        share, _ = scipy.integrate.quad(lambda n, t=wider: norm.sf(t / n), 0.0, 1.0)
        mean_is(np.log(factor[1:, :, 0]) > wider, share)
    wide = (factor[..., 0] > 1.0)[..., None]
    np.testing.assert_allclose(np.where(wide, factor / factor[..., :1], 1.0), 1.0, rtol=1e-12)
    mean_is(wide[:, 0] * wide[:, 1], 0.25)  # the two inputs on their own


def test_the_first_integral_gains_and_shares(own):
    """Largest gain times n U^3, with n and U from 0 to 1; shares from 0.1 to 0.95."""
    found = own.fresh(np.zeros(COUNT, int), np.random.default_rng(23))
    uniform(found.share, 0.1, 0.95)
    gain = found.k_i / LARGEST_INTEGRAL
    assert gain[0] == 0.0
    assert 0.0 <= gain.min() <= gain.max() <= 1.0
    mean_is(gain, 1 / 2 * 1 / 4)
    mean_is(gain**2, 1 / 3 * 1 / 7)
    mean_is(gain**3, 1 / 4 * 1 / 10)


def by_side(joints):
    """(n, 12, ...) of seven terms a side as (n, 2, 6, ...)."""
    return joints.reshape(len(joints), 2, 6, *joints.shape[2:])


def test_mutation_widens_inputs_and_single_joints(own):
    before = published(own)
    found = mutated(own, before)
    width = by_side(np.log(found.joints[..., 0] / before.joints[..., 0]) / STEP)
    mean_is((np.abs(width) < 1e-9), np.full((2, 6), 0.7 * 0.8))
    mean_is(width**2, np.full((2, 6), 0.3 + 0.2))
    mean_is(width[:, 0, 0] * width[:, 0, 5], 0.3)  # what the joints of an input share
    mean_is(width[:, 0, 0] * width[:, 1, 0], 0.0)
    edges = by_side((found.joints[..., 1:] - before.joints[..., 1:]) / STEP)
    moved = np.abs(edges) > 1e-9
    mean_is(moved, np.full((2, 6, 2), 0.2))
    normal(edges[moved])


def test_mutation_moves_and_scales_commands(own):
    """Single ones, tilts along rows and columns and the whole, all by a quarter of the largest."""
    before = published(own)
    moved = (mutated(own, before).singletons - before.singletons) / (0.25 * LARGEST * STEP)
    table = before.singletons[0] / (0.25 * LARGEST)
    wanted = SHARE + 0.2 * (PLACES**2 + PLACES[:, None] ** 2 + table**2)
    mean_is(moved[:, *FREE], 0.0)
    mean_is(moved[:, *FREE] ** 2, wanted[FREE])
    both = table[1, 1] * table[5, 5] + PLACES[1] * PLACES[5] * 2
    mean_is(moved[:, 1, 1] * moved[:, 5, 5], 0.2 * both)
    still = np.abs(moved[:, *FREE]) < 1e-9
    mean_is(still, np.full((2, 4), 0.8**3 * (1 - SHARE)))


def test_mutation_of_integral_gain_and_share(own):
    """In 0.05 a new gain, in 0.3 of the others a step; in 0.3 another share."""
    before = published(own)
    found = mutated(own, before)
    off = np.log(found.k_i / before.k_i) / STEP
    new = np.abs(off) > 10.0
    mean_is(new, 0.05)
    uniform(np.cbrt(found.k_i[new] / LARGEST_INTEGRAL))
    near = off[~new]
    mean_is(near != 0.0, 0.3)
    normal(near[near != 0.0])
    shift = (found.share - before.share) / STEP
    mean_is(shift != 0.0, 0.3)
    normal(shift[shift != 0.0])


def test_mixing_goes_on_a_straight_line(own):
    start = published(own, 5)
    one, other = mutated(own, start, 24), mutated(own, start, 25)
    share = np.array([-0.25, 0.0, 0.3, 1.0, 1.25])
    found = own.blended(one, other, share)
    for part in ("joints", "singletons", "k_i", "share"):
        a, b, mixed = (np.moveaxis(getattr(p, part), 0, -1) for p in (one, other, found))
        if part == "singletons":
            a, b, mixed = a[FREE], b[FREE], mixed[FREE]
        assert (a != b).any()
        np.testing.assert_allclose(mixed, (1 - share) * a + share * b, rtol=1e-13, atol=1e-13)
