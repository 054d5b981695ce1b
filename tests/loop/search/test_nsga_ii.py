"""A search for a front that is led to what is allowed by the search for one design."""

import numpy as np
import pytest
from own_strategies import SIZES
from searches import same, searched
from sledge import imported
from wording import refused_command

from hfc_design import api
from hfc_design.controllers.genome import taken
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.individuals import genome_of
from hfc_design.search.coordinates import coordinates
from hfc_design.search.loop import fault
from hfc_design.search.strategies.cma import CmaSettings
from hfc_design.search.strategies.nsga_ii import Nsga2Settings
from hfc_design.search.strategy import Scored, Task

NAMES = ("error", "deflection", "spindle_velocity")
LED = Nsga2Settings(population=20, generations=90, lead=40, front=12)


@pytest.fixture(scope="module")
def staged():
    inputs = [{"name": name, "scale": 10.0} for name in NAMES]
    own = {"controller.inputs": inputs, "controller.linear": {}, "search.preset": "cma"}
    return genome_of(load_scenario("c-axis-ramp", own))


def narrow(population, generation=0):
    """Only ki within 5 % of 40 000 is allowed; tables near 0.2 or near 0.4, once that is so."""
    off = np.abs(np.log(population.linear[:, 0] / 40_000.0))
    table = population.fuzzy.consequents
    costs = [np.abs(table - 0.2).mean(axis=(1, 2, 3)), np.abs(table - 0.4).mean(axis=(1, 2, 3))]
    costs, over = np.stack(costs, axis=1), np.maximum(off - 0.05, 0.0)
    rank = np.where(over > 0.0, -over, 1.0 / costs.sum(axis=1))
    if generation < LED.lead:
        return Scored(rank, np.full_like(costs, np.inf), np.full(len(rank), np.inf))
    return Scored(rank, costs, over)


def led(genome, **options):
    return searched(LED, Task(genome), narrow, **options)


def test_until_the_lead_is_over_it_is_the_search_for_one_design(staged):
    alone = CmaSettings(generations=LED.lead)
    wanted = searched(alone, Task(staged), lambda population, k: narrow(population, k).score)
    found = led(staged, total=LED.lead)
    assert same(found.state.led, wanted.state)
    assert same(found.history, wanted.history)
    assert len(found.state.front.score) == 0


def test_the_front_spreads_from_what_was_led_to(staged):
    first = led(staged, total=LED.lead + 1).state
    assert len(first.population.tree) == LED.population
    whole = led(staged)
    front = whole.state.front
    assert len(front.score) > len(first.front.score)
    assert len(front.score) > 5
    assert not narrow(front.population, LED.lead).violation.any()
    assert (front.costs.min(axis=0) < first.costs.min(axis=0)).all()
    for stop in (1, LED.lead - 1, LED.lead, LED.lead + 1):
        part = led(staged, total=stop)
        assert fault(part, staged.empty(), LED) is None
        assert same(led(staged, search=part), whole)


SMALL = ("--set", "simulation.duration_s=0.1", "--population", 12, "--generations", 5, "--quiet")


def test_random_search_is_what_it_says(searching):
    """The best of all that was drawn, and no generation like another."""
    api.register(imported("hunt").RANDOM)
    own = {"search.preset": "random", "controller": {"kind": "pd"}, **SIZES}
    scenario = api.load_scenario("c-axis-ramp", own)
    search = api.design(scenario).search
    assert search.state.draws == 60
    assert search.state.luck == search.history.best[-1] == search.state.seen.max()
    assert len(set(search.state.seen)) == 5


LACKING = "TAKEN NO_SETTINGS NO_STATE NO_MAKE Climb MUTE NOTHING FOREIGN BROKEN PICKY"


@pytest.mark.parametrize("reference", LACKING.split())
def test_a_strategy_that_lacks_something_is_told_so_in_a_line(reference, searching):
    options = ("--strategy", f"hunt:{reference}", "--preset", "climb", "--controller", "pd")
    found = refused_command("design", "c-axis-ramp", *options, "--out", "run", *SMALL)
    assert found.count("\n") == 1


@pytest.mark.parametrize(
    ("scenario", "changes"),
    [
        ("c-axis-ramp", {}),
        ("c-axis-tolerances", {}),
        ("feed-drive-line", {"controller.kind": "pid"}),
        ("feed-drive-circle", {"controller.kind": "aflc"}),
    ],
)
def test_coordinates_begin_at_the_individual_and_move_all_of_it(scenario, changes):
    genome = genome_of(load_scenario(scenario, changes))
    about = genome.fresh(np.array([genome.structures // 2]), np.random.default_rng(2))
    own = coordinates(genome, about)

    def flat(population):
        return np.concatenate([x.ravel() for x in leaves(genome.gains(population))])

    same = own.members(np.zeros((1, own.size)))
    np.testing.assert_allclose(flat(same), flat(about), rtol=1e-9, atol=1e-9)
    moved = own.members(0.01 * np.random.default_rng(3).standard_normal((1, own.size)))
    assert (flat(moved) != flat(about)).mean() > 0.1
    assert (moved.tree == about.tree).all()


def leaves(tree):
    """Floating arrays of a record of records."""
    if isinstance(tree, tuple):
        return [leaf for part in tree for leaf in leaves(part)]
    known = tree is not None and np.asarray(tree).dtype.kind == "f"
    array = np.asarray(tree) if known else np.zeros(0)
    return [array[np.isfinite(array)]]


def test_a_stage_stands_as_the_individual_does():
    genome = genome_of(load_scenario("feed-drive-circle", {"controller.kind": "flc"}))
    first = taken(genome.empty(), slice(1))
    own = coordinates(genome, first)
    far = own.members(100.0 * np.eye(own.size))
    assert (far.singletons <= genome.largest_command).all()
    assert all(np.isfinite(x).all() for x in far)
