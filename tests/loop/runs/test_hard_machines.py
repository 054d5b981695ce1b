"""Machines that are hard for a design: who they are, and that a search meets them."""

import numpy as np
import pytest

from hfc_design import api
from hfc_design.controllers.genome import taken
from hfc_design.runs import problem as problems
from hfc_design.runs.problem import BEHIND, Problem
from hfc_design.simulation import population as simulate

SAMPLES = 300  # of a motion

#: Only the spindle's inertia differs, so that the heaviest is the latest and the swingiest.
SCENARIO = {
    "simulation.duration_s": 0.3,
    "controller": {"kind": "pd"},
    "robust": {
        "spread": 1e-6,
        "tolerances": {"spindle_inertia": 0.5},
        **{"first": 2, "machines": 2, "elite": 2, "final": 12},
    },
    "constraints": {"max_error": "10 urad"},
    "stress": {
        **dict.fromkeys(("delay_samples", "lag_samples", "load", "backlash_steps", "jitter"), 0.0),
        **{"noise": 1.0, "friction": 1.0, "sticking": 0.0},
    },
    "search": {"preset": "cma", "population": 6, "generations": 40},
}


@pytest.fixture(scope="module")
def problem():
    return Problem(api.load_scenario("c-axis-ramp", SCENARIO))


@pytest.fixture(scope="module")
def one(problem):
    return taken(problem.genome.empty(), np.zeros(1, int))


def test_hard_are_those_that_break_most(problem, one, monkeypatch):
    """The error at the end of the ramp grows with the inertia: every machine breaks the limit."""
    inertia = problem.machines.actual[0].inner.spindle_inertia
    heaviest = 1 + np.argsort(-inertia[1:])
    for count in (1, 3):  # twice as many
        monkeypatch.setattr(problems, "HARD", count)
        found = problem.task.hardest(one, 0.0)
        assert found.tolist() == sorted([0, *heaviest[: 2 * count - 1]])
        assert problem.task.hardest(one, 0.5).tolist() == [0]  # no machine passes anywhere


def met_with(problem, one, generation, machine):
    """On the nominal machine and another, what is broken weighed as in a generation of 40."""
    loop, machines = problem.loop, problem.machines
    motions, ensemble = problem.motions, problem.ensemble
    some = machines.take(np.array([0, machine]))
    judged = simulate.scores(loop, some, motions, problem.genome.gains(one))
    return ensemble.verdict(judged, 1000.0 * (generation / 40) ** 2)


def test_half_of_the_machines_that_are_met_are_hard_ones(problem, one):
    hard = np.array([7, 4])
    for generation, met in ((39, 4), (38, 7)):
        expected = met_with(problem, one, generation, met)
        assert problem.rank(one, generation, hard=hard) == expected.weighed
        found = problem.scored(one, generation, machines=hard)
        assert (found.score, found.fitness) == (expected.rank, expected.weighed)
    assert problem.rank(one, 39) == met_with(problem, one, 39, 1 + 39 % 11).weighed


def test_a_search_meets_every_stress_in_turn():
    stress = SCENARIO["stress"] | {"friction": 2.0}
    scenario = api.load_scenario("c-axis-ramp", {**SCENARIO, "stress": stress})
    machines = Problem(scenario).machines
    nominal = scenario.plant.values()[0].coulomb_torque
    factors = machines.actual[0].inner.coulomb_torque / nominal
    assert np.sum(np.isclose(factors, 2.0, rtol=1e-5)) == 3
    assert np.sum(np.isclose(factors, 0.5, rtol=1e-5)) == 3
    assert np.sum(np.isclose(factors, 1.0, rtol=1e-5)) == 6


def test_machines_under_stress_are_asked_what_the_scenario_asks(one):
    """A third of it is allowed of all others: the limit of 10 urad is one of 3.3 there."""
    stress = SCENARIO["stress"] | {"friction": 2.0}
    problem = Problem(api.load_scenario("c-axis-ramp", {**SCENARIO, "stress": stress}))
    loop, machines = problem.loop, problem.machines
    motions, ensemble = problem.motions, problem.ensemble
    assert [x.most for x in ensemble.constraints] == [pytest.approx(1e-5 / 3.0)]
    assert problem.calm.tolist() == [0, 2, 4, 6, 8, 10]
    for machine, share in ((5, 1.0 / 3.0), (6, 1.0)):
        some = np.array([0, machine])
        judged = simulate.scores(loop, machines.take(some), motions, problem.genome.gains(one))
        values = np.array(judged.values)
        values[:, 1, :, -1] *= share
        expected = ensemble.verdict(judged._replace(values=values))
        assert problem.rank_on(one, some) == expected.rank


def test_the_better_half_of_the_finalists_goes_on_to_twice_the_machines():
    """Of eight with different gains one meets all twelve machines; nobody else ranks above it.

    Who breaks something ranks by the share of the machines on which it does, of those under no
    stress, as all are here, and by the nominal one.
    """
    limit = {"constraints": {"max_error": "6.6 mrad"}}  # a third of it, here
    problem = Problem(api.load_scenario("c-axis-ramp", SCENARIO | limit))
    many = problem.genome.fresh(np.zeros(8, int), np.random.default_rng(3))
    lost = np.stack([problem.rank_on(many, np.array([k])) < 0.0 for k in range(12)])
    left = np.arange(8)
    for count in (1, 2, 3, 6, 12):
        rank = problem.rank_on(many, np.arange(count))
        rank -= (rank < 0.0) * BEHIND * (lost[0] + lost[:count].mean(axis=0))
        last, left = left, left[np.argsort(-rank[left], kind="stable")[: (len(left) + 1) // 2]]
    before = problem.simulated
    found = problem.rank_of_finalists(many)
    assert problem.simulated - before == (8 + 4 + 2 + 3 + 6) * SAMPLES
    assert len(last) == 1
    assert found[last] == pytest.approx(rank[last], rel=1e-12)
    assert sorted(lost.sum(axis=0))[0] == 7  # of twelve machines that the best breaks it on
    assert np.argmax(found) == last


def test_whoever_cannot_reach_what_it_needs_meets_four_machines_alone():
    """A race on many machines: the same ranks as without, of fewer samples."""
    more = {"first": 12, "machines": 12, "elite": 12}
    search = {"preset": "race", "population": 40, "generations": 5}
    changes = {**SCENARIO, "robust": SCENARIO["robust"] | more, "search": search}
    problem = Problem(api.load_scenario("c-axis-ramp", changes))
    population = problem.genome.fresh(np.zeros(40, int), np.random.default_rng(1))
    rank = problem.rank(population)
    whole, problem.simulated = problem.simulated, 0
    for needed in (np.quantile(rank, 0.7), rank.max(), 0.0):
        found = problem.rank(population, needed=np.full(40, needed))
        good = rank >= needed
        assert np.array_equal(found[good], rank[good])
        assert (found[~good] < needed).all()
        assert (found[~good] >= rank[~good] - 1e-12).all()
    assert problem.simulated < 0.9 * 3 * whole


def test_what_is_broken_is_weighed_the_more_the_later(problem):
    assert [problem._penalty(k) for k in (0, 2)] == [0.0, pytest.approx(1000.0 * (2 / 40) ** 2)]


@pytest.mark.parametrize("count", [32, 80])
def test_fewer_at_once_than_individuals_or_as_many(problem, count):
    """Each individual is on its own machines all the same."""
    many = problem.genome.fresh(np.zeros(count, int), np.random.default_rng(3))
    found = problem.rank_on(many, np.arange(3), 32)
    assert found == pytest.approx(problem.rank_on(many, np.arange(3)), rel=1e-5)
