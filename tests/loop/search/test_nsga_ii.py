"""A search for a front that is led to what is allowed by the search for one design."""

import numpy as np
import pytest
from searches import same, searched

from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.individuals import genome_of
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
