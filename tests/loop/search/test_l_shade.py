"""Differential evolution: on functions with known minima, and as a strategy of a search."""

import numpy as np
import pytest

from hfc_design import api
from hfc_design.controllers.genome import taken
from hfc_design.core.checkpoint import flat
from hfc_design.runs.individuals import genome_of
from hfc_design.search.by_numbers import coordinates
from hfc_design.search.loop import generations, searcher
from hfc_design.search.strategies.l_shade import LShadeSettings
from hfc_design.search.strategy import Task

SETTINGS = LShadeSettings(population=24, last=6, generations=60)
EACH = {"kind": "per-axis", "axes": {"x": {"kind": "pid"}, "y": {"kind": "flc"}}}


@pytest.fixture(scope="module", params=["flc", "per-axis"])
def genome(request):
    controller = EACH if request.param == "per-axis" else {"kind": request.param}
    return genome_of(api.load_scenario("feed-drive-line", {"controller": controller}))


def hill(genome):
    """The nearer to a point of the coordinates about the start, the better."""
    about = taken(genome.empty(), slice(1))
    own = coordinates(genome, about)
    away = 5.0 * own.step * np.random.default_rng(9).standard_normal((1, own.size))
    goal = [x for _, x in flat(own.members(away))]
    sizes = [max(float(np.abs(x).max()), 1e-9) for x in goal]

    def score(population, generation=0, needed=None):
        leaves = [x for _, x in flat(population)]
        each = zip(leaves, goal, sizes, strict=True)
        off = [np.abs((a - b) / size).reshape(len(a), -1).mean(axis=1) for a, b, size in each]
        return 1.0 / (0.01 + sum(off))

    return score


def searched(genome, settings=SETTINGS, seed=0, evaluate=None, search=None, total=None):
    own = searcher(settings, Task(genome))
    total = total or settings.generations
    *_, last = generations(own, genome, total, seed, evaluate or hill(genome), search)
    return last


def test_it_climbs_higher_than_chance(genome):
    score = hill(genome)
    for seed in range(3):
        drawn = genome.fresh(np.zeros(1000, int), np.random.default_rng(seed))
        found = searched(genome, seed=seed)
        assert found.history.best[-1] > score(drawn).max()
        assert score(found.state.population) == pytest.approx(found.state.score)
