"""A polish against problems whose answer is known, and what it may never do."""

import itertools

import numpy as np
import pytest
import scipy.optimize
from threadpoolctl import threadpool_limits

from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.individuals import genome_of
from hfc_design.search.coordinates import chain, coordinates
from hfc_design.search.polish import Polishable, Quadratic, polish, proposals

RNG = np.random.default_rng(11)
NAMES = ("error", "deflection", "spindle_velocity")
INPUTS = {"controller.inputs": [{"name": name, "scale": 10.0} for name in NAMES]}
HIERARCHY = genome_of(load_scenario("c-axis-ramp", INPUTS))
ONE = HIERARCHY.fresh(np.array([1]), np.random.default_rng(0))
START = HIERARCHY.space().vectors(ONE)[0]
FIRST = 2 + len(NAMES)  # of the consequents, which have bounds
#: Residuals that are linear in the numbers, with heavy tails: least squares is far off.
SOME = FIRST + RNG.permutation(len(START) - FIRST)[:12]
ROWS = np.zeros((90, len(START)))
ROWS[:, SOME] = RNG.standard_normal((90, 12))
OFF = ROWS[:, SOME] @ (-1.5 * START[SOME]) + 0.05 * RNG.standard_t(2, 90)


@pytest.fixture(autouse=True)
def alone():
    """Threads wait for each other longer than products of such matrices take."""
    with threadpool_limits(1):
        yield


def residuals(population):
    """(n, rows) of the numbers, each in shares of what it began with."""
    return (HIERARCHY.space().vectors(population) - START) @ ROWS.T - OFF


def cost(population):
    return np.abs(residuals(population)).sum(axis=1)


def derived(population, rng):
    (error,) = residuals(population)
    weight = 1.0 / np.maximum(np.abs(error), 10.0 ** rng.uniform(-6, -2) * np.abs(error).max())
    return Quadratic((ROWS.T @ (ROWS * weight[:, None]))[None], ROWS.T @ (weight * error))


def ranked(population):
    return 1.0 / cost(population)


def task(**changes):
    own = {
        "worth": lambda population: ranked(population)[:, None],
        "screened": lambda population, rng: ranked(population),
        "quadratic": derived,
    }
    return Polishable(HIERARCHY, **(own | changes))


def ended(own, steps, seed=0, done=None):
    return list(polish(own, ONE, steps, seed, done))


def test_the_sum_of_magnitudes_becomes_that_of_the_linear_program():
    found = ended(task(), 60)[-1]
    space, rows = HIERARCHY.space(), len(ROWS)
    # Oracle: min sum t with -t <= e <= t within the genome's bounds.
    room = [*zip(space.low - START, space.high - START, strict=True)]
    identity = np.eye(rows)
    result = scipy.optimize.linprog(
        np.concatenate([np.zeros(len(START)), np.ones(rows)]),
        np.block([[ROWS, -identity], [-ROWS, -identity]]),
        np.concatenate([OFF, -OFF]),
        bounds=room + [(0, None)] * rows,
    )
    first = cost(ONE)[0]
    assert result.fun < 0.5 * first  # there is something to gain
    left = (1.0 / found.worth[0, 0] - result.fun) / (first - result.fun)
    assert 0.0 <= left < 0.02


@pytest.mark.parametrize("quadratic", [derived, None])
def test_it_never_ends_worse_in_anything_that_is_ranked(quadratic):
    """Also where what is screened says the opposite of one of two worths."""

    def worth(population):
        far = np.abs(population.gains[:, 0] - 1000.0)
        return np.stack([ranked(population), -far], axis=1)

    steps = ended(task(quadratic=quadratic, worth=worth), 25)
    each = np.concatenate([steps[0].first, *(done.worth for done in steps)])
    assert (np.diff(each, axis=0) >= 0.0).all()
    # Products of matrices round otherwise of one row than of several.
    np.testing.assert_allclose(worth(steps[-1].population), steps[-1].worth, rtol=1e-12)


def test_what_fails_everywhere_leaves_what_there_was():
    def worth(population):
        return np.where((population.gains == ONE.gains).all(axis=1), 1.0, -np.inf)[:, None]

    found = ended(task(worth=worth, quadratic=lambda population, rng: None), 5)[-1]
    assert found.worth == found.first == 1.0
    assert (found.population.consequents == ONE.consequents).all()


@pytest.mark.parametrize("quadratic", [derived, None])
@pytest.mark.parametrize("stop", [1, 7])
def test_stopped_and_gone_on_is_the_same_bit_for_bit(quadratic, stop):
    own = task(quadratic=quadratic)
    whole = ended(own, 14, seed=3)
    rest = ended(own, 14, 3, whole[stop - 1])
    assert len(rest) == 14 - stop
    for a, b in itertools.zip_longest(rest, whole[stop:]):
        assert (a.worth == b.worth).all()
        assert (a.distribution.mean == b.distribution.mean).all()
        assert (a.population.consequents == b.population.consequents).all()


def test_structure_and_frozen_numbers_stay():
    scenario = load_scenario("c-axis-ramp", INPUTS | {"search.scale_range": 1.0})
    genome = genome_of(scenario)
    own = task()._replace(genome=genome)
    found = ended(own, 10)[-1].population
    assert (found.tree == ONE.tree).all()
    assert (found.scales == ONE.scales).all()
    assert (found.consequents != ONE.consequents).any()


def test_gains_follow_the_coordinates_as_the_chain_says():
    one = ONE
    own = coordinates(HIERARCHY, one)
    slope = chain(HIERARCHY, own)
    assert slope.shape == (len(START), own.size)
    # kp by its logarithm, a consequent in shares of half its range; nothing depends on another.
    limit = HIERARCHY.space().high[np.isfinite(HIERARCHY.space().high)]
    expected = np.concatenate([START[:FIRST], limit])
    inside = (np.abs(START) < HIERARCHY.space().high * (1 - 1e-4)) & (START > 1.0 + 1e-4)
    inside[FIRST:] |= np.abs(START[FIRST:]) < limit * (1 - 1e-4)
    np.testing.assert_allclose(np.diag(slope)[inside], expected[inside], rtol=1e-6)
    assert np.count_nonzero(slope - np.diag(np.diag(slope))) == 0


NOTHING = np.zeros(len(START), bool)


def test_without_derivatives_it_gets_better_too():
    found = ended(task(quadratic=None), 40)[-1]
    assert found.worth[0, 0] > 1.02 * found.first[0, 0]


def test_proposals_at_bounds_leave_what_is_frozen():
    quadratic = derived(ONE, np.random.default_rng(0))
    frozen = NOTHING.copy()
    frozen[SOME[:3]] = True
    points, dampings = proposals(quadratic, frozen, 1.0, 50, np.random.default_rng(1))
    assert points.shape == (50, len(START))
    assert dampings.shape == (50,)
    assert (points[:, frozen] == 0.0).all()
    assert (points[:, SOME[3:]] != 0.0).any(axis=0).all()
