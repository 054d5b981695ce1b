"""First, mutated, mixed and nudged gains: how they are spread in their ranges, in closed form."""

import numpy as np
from chance import mean_is, normal, uniform

from hfc_design.controllers.genome import taken
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import individuals

COUNT = 20_000
RANGES = "{k_p=[0.1, 1000.0], k_i=[0.0, 8.0], k_d=[-1.0, 3.0]}"
GENOME = individuals.genome_of(
    load_scenario("feed-drive-line", [f"controller={{kind='pid', ranges={RANGES}}}"])
)


def middle(count=COUNT):
    return taken(GENOME.empty(), np.zeros(count, int))


def mutated(population, step, seed=31):
    return GENOME.mutated(population, np.full(COUNT, step), np.random.default_rng(seed))


def test_first_gains_fill_their_ranges():
    """Uniform: by its logarithm a gain that is always above zero, else by itself."""
    found = GENOME.gains(GENOME.fresh(np.zeros(COUNT, int), np.random.default_rng(32)))
    uniform(np.log10(found.k_p), -1.0, 3.0)
    uniform(found.k_i, 0.0, 8.0)
    uniform(found.k_d, -1.0, 3.0)
    places = np.stack([np.log10(found.k_p), found.k_i, found.k_d])
    assert np.abs(np.corrcoef(places) - np.eye(3)).max() < 5 / np.sqrt(COUNT)


def test_mutation_moves_seven_of_ten_gains_by_half_a_step():
    before = middle()
    moved = (mutated(before, 0.1).places - before.places) / (0.5 * 0.1)
    mean_is(moved != 0.0, np.full(3, 0.7))
    normal(moved[moved != 0.0])


def test_mutation_ends_at_the_ends_of_the_ranges():
    """From the middle, an end is one standard deviation away."""
    found = mutated(middle(), 1.0).places
    for end in (0.0, 1.0):
        mean_is(found == end, np.full(3, 0.7 * 0.15865525393145707))
    assert found.min() == 0.0
    assert found.max() == 1.0


def test_mixing_goes_on_a_straight_line_within_the_ranges():
    rng = np.random.default_rng(33)
    one, other = (GENOME.fresh(np.zeros(500, int), rng) for _ in range(2))
    share = rng.uniform(-0.25, 1.25, 500)
    line = one.places.T * (1 - share) + other.places.T * share
    found = GENOME.blended(one, other, share).places.T
    np.testing.assert_allclose(found, line.clip(0.0, 1.0), atol=1e-15)
    assert (found != line).any()


def test_a_double_is_a_millionth_of_the_ranges_off():
    before = middle()
    off = GENOME.nudged(before, np.random.default_rng(34)).places - before.places
    normal(off / 1e-6)
