"""The strategy cma on scores that need no simulation: stages, islands, kinds, what it refuses."""

import numpy as np
import pytest
import searches
from searches import same
from wording import refused

from hfc_design import api
from hfc_design.controllers.genome import taken
from hfc_design.runs.individuals import genome_of
from hfc_design.search.loop import fault, generations, searcher
from hfc_design.search.strategies.cma import CmaSettings, _sound
from hfc_design.search.strategy import Task

INPUTS = [{"name": name, "scale": 10.0} for name in ("error", "error_rate", "deflection")]
BEST_TREE = 2
CMA = CmaSettings(population=12, generations=120, trees=3)


@pytest.fixture(scope="module")
def genome():
    own = {"controller.inputs": INPUTS, "controller.linear": {}, "search.preset": "cma"}
    return genome_of(api.load_scenario("c-axis-ramp", own))


@pytest.fixture(scope="module")
def whole(genome):
    return searched(genome)


def hill(population, generation=0):
    """Highest for one tree, all consequents at 0.3, ki at 40 000: a table is needed for half."""
    distance = np.abs(population.fuzzy.consequents - 0.3).mean(axis=(1, 2, 3))
    distance += np.abs(np.log(population.linear[:, 0] / 40_000.0))
    return 100.0 / (1.0 + distance) + 5.0 * (population.tree == BEST_TREE)


def searched(genome, settings=CMA, evaluate=hill, **options):
    return searches.searched(settings, Task(genome), evaluate, **options)


@pytest.mark.parametrize("stop", [30, 61, 119])
def test_continued_equals_uninterrupted(stop, genome, whole):
    """Stages end at 30 and 60, of three structures one goes at 80 and another one at 100."""
    part = searched(genome, total=stop)
    assert fault(part, genome.empty(), CMA) is None
    assert same(searched(genome, search=part), whole)


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


def test_it_climbs_higher_in_every_stage_and_higher_than_chance(genome, whole):
    best = whole.history.best
    assert best[0] < best[29] <= best[59] < best[119]
    for seed, found in enumerate((whole, *(searched(genome, seed=k) for k in (1, 2)))):
        rng = np.random.default_rng([seed, 5])
        drawn = genome.fresh(rng.integers(3, size=120 * 12), rng)
        assert found.history.best[-1] > hill(drawn).max()


def test_the_state_ends_with_the_mean_which_was_judged(whole):
    assert len(whole.state.score) == 1
    # The mean moved once more after it had been judged, by less than what a stage gains.
    assert hill(whole.state.population)[0] == pytest.approx(whole.state.score[0], rel=0.05)


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


@pytest.mark.parametrize("total", [1, 5])
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


def test_the_last_generations_meet_the_machines_that_are_hard_by_then(genome):
    """From generation 48 of 120 on, asked anew 12 times; the nominal one is met anyway."""
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
    assert asked == list(range(48, 120, 6))
    assert met == [None] * 48 + [[5, 48 + k // 6 * 6] for k in range(72)]
    assert fault(last, genome.empty(), CMA) is None


def test_a_start_that_is_broken_gives_way_to_the_best_of_many_that_are_not(genome):
    """Unbroken is who has ten times the first ki; of these the largest is worth most."""
    first = genome.empty().linear[0, 0]

    def broken(population):
        return np.maximum(np.log(10.0 * first / population.linear[:, 0]), 0.0)

    def begun(**told):
        own = searcher(CMA, Task(genome, **told))
        _, asked = own.start(np.random.default_rng(0))
        return asked.population.linear[-1, 0]  # of the mean

    assert begun() == pytest.approx(first)
    assert begun(broken=lambda x: np.zeros(len(x.tree)), worth=hill) == pytest.approx(first)
    largest = begun(broken=broken, worth=lambda x: x.linear[:, 0])
    least = begun(broken=broken, worth=lambda x: -x.linear[:, 0])
    assert 10.0 * first <= least < largest


def test_of_many_structures_compete_that_are_best_at_first():
    """30 of three inputs among five, of which those around the seventh are worth most."""
    names = ("reference_rate", "error", "error_rate", "deflection", "current")
    own = {
        "controller.inputs": [{"name": name, "scale": 10.0} for name in names],
        "controller.used": 3,
        "controller.linear": {},
        "controller.schedules": True,
        "search.preset": "cma",
    }
    genome = genome_of(api.load_scenario("c-axis-ramp", own))
    assert genome.structures == 30
    settings = CmaSettings(population=40, generations=120, trees=4)
    task = Task(genome, worth=lambda x: -np.abs(x.tree - 7.2))
    state, asked = searcher(settings, task).start(np.random.default_rng(0))
    assert state.population.tree.tolist() == [7, 8, 6, 9]
    assert asked.structures == 4


def test_axes_of_unlike_kinds_are_searched_together():
    """X has three stages, Y one; of a score with its best at k_p = 1200 V/mm and k_i = 6 of Y."""
    hierarchy = {
        "kind": "pd+hierarchical-fuzzy",
        "inputs": [{"name": "error", "scale": 1.0}, {"name": "velocity", "scale": 1.0}],
        "linear": {},
    }
    axes = {"x": hierarchy, "y": {"kind": "pid", "ranges": {"k_p": (0.1, 1e3), "k_i": (0.0, 8.0)}}}
    own = {"controller": {"kind": "per-axis", "axes": axes}, "search.preset": "cma"}
    genome = genome_of(api.load_scenario("feed-drive-circle", own))
    assert genome.stages == genome.parts[0].stages

    def score(population, generation):
        x, y = genome.gains(population)
        far = np.log(x.kp / first) ** 2 + np.log(y.k_p / 30.0) ** 2 + (y.k_i - 6.0) ** 2
        return 1.0 / (1.0 + far)

    first = 2.0 * genome.gains(genome.empty())[0].kp[0]
    found = searched(genome, CmaSettings(generations=200), score)
    x, y = genome.gains(found.state.population)
    assert x.kp[0] == pytest.approx(first, rel=0.05)
    assert y.k_p[0] == pytest.approx(30.0, rel=0.05)
    assert y.k_i[0] == pytest.approx(6.0, abs=0.05)


EACH = {"kind": "per-axis", "axes": {"x": {"kind": "pid"}, "y": {"kind": "pid"}}}
ONE_HAS_NONE = {"kind": "per-axis", "axes": {"x": {"kind": "pid"}, "y": {"kind": "flc"}}}
SETTINGS = {
    "c-axis-ramp": [
        {"kind": "pd"},
        {"kind": "lqi"},
        {"inputs": INPUTS},
        {"inputs": INPUTS, "linear": {}},
        {"inputs": INPUTS, "linear": {}, "schedules": True},
    ],
    "feed-drive-circle": [
        {"kind": "pid"},
        {"kind": "pid+ff"},
        {"kind": "flc"},
        {"kind": "aflc"},
        EACH,
        ONE_HAS_NONE,
    ],
}


@pytest.mark.parametrize(
    ("name", "controller"), [(name, own) for name, some in SETTINGS.items() for own in some]
)
def test_it_searches_what_has_stages_and_refuses_the_rest_in_a_line(name, controller):
    """The settings say of a genome what the genome does itself."""
    scenario = api.load_scenario(name, {"controller": controller})
    staged = bool(genome_of(scenario).stages)
    assert scenario.controller.staged == staged
    changes = {"controller": controller, "search.preset": "cma"}
    if staged:
        assert api.load_scenario(name, changes).search.preset == "cma"
        return
    with refused() as found:
        api.load_scenario(name, changes)
    assert found.refusal.startswith(f"{name}: search.preset = 'cma': ")
