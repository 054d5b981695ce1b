"""Differential evolution: on functions with known minima, and as a strategy of a search."""

import numpy as np
import pytest
import searches
from scipy.optimize import rosen
from searches import same

from hfc_design import api
from hfc_design.controllers.genome import taken
from hfc_design.core.checkpoint import flat
from hfc_design.runs.individuals import genome_of
from hfc_design.search.coordinates import coordinates
from hfc_design.search.differential import ARCHIVE, begun, learnt, tried
from hfc_design.search.loop import fault
from hfc_design.search.strategies.l_shade import LShadeSettings
from hfc_design.search.strategy import Task

SETTINGS = LShadeSettings(population=24, last=6, generations=60)
EACH = {"kind": "per-axis", "axes": {"x": {"kind": "pid"}, "y": {"kind": "flc"}}}


def least(cost, size, seed, rounds=400, count=60, room=5.0):
    """What 60 points reach that shrink to 8; ``cost`` is of columns."""
    rng = np.random.default_rng(seed)
    ends = (np.full(size, -room), np.full(size, room))
    points = begun(rng.uniform(*ends, (count, size)))
    score = -cost(points.places.T)
    for k in range(rounds):
        kept = np.sort(np.argsort(-score)[: round(count + (8 - count) * k / rounds)])
        points, score = points._replace(places=points.places[kept]), score[kept]
        trials = tried(points, score, ends, rng)
        assert (np.abs(trials.places) <= room).all()
        assert k > 20 or (trials.places != points.places).any(axis=1).all()
        told = -cost(trials.places.T)
        points, score = learnt(points, trials, told - score), np.maximum(score, told)
        assert len(points.beaten) == int(ARCHIVE * count)
    assert score == pytest.approx(-cost(points.places.T))
    return -score.max()


@pytest.mark.parametrize("seed", range(2))
def test_it_finds_minima_that_are_known(seed):
    """Rosenbrock's banana (SciPy's), and Rastrigin's function, which has a minimum everywhere."""
    assert least(rosen, 8, seed, 800) < 1e-3
    assert least(lambda x: (x**2 + 10.0 * (1.0 - np.cos(2.0 * np.pi * x))).sum(0), 6, seed) < 1e-3
    assert least(lambda x: x.sum(0), 4, seed) == pytest.approx(-20.0, abs=1e-3)  # in a corner


def test_what_succeeded_is_remembered_by_hand():
    """Gains of 1 and 3, factors 0.2 and 0.6: Lehmer's mean is (0.04 + 3 0.36) / (0.2 + 3 0.6)."""
    rng = np.random.default_rng(0)
    points = begun(rng.standard_normal((4, 3)))
    trials = tried(points, np.zeros(4), (np.full(3, -9.0), np.full(3, 9.0)), rng)
    trials = trials._replace(factors=np.array([[0.2, 0.6, 0.9, 0.9], [0.5, 1.0, 0.0, 0.0]]))
    found = learnt(points, trials, np.array([1.0, 3.0, -1.0, 0.0]))
    assert found.memory[:, 0] == pytest.approx([1.12 / 2.0, (0.25 + 3.0) / 3.5])
    assert (found.memory[:, 1:] == 0.5).all()
    assert found.turn == [1.0]
    assert np.array_equal(found.beaten[-2:], points.places[:2])
    assert np.array_equal(found.beaten[:-2], points.beaten[2:])
    moved = [0, 1, 3]  # the last one is as good as what it was
    assert np.array_equal(found.places[moved], trials.places[moved])
    assert np.array_equal(found.places[2], points.places[2])
    failed = learnt(points, trials, np.array([np.inf, 3.0, -1.0, -1.0]))
    assert failed.memory[0, 0] == pytest.approx((0.04 + 0.36) / 0.8)  # a rescue weighs as the best


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


def searched(genome, evaluate=None, **options):
    return searches.searched(SETTINGS, Task(genome), evaluate or hill(genome), **options)


@pytest.fixture(scope="module")
def whole(genome):
    return searched(genome)


@pytest.mark.parametrize("stop", [2, 31, 59])
def test_continued_equals_uninterrupted(stop, genome, whole):
    part = searched(genome, total=stop)
    assert fault(part, genome.empty(), SETTINGS) is None
    assert same(searched(genome, search=part), whole)


def test_individuals_become_fewer_and_each_has_to_beat_itself(genome):
    sizes, score = [], hill(genome)

    def evaluate(population, generation, needed=None):
        sizes.append(len(population.tree))
        assert (needed is None) == (generation < 2)
        assert needed is None or needed.shape == (sizes[-1],)
        return score(population)

    found = searched(genome, evaluate=evaluate)
    assert sizes[:3] == [24, 24, 24]
    assert sizes[-1] == 6
    assert (np.diff(sizes) <= 0).all()
    assert len(found.state.score) == 6
    assert (np.diff(found.history.best) >= 0.0).all()


def test_who_fails_gives_way_and_where_all_fail_the_search_goes_on(genome):
    score = hill(genome)

    def some(population, generation, needed=None):
        found = score(population)
        found[generation % 3 :: 3] = np.nan
        return found

    found = searched(genome, evaluate=some)
    assert np.isfinite(found.state.score).all()
    lost = searched(genome, evaluate=lambda population, *_, **__: score(population) * np.nan)
    assert np.isneginf(lost.state.score).all()
    assert fault(lost, genome.empty(), SETTINGS) is None


@pytest.mark.parametrize(
    "change",
    [
        lambda s: s._replace(score=s.score[:-1]),
        lambda s: s._replace(score=np.full(len(s.score), np.inf)),
        lambda s: s._replace(about=s.population),
        lambda s: s._replace(points=s.points._replace(places=s.points.places[:-1])),
        lambda s: s._replace(points=s.points._replace(places=np.nan * s.points.places)),
        lambda s: s._replace(points=s.points._replace(memory=s.points.memory[:1])),
        lambda s: s._replace(points=s.points._replace(turn=np.array([7.0]))),
    ],
)
def test_a_state_that_cannot_be_is_refused(change, genome):
    found = searched(genome, total=20)
    assert fault(found, genome.empty(), SETTINGS) is None
    with np.errstate(all="ignore"):
        assert fault(found._replace(state=change(found.state)), genome.empty(), SETTINGS)
