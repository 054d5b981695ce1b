"""Populations of which the lost are dropped: the same bits as without, and who was lost."""

import jax
import numpy as np
import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.objectives.objective import Remaining
from hfc_design.runs.problem import Problem
from hfc_design.simulation import compiled
from hfc_design.simulation import population as simulate
from hfc_design.simulation.early_stopping import SHARES

CASES = {
    "C-axis": ("c-axis-ramp", ["simulation.duration_s=1.5"]),
    "cutting": ("c-axis-ramp-cutting", ["simulation.duration_s=1.5"]),
    "contour": ("feed-drive-circle", ["controller.kind=flc", "simulation.duration_s=2.0"]),
}


def population(name, changes, count=150):
    problem = Problem(load_scenario(name, changes))
    tree = np.arange(count) % problem.genome.structures
    members = problem.genome.fresh(tree, np.random.default_rng(3))
    return problem, problem.genome.gains(members)


@pytest.mark.parametrize("case", CASES)
def test_who_is_not_lost_has_the_same_bits(case):
    problem, gains = population(*CASES[case])
    parts = problem.loop, problem.machines, problem.motions[0], gains
    whole = simulate.scores(*parts[:2], [parts[2]], gains)
    rank = whole.rank[:, 0, 0]
    every = len(problem.motions[0].time)
    for needed in (-np.inf, np.quantile(rank[np.isfinite(rank)], 0.6), np.inf):
        judged, samples = simulate.scores_needed(*parts, np.full(150, needed))
        here = rank >= needed
        found = judged.rank[:, 0, 0]
        assert np.array_equal(found[here], rank[here])
        assert np.array_equal(judged.values[here], whole.values[here])
        assert (samples[here] == every).all()
        # Of the others no more is known than that they are worse.
        others = ~here & np.isfinite(found)
        assert (found[others] < needed).all()
        assert (found[others] >= rank[others] * (1.0 - 1e-6)).all()
    assert samples.max() <= np.ceil(SHARES[0] * every) + 1  # nobody reaches what is infinite


def test_each_has_what_it_needs_and_one_program_serves_all():
    problem, gains = population(*CASES["C-axis"])
    parts = problem.loop, problem.machines, problem.motions[0], gains
    judged, _ = simulate.scores_needed(*parts, np.full(150, -np.inf))
    rank = judged.rank[:, 0, 0]
    before = compiled.scores_needed._cache_size()
    needed = np.where(np.arange(150) % 2, np.inf, -np.inf)
    judged, samples = simulate.scores_needed(*parts, needed)
    assert compiled.scores_needed._cache_size() == before
    assert np.array_equal(judged.rank[::2, 0, 0], rank[::2])
    finite = np.isfinite(rank[::2])
    assert samples[::2][finite].min() == len(problem.motions[0].time)
    assert samples[1::2].mean() < 0.5 * samples[::2][finite].mean()


def test_populations_of_other_sizes_share_a_program():
    """They are cut into parts of one size, and whoever fills up a part is simulated no further."""
    problem, gains = population(*CASES["C-axis"])
    parts = problem.loop, problem.machines, problem.motions[0]
    rank = simulate.scores_needed(*parts, gains, np.full(150, -np.inf))[0].rank
    compiled.scores_needed.clear_cache()
    for count in (150, 64, 33):
        some = jax.tree.map(lambda leaf, count=count: leaf[..., :count], gains)
        needed = np.full(count, -np.inf)
        judged, samples = simulate.scores_needed(*parts, some, needed, at_once=64)
        assert np.array_equal(judged.rank, rank[:count])
        assert len(samples) == count
    assert compiled.scores_needed._cache_size() == 1


def test_the_best_that_can_still_be_reached_is_by_hand():
    """Of sums after 1,000 of 1,500 samples, 300 of which of the 500 to come are settled."""
    judge = load_scenario("c-axis-ramp").judge()
    lin_lee, stuck = (2.0, 4.0), (30.0, 60.0)
    fitness = 1000.0 * (3.0 / 2.0 + 0.1 / 4.0)
    merit = float(judge.best((lin_lee, stuck), Remaining(500.0, 300.0)))
    assert merit == pytest.approx(fitness / (1.0 + 300.0 * 30.0 / 360.0))
    contour = load_scenario("feed-drive-circle").judge().objectives[0]
    best = contour.best((40.0, 2.0, 90.0, 10.0), Remaining(30.0, 0.0))
    assert float(best) == pytest.approx(1.0 / (1.0 + 0.3 * 2.0 + 0.01 * 1.5))
