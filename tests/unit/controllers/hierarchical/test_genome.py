"""First, mutated, mixed and nudged hierarchies: how their numbers are spread, in closed form."""

import numpy as np
import pytest
from chance import mean_is, normal, uniform

from hfc_design.controllers.genome import taken
from hfc_design.controllers.hierarchical import tree as hierarchy
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import individuals

COUNT = 10_000
LIMITS = np.array([4.0, 4.0, 4.0, 20.0])  # of the units, the root last
SCALES = np.array([50.0, 80.0, 20.0, 20.0, 10.0])
STEP = 0.01  # so small that nothing meets a limit
CELLS = 4 * 7 * 7
#: A share between 1 / CELLS and 1 that is uniform by its logarithm: its mean, that of its square.
SHARE = (1 - 1 / CELLS) / np.log(CELLS)
SHARE_SQUARED = (1 - 1 / CELLS**2) / (2 * np.log(CELLS))
TERMS = np.array([-1.0, -0.6, -0.2, 0.0, 0.2, 0.6, 1.0])  # centres, LL eq. 3
TABLE_MOVES = 0.1  # of all tables are shifted, as many tilted along columns, as many along rows


def genome(*changes):
    return individuals.genome_of(load_scenario("c-axis-ramp", list(changes)))


def fresh(own, count=COUNT):
    rng = np.random.default_rng(11)
    return own.fresh(rng.integers(own.structures, size=count), rng)


def nought(own, count=COUNT):
    """Individuals whose tables are zero."""
    found = fresh(own, count)
    return found._replace(consequents=0.0 * found.consequents)


def mutated(own, population, step=STEP):
    return own.mutated(population, np.full(len(population.tree), step), np.random.default_rng(12))


def test_first_gains_and_scales_are_uniform_by_their_logarithm():
    found = fresh(genome("search.kp_range=[50.0, 5000.0]"))
    uniform(np.log10(found.gains[:, 0]), np.log10(50.0), np.log10(5000.0))
    uniform(np.log10(found.gains[:, 1]), np.log10(30.0), np.log10(3000.0))
    for scales, nominal in zip(found.scales.T, SCALES, strict=True):
        uniform(np.log10(scales / nominal), -1.0, 1.0)
    fixed = fresh(genome("search.scale_range=1.0"), 10)
    assert (fixed.scales == SCALES).all()
    draws = np.log(np.concatenate([found.gains, found.scales], axis=1))
    assert np.abs(np.corrcoef(draws.T) - np.eye(7)).max() < 5 / np.sqrt(COUNT)


def test_first_tables_are_tilted_planes():
    """Level 0.5 L, slopes 0.7 C and 0.7 R of the limit with L, C, R from -1 to 1; noise 0.05."""
    table = fresh(genome()).consequents
    middle = table[:, :, 3, 3]
    along_row = table[:, :, 3, 4] - table[:, :, 3, 2]
    along_column = table[:, :, 4, 3] - table[:, :, 2, 3]
    noise = 0.05**2
    mean_is(middle, 0.0)
    mean_is(middle**2, (0.5 * LIMITS) ** 2 / 3 + noise)
    for slope in (along_row, along_column):
        mean_is(slope, 0.0)
        mean_is(slope**2, (0.7 * LIMITS * 0.4) ** 2 / 3 + 2 * noise)
        mean_is(slope * middle, 0.0)
    mean_is(along_row * along_column, 0.0)
    bend = table[:, :, 3, 4] - 2 * middle + table[:, :, 3, 2]  # of a plane none
    normal(bend / np.sqrt(6 * noise))


def test_mutation_scales_half_of_the_gains_and_a_fifth_of_the_inputs():
    own = genome()
    before = fresh(own)
    found = mutated(own, before, 0.2)
    for part, share in (("gains", 0.5), ("scales", 0.2)):
        moved = np.log(getattr(found, part) / getattr(before, part)) / (0.5 * 0.2)
        mean_is(moved != 0.0, share)
        normal(moved[moved != 0.0])
    assert np.array_equal(found.tree, before.tree)
    fixed = genome("search.scale_range=1.0")
    assert np.array_equal(mutated(fixed, before).scales, before.scales)


def test_mutation_moves_single_consequents_and_whole_tables():
    own = genome()
    moved = mutated(own, nought(own)).consequents / STEP
    still = moved == 0.0
    off_centre = TERMS != 0.0
    both = still[:, :, off_centre][:, :, :, off_centre]
    mean_is(both.mean(axis=(1, 2, 3)), (1 - SHARE) * (1 - TABLE_MOVES) ** 3)
    mean_is(still[:, :, 3, 3], (1 - SHARE) * (1 - TABLE_MOVES))
    # Two cells of a table rest together more often than two of their own accord: an individual
    # has one share for all its cells, from one cell to all of them.
    pair = still[:, :, 1, 2] & still[:, :, 5, 1]
    mean_is(pair, (1 - 2 * SHARE + SHARE_SQUARED) * (1 - TABLE_MOVES) ** 3)


def test_mutation_moves_by_its_step():
    """A cell by the step; a table's level and slopes by the root of its limit times the step."""
    own = genome()
    moved = mutated(own, nought(own)).consequents / STEP
    lever = 1.0 + TERMS**2 + TERMS[:, None] ** 2
    mean_is(moved, np.zeros_like(moved[0]))
    mean_is(moved**2, SHARE + TABLE_MOVES * LIMITS[:, None, None] * lever)
    # Opposite cells share a shift, and each slope with the other sign.
    mean_is(moved[:, :, 3, 0] * moved[:, :, 3, 6], 0.0)
    mean_is(moved[:, :, 0, 3] * moved[:, :, 6, 3], 0.0)
    mean_is(moved[:, :, 0, 0] * moved[:, :, 6, 6], -TABLE_MOVES * LIMITS)


@pytest.mark.parametrize("inputs", [2, 4])
def test_wild_mutation_keeps_every_limit(inputs):
    names = list(zip(("error", "deflection", "deflection_rate", "current"), SCALES, strict=False))
    layout = ", ".join(f"{{name='{name}', scale={scale}}}" for name, scale in names[:inputs])
    own = genome(f"controller.inputs=[{layout}]", "search.inner_limit=0.5", "search.root_limit=3.0")
    found = fresh(own, 300)
    for _ in range(3):
        found = mutated(own, found, 1.0)
    largest = np.abs(found.consequents).max(axis=(0, 2, 3))
    assert largest.tolist() == [0.5] * (inputs - 2) + [3.0]
    assert found.tree.max() < own.structures == len(hierarchy.trees(inputs))
    assert (found.gains > 0).all()
    assert (found.scales > 0).all()


def test_mixing_is_geometric_in_gains_and_straight_in_tables():
    own = genome()
    one, other = fresh(own, 5), taken(fresh(own, 10), slice(5, 10))
    share = np.array([-0.25, 0.0, 0.3, 1.0, 1.25])
    found = own.blended(one, other, share)
    assert np.array_equal(found.tree, one.tree)
    for k, s in enumerate(share):
        for part in ("gains", "scales"):
            a, b = getattr(one, part)[k], getattr(other, part)[k]
            np.testing.assert_allclose(getattr(found, part)[k], a ** (1 - s) * b**s, rtol=1e-12)
        mixed = (1 - s) * one.consequents[k] + s * other.consequents[k]
        np.testing.assert_allclose(found.consequents[k], mixed, atol=1e-12)
