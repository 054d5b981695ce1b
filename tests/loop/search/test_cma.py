"""The strategy cma on scores that need no simulation: stages, islands, what it refuses."""

import numpy as np
import pytest

from hfc_design import api
from hfc_design.runs.individuals import genome_of
from hfc_design.search.loop import generations, searcher
from hfc_design.search.strategies.cma import CmaSettings
from hfc_design.search.strategy import Task

NAMES = ("error", "error_rate", "deflection")
INPUTS = [{"name": name, "scale": 10.0} for name in NAMES]
BEST_TREE = 2
CMA = CmaSettings(population=12, generations=120, trees=3)


@pytest.fixture(scope="module")
def genome():
    own = {"controller.inputs": INPUTS, "controller.linear": {}, "search.preset": "cma"}
    return genome_of(api.load_scenario("c-axis-ramp", own))


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


def test_gains_are_one_stage():
    """Of a score that has its best at k_p = 30, k_i = 6, k_d = -0.5."""
    ranges = {"k_p": (0.1, 1000.0), "k_i": (0.0, 8.0), "k_d": (-1.0, 3.0)}
    own = {"controller": {"kind": "pid", "ranges": ranges}, "search.preset": "cma"}
    genome = genome_of(api.load_scenario("feed-drive-line", own))

    def score(population, generation):
        gains = genome.gains(population)
        off = np.log(gains.k_p / 30.0) ** 2 + (gains.k_i - 6.0) ** 2 + (gains.k_d + 0.5) ** 2
        return 1.0 / (1.0 + off)

    found = searched(genome, CmaSettings(generations=150), evaluate=score)
    gains = genome.gains(found.state.population)
    assert gains.k_p[0] == pytest.approx(30.0, rel=1e-3)
    assert gains.k_i[0] == pytest.approx(6.0, abs=1e-3)
    assert gains.k_d[0] == pytest.approx(-0.5, abs=1e-3)


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
    found = searched(genome, CmaSettings(generations=200), evaluate=score)
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
    with pytest.raises(api.UserError) as refusal:
        api.load_scenario(name, changes)
    assert "search.preset = 'cma': " in str(refusal.value)
    assert str(refusal.value).endswith("use race")
    kind = scenario.controller.kind
    assert ("[controller.linear]" in str(refusal.value)) == (kind == "pd+hierarchical-fuzzy")
