"""The strategy cma on scores that need no simulation: stages, islands, what it refuses."""

import numpy as np
import pytest

from hfc_design import api
from hfc_design.controllers.genome import taken
from hfc_design.core.checkpoint import flat
from hfc_design.runs.individuals import genome_of
from hfc_design.search.heats import heats
from hfc_design.search.loop import fault, generations, searcher
from hfc_design.search.strategies.cma import CmaSettings, _sound
from hfc_design.search.strategy import Task

NAMES = ("error", "error_rate", "deflection")
INPUTS = [{"name": name, "scale": 10.0} for name in NAMES]
BEST_TREE = 2
CMA = CmaSettings(population=12, generations=120, trees=3)


@pytest.fixture(scope="module")
def genome():
    own = {"controller.inputs": INPUTS, "controller.linear": {}, "search.preset": "cma"}
    return genome_of(api.load_scenario("c-axis-ramp", own))


def same(one, other):
    pairs = zip(flat(one), flat(other), strict=True)
    return all(np.array_equal(a, b) for (_, a), (_, b) in pairs)


def hill(population, generation=0):
    """Highest for one tree, all consequents at 0.3, ki at 40 000: a table is needed for half."""
    distance = np.abs(population.fuzzy.consequents - 0.3).mean(axis=(1, 2, 3))
    distance += np.abs(np.log(population.linear[:, 0] / 40_000.0))
    return 100.0 / (1.0 + distance) + 5.0 * (population.tree == BEST_TREE)


def searched(genome, settings=CMA, seed=0, evaluate=hill, search=None, total=None):
    own = searcher(settings, Task(genome))
    parts = (own, genome, total or settings.generations, seed, evaluate, search)
    *_, last = generations(*parts)
    return last


def test_heats_halve_down_to_one():
    assert heats(4) == [4, 2, 1]
    assert heats(3) == [3, 2, 1]
    assert heats(1) == [1]


def test_same_seed_same_bits_other_seed_other_run(genome):
    assert same(searched(genome), searched(genome))
    assert not same(searched(genome), searched(genome, seed=1))


@pytest.mark.parametrize("stop", [1, 29, 30, 60, 61, 80, 119])
def test_continued_equals_uninterrupted(stop, genome):
    """Stages end at 30 and 60, of three structures one goes at 80 and another one at 100."""
    part = searched(genome, total=stop)
    assert fault(part, genome.empty(), CMA) is None
    assert same(searched(genome, search=part), searched(genome))


def test_stages_come_in_turn(genome):
    """Weights, then gains with idle tables, then all; structures compete in the last alone."""
    seen = []

    def watched(population, generation):
        seen.append(population)
        return hill(population)

    searched(genome, evaluate=watched)
    assert len(seen) == 120
    idle = genome.empty().fuzzy.consequents[0]
    for population in seen[:60]:
        assert (population.fuzzy.consequents == idle).all()
        assert (population.tree == 0).all()
    trees = [{int(tree) for p in seen[a:b] for tree in p.tree} for a, b in ((60, 80), (80, 100))]
    assert [len(own) for own in trees] == [3, 2]
    assert trees[1] < trees[0]
    assert len({int(tree) for p in seen[100:] for tree in p.tree}) == 1
    assert np.ptp(seen[-1].fuzzy.consequents) > 0.0


def test_it_climbs_higher_in_every_stage_and_higher_than_chance(genome):
    found = searched(genome)
    best = found.history.best
    assert best[0] < best[29] <= best[59] < best[119]
    for seed in range(3):
        rng = np.random.default_rng([seed, 5])
        drawn = genome.fresh(rng.integers(3, size=120 * 12), rng)
        assert searched(genome, seed=seed).history.best[-1] > hill(drawn).max()


def test_the_state_ends_with_the_mean_which_was_judged(genome):
    found = searched(genome)
    assert len(found.state.score) == 1
    # The mean moved once more after it had been judged, by less than what a stage gains.
    assert hill(found.state.population)[0] == pytest.approx(found.state.score[0], rel=0.05)


def test_samples_that_failed_are_counted_and_led_away_from(genome):
    def half_fail(population, generation):
        score = hill(population)
        score[::2] = np.nan
        return score

    found = searched(genome, evaluate=half_fail)
    assert found.history.diverged.tolist() == [6] * 120
    assert np.isfinite(found.history.best).all()


def test_where_everything_fails_a_stage_begins_about_the_first_individual(genome):
    found = searched(genome, evaluate=lambda population, generation: np.full(12, np.nan))
    assert same(found.state.about, taken(genome.empty(), slice(1)))
    assert _sound(CMA, found.state)


@pytest.mark.parametrize("total", [1, 2, 3, 5])
def test_any_number_of_generations(total, genome):
    settings = CmaSettings(population=6, generations=total, trees=9)
    assert len(searched(genome, settings).history.best) == total


@pytest.mark.parametrize(
    "change",
    [
        lambda s: s._replace(score=np.full(1, np.inf)),
        lambda s: s._replace(score=np.zeros(2)),
        lambda s: s._replace(about=taken(s.about, np.zeros(2, int))),
        lambda s: s._replace(about=s.about._replace(tree=np.array([77]))),
        lambda s: s._replace(about=s.about._replace(linear=np.nan * s.about.linear)),
        lambda s: s._replace(population=taken(s.population, np.zeros(2, int)), score=np.zeros(2)),
        lambda s: s._replace(islands=s.islands._replace(step=-s.islands.step)),
        lambda s: s._replace(islands=s.islands._replace(step=s.islands.step[0])),
        lambda s: s._replace(islands=s.islands._replace(mean=s.islands.mean[:, :-1])),
        lambda s: s._replace(islands=s.islands._replace(path=np.inf * s.islands.path)),
        lambda s: s._replace(islands=s.islands._replace(covariance=s.islands.covariance[..., :1])),
    ],
)
def test_a_state_that_cannot_be_is_refused(change, genome):
    found = searched(genome, total=40)
    assert fault(found, genome.empty(), CMA) is None
    with np.errstate(all="ignore"):
        told = fault(found._replace(state=change(found.state)), genome.empty(), CMA)
    assert told is not None


def test_means_of_the_last_half_are_kept_on_the_way(genome):
    """As they were before generations 72, 75, ... 117 of 120: the best of the islands."""
    own, best = searcher(CMA, Task(genome)), {}
    for search in generations(own, genome, CMA.generations, 0, hill):
        state = search.state
        best[search.generation] = taken(state.population, np.array([np.argmax(state.score)]))
    for k, wanted in enumerate(best[generation] for generation in range(72, 120, 3)):
        assert same(taken(state.trail, np.array([k])), wanted)


def test_the_last_generations_meet_the_machines_that_are_hard_by_then(genome):
    """From generation 48 of 120 on, asked anew every twenty; the nominal one is met anyway."""
    asked, met = [], []

    def hardest(best, keeping):
        assert len(best.tree) == 1
        assert keeping == 0.0
        asked.append(len(met))
        return np.array([0, 5, len(met)])

    def evaluate(population, generation, machines=None):
        met.append(None if machines is None else machines.tolist())
        return hill(population)

    *_, last = generations(searcher(CMA, Task(genome, hardest=hardest)), genome, 120, 0, evaluate)
    assert asked == [48, 68, 88, 108]
    assert met == [None] * 48 + [[5, 48 + (k // 20) * 20] for k in range(72)]
    assert fault(last, genome.empty(), CMA) is None
