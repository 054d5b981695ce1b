"""The search strategies on scores that need no simulation."""

import functools

import numpy as np
import pytest
import searches
from hierarchies import searched_of
from searches import same

from hfc_design.controllers.genome import joined, replaced, taken
from hfc_design.controllers.hierarchical import tree as hierarchy
from hfc_design.controllers.hierarchical.genome import from_vectors, vectors
from hfc_design.search.newton import Linear
from hfc_design.search.strategies.lin_lee import LinLeeSettings
from hfc_design.search.strategies.race import RaceSettings, RaceState, SuccessiveHalving, humbled
from hfc_design.search.strategy import Task
from hfc_design.search.successive_halving import heats, room

BEST_TREE = 42


def genome(settings, inputs=5):
    names = ("error", "deflection", "deflection_rate", "spindle_velocity", "current", "error_rate")
    return searched_of(names[:inputs], settings)


def hill(population, generation=0, needed=None):
    """Highest for one tree, all consequents at 0.3 and kp at 500; every number counts."""
    distance = np.abs(population.consequents - 0.3).mean(axis=(1, 2, 3))
    distance += np.abs(np.log(population.gains[:, 0] / 500.0))
    return 100.0 / (1.0 + distance) + 20.0 * (population.tree == BEST_TREE)


def searched(settings, evaluate=hill, inputs=5, **options):
    return searches.searched(settings, Task(genome(settings, inputs)), evaluate, **options)


#: A hill knows nothing of machines, so nobody begins with what is known of one.
RACE = RaceSettings(population=210, generations=40, informed=0.0)
PAPER = LinLeeSettings(generations=40)
BOTH = pytest.mark.parametrize("settings", [RACE, PAPER], ids=["race", "lin-lee"])


@functools.cache
def ended(settings, seed=0):
    """How a whole search of the hill ends."""
    return searched(settings, seed=seed)


def test_heats_halve_down_to_one():
    assert heats(105) == [105, 53, 27, 14, 7, 4, 2, 1]
    assert heats(4) == [4, 2, 1]
    assert heats(3) == [3, 2, 1]
    assert heats(1) == [1]


@BOTH
def test_same_seed_same_bits_other_seed_other_run(settings):
    assert same(searched(settings), ended(settings))
    assert not same(ended(settings, seed=1), ended(settings))


@BOTH
@pytest.mark.parametrize("stop", [1, 7, 39])
def test_continued_equals_uninterrupted(settings, stop):
    part = searched(settings, total=stop)
    assert same(searched(settings, search=part), ended(settings))


def test_race_finds_the_best_structure_and_climbs():
    """By chance one search of 105 would; two of four by one in 1,800."""
    settings = RaceSettings(population=420, generations=60, informed=0.0)
    found_by = [searched(settings, seed=seed) for seed in range(4)]
    assert sum(found.archive.score.argmax() == BEST_TREE for found in found_by) >= 2
    for found in found_by:
        assert found.history.best[-1] > 1.5 * found.history.best[0]
        (winner,) = np.unique(found.state.population.tree)
        assert winner == found.archive.score.argmax()


@BOTH
def test_a_search_beats_as_many_individuals_drawn_at_random(settings):
    """First generations as large as the whole budget; six of either, and not one in between."""
    everything = settings.population * settings.generations
    drawn = settings.model_copy(update={"population": everything, "generations": 1})
    best = [[ended(x, seed).history.best[-1] for seed in range(6)] for x in (settings, drawn)]
    assert min(best[0]) > max(best[1])


def test_archive_holds_the_best_of_every_tree_ever_seen():
    best = {}

    def watched(population, generation=0, needed=None):
        score = hill(population)
        for tree, value in zip(population.tree.tolist(), score.tolist(), strict=True):
            best[tree] = max(best.get(tree, -np.inf), value)
        return score

    found = searched(RACE, evaluate=watched)
    assert len(best) == 105
    assert [best[tree] for tree in range(105)] == found.archive.score.tolist()
    assert np.array_equal(found.archive.population.tree, np.arange(105))
    assert np.allclose(hill(found.archive.population), found.archive.score, rtol=0, atol=0)
    assert (np.diff(found.history.best) >= 0).all()


def test_diverged_individuals_rank_last_and_are_counted():
    def half_diverge(population, generation=0, needed=None):
        score = hill(population)
        score[::2] = [np.nan, np.inf, -np.inf][len(score) % 3]
        return score

    found = searched(RACE, evaluate=half_diverge)
    assert found.history.diverged.tolist() == [105] * 40
    assert not np.isnan(found.archive.score).any()
    assert np.isfinite(found.state.score[0])
    assert np.isfinite(found.history.median).all()


@pytest.mark.parametrize(("inputs", "population"), [(2, 1), (5, 1), (6, 3), (2, 50)])
def test_race_runs_with_any_inputs_and_any_population(inputs, population):
    settings = RaceSettings(population=population, generations=12, informed=0.0)
    found = searched(settings, inputs=inputs)
    assert found.state.population.consequents.shape == (population, inputs - 1, 7, 7)
    assert len(found.history.best) == 12
    assert len(found.archive.score) == len(hierarchy.trees(inputs))


def test_race_stays_inside_its_limits_and_leaves_fixed_scales_alone():
    seen = []

    def watched(population, generation=0, needed=None):
        seen.append(population)
        return hill(population)

    settings = RaceSettings(
        population=105, generations=20, informed=0.0,
        scale_range=1.0, inner_limit=0.5, root_limit=3.0,
    )  # fmt: skip
    searched(settings, evaluate=watched)
    everyone = joined(*seen)
    assert np.abs(everyone.consequents[:, :-1]).max() <= 0.5
    assert 0.5 < np.abs(everyone.consequents[:, -1]).max() <= 3.0
    assert np.array_equal(everyone.scales, np.full((len(everyone.tree), 5), 10.0))
    assert (everyone.gains > 0).all()


def test_culling_keeps_the_islands_with_the_best_individuals():
    race = SuccessiveHalving(RACE, Task(genome(RACE)))
    rng = np.random.default_rng(0)
    _, asked = race.start(rng)
    score = rng.random(210)
    state = race.tell(None, asked, score)
    per_tree = [score[asked.population.tree == tree].max() for tree in range(105)]
    survivors = np.sort(np.argsort(per_tree)[-53:])
    later, _ = race.ask(state, 5, rng)  # 40 generations, 8 heats
    assert np.array_equal(np.unique(later.population.tree), survivors)
    assert len(later.score) == 210
    assert later.score.max() == score.max()


@pytest.mark.parametrize(
    ("own", "double", "left"),
    [
        (10.0, 9.95, 10.0),
        (-10.0, -10.05, -10.0),
        (-10.0, -9.0, -10.0),
        (-10.0, -np.inf, -np.inf),
    ],
)
def test_the_best_is_worth_no_more_than_its_double_whatever_the_sign(own, double, left):
    """A hundredth less may be rounding; the double stands at the island's last place."""
    nothing = np.zeros(3)
    state = RaceState(None, np.array([own, -50.0, -60.0]), nothing, np.zeros(3, int), nothing)
    found = humbled(state, np.array([5.0, 5.0, double]))
    assert found.score.tolist() == [left, -50.0, -60.0]


def test_a_lucky_one_falls_behind_a_steady_one_in_a_generation():
    """The double of what is chaotic scores 362 where it has 430; the next best is steady at 380."""
    settings = RaceSettings(population=4, informed=0.0)
    race, random = SuccessiveHalving(settings, Task(genome(settings))), np.random.default_rng(0)
    four = genome(settings).fresh(np.full(4, 7), random)
    scores = np.array([430.0, 380.0, 370.0, 360.0])
    state = RaceState(four, scores, np.full(4, 0.2), np.zeros(4, int), np.ones(1))
    state, asked = race.ask(state, 1, random)
    own, double = (vectors(taken(x, np.array([k]))) for x, k in ((four, 0), (asked.population, 3)))
    assert 0.0 < np.abs(double / own - 1.0).max() < 1e-5
    found = race.tell(state, asked, np.array([1.0, 2.0, 3.0, 362.0]))
    assert found.score.tolist() == [380.0, 370.0, 362.0, 362.0]
    assert same(taken(found.population, np.array([0])), taken(four, np.array([1])))


def test_copies_of_a_lucky_one_fall_behind_with_it():
    """One that stands beside it, and a child a ten-thousandth off; one further away does not."""
    settings = RaceSettings(population=6, informed=0.0)
    race, random = SuccessiveHalving(settings, Task(genome(settings))), np.random.default_rng(0)
    six = genome(settings).fresh(np.full(6, 7), random)
    six = replaced(six, np.array([1]), taken(six, np.array([0])))
    scores = np.array([430.0, 430.0, 380.0, 370.0, 360.0, 350.0])
    state = RaceState(six, scores, np.full(6, 0.2), np.zeros(6, int), np.ones(1))
    state, asked = race.ask(state, 1, random)
    best = taken(six, np.array([0]))
    for place, factor in ((0, 1.0001), (1, 1.01)):
        child = best._replace(gains=factor * best.gains)
        asked = asked._replace(population=replaced(asked.population, np.array([place]), child))
    found = race.tell(state, asked, np.array([431.0, 425.0, 1.0, 2.0, 3.0, 362.0]))
    assert found.score.tolist() == [425.0, 380.0, 370.0, 362.0, 362.0, 362.0]


@BOTH
def test_scores_below_zero_are_climbed_past_what_failed(settings):
    """Ranks are all that counts to both; the worst that did not fail beats what did."""

    def below(population, generation=0, needed=None):
        score = hill(population) - 1000.0
        score[::3] = np.nan
        return score

    found = searched(settings, evaluate=below)
    assert found.history.best[-1] > found.history.best[0]
    assert found.history.best[-1] < 0.0
    assert (found.history.median < found.history.best).all()
    tried = np.isfinite(found.archive.score)
    assert found.archive.score[tried].max() == found.history.best[-1]


def test_steps_along_the_derivative_stay_within_the_bounds():
    """Of a loop whose error falls with every parameter, however far."""
    own = {"scale_range": 1.0, "newton_islands": 105, "informed": 0.0}
    settings = RaceSettings(population=40, generations=8, **own)
    seen = []

    def linearised(individual, chosen):
        jacobian = -1.0 - np.random.default_rng(1).random((50, 2 + 5 + 4 * 49))
        return Linear(np.linspace(1.0, 2.0, 50), jacobian[:, chosen] * 1e-4, chosen)

    def watched(population, generation=0, needed=None):
        seen.append(population)
        return hill(population)

    task = Task(genome(settings), linearised)
    searches.searched(settings, task, watched)
    everyone = joined(*seen)
    assert np.abs(everyone.consequents[:, :-1]).max() == 4.0
    assert np.abs(everyone.consequents[:, -1]).max() == 20.0
    assert (everyone.scales == 10.0).all()
    assert everyone.gains.min() >= 1.0


def test_heats_without_gauss_newton_steps_are_a_quarter_as_long():
    """Four heats of 105 to 14 islands and four of 7 to 1: 4 / 4 + 4 parts."""
    sizes = [room(105, 8, k / 100) for k in range(100)]
    assert [sizes.count(size) for size in heats(105)] == [5, 5, 5, 5, 20, 20, 20, 20]
    equal = [room(105, 105, k / 80) for k in range(80)]
    assert [equal.count(size) for size in heats(105)] == [10] * 8


def test_vectors_and_back():
    race = SuccessiveHalving(RACE, Task(genome(RACE)))
    _, asked = race.start(np.random.default_rng(3))
    some = taken(asked.population, np.array([5, 5, 5]))
    points = vectors(some)
    assert points.shape == (3, 2 + 5 + 4 * 49)
    assert points[0, 1] == some.gains[0, 1]
    assert points[0, 2] == some.scales[0, 0]
    assert points[0, 7 + 49 + 7 + 2] == some.consequents[0, 1, 1, 2]
    assert same(from_vectors(points, some), some)
