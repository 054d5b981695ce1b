"""The front of functions whose front is known, without a simulation."""

import numpy as np
import pytest
import searches
from hierarchies import searched_of
from pydantic import ValidationError
from searches import same
from toy_fronts import PointGenome, scored, zdt
from wording import refused

from hfc_design.files.named_scenario import load_scenario
from hfc_design.search import fronts
from hfc_design.search.loop import fault
from hfc_design.search.strategies.nsga_ii import STRATEGY, Nsga2Settings
from hfc_design.search.strategy import Scored, Task

SMALL = Nsga2Settings(population=24, generations=12, front=10, scale_range=2.0)
NAMES = ("error", "deflection", "spindle_velocity", "error_rate")


def two_sides(population, generation=0):
    """Tables near 0.3 and kp near 300, or near 3000; no root above 12 is allowed; some fail."""
    table = np.abs(population.consequents - 0.3).mean(axis=(1, 2, 3))
    costs = [table + np.abs(np.log(population.gains[:, 0] / kp)) for kp in (300.0, 3000.0)]
    costs = np.stack(costs, axis=1)
    over = np.maximum(np.abs(population.consequents[:, -1]).max(axis=(1, 2)) - 12.0, 0.0)
    lost = population.gains[:, 0] > 8000.0
    rank = np.where(over > 0.0, -over, 1.0 / costs.sum(axis=1))
    return Scored(np.where(lost, np.nan, rank), costs, np.where(lost, np.inf, over))


def searched(settings=SMALL, evaluate=two_sides, **options):
    return searches.searched(settings, Task(searched_of(NAMES, settings)), evaluate, **options)


def test_same_seed_same_bits_and_continued_is_the_same():
    whole = searched()
    assert same(whole, searched())
    assert not same(whole, searched(seed=1))
    for stop in (1, 7):
        assert same(searched(search=searched(total=stop)), whole)


def test_the_front_has_what_nobody_ever_beat_and_is_allowed():
    seen = []

    def watched(population, generation):
        seen.append(two_sides(population))
        return seen[-1]

    settings = SMALL.model_copy(update={"front": 1000})
    front = searched(settings, evaluate=watched).state.front
    costs, violation = (np.concatenate([getattr(x, k) for x in seen]) for k in Scored._fields[1:])
    allowed = costs[violation == 0.0]
    best = np.unique(allowed[~fronts.dominated(allowed, allowed)], axis=0)
    assert np.array_equal(np.unique(front.costs, axis=0), best)
    assert len(front.costs) == len(best)
    assert len(best) > 10
    again = two_sides(front.population)
    assert np.array_equal(again.costs, front.costs)
    assert np.array_equal(again.score, front.score)
    assert not again.violation.any()


def test_nothing_allowed_is_an_empty_front_and_the_least_broken_come_first():
    def forbidden(population, generation):
        found = two_sides(population)
        broken = 1.0 + found.costs[:, 0]
        return found._replace(score=-broken, violation=broken)

    found = searched(evaluate=forbidden)
    assert len(found.state.front.population.tree) == 0
    assert (np.diff(found.state.violation) >= 0.0).all()
    assert found.history.best[-1] > found.history.best[0]


@pytest.mark.parametrize("number", [1, 2])
def test_it_comes_close_to_a_known_front(number):
    """A front at random stays 2 away from f2 = 1 - sqrt(f1) or 1 - f1^2; 60 x 80 end within 0.1."""
    settings = Nsga2Settings(population=60, front=60, generations=80, blend=0.9)
    task = Task(PointGenome(1))
    last = searches.searched(settings, task, lambda p, _: scored(zdt(number, p.x)), seed=1)
    first, second = last.state.front.costs.T
    away = second - (1 - np.sqrt(first) if number == 1 else 1 - first**2)
    assert (away >= 0.0).all()
    assert np.median(away) < 0.35
    assert np.ptp(first) > 0.8


def test_a_lead_leaves_room_and_needs_stages():
    with pytest.raises(ValidationError, match=r"lead must be less than generations"):
        Nsga2Settings(generations=9, lead=9)
    changes = {"search.preset": "nsga-ii", "search.lead": 5}
    with refused():
        load_scenario("c-axis-ramp", changes)


def damage(search, **changes):
    state = search.state
    front = state.front._replace(**changes.pop("front", {}))
    return search._replace(state=state._replace(front=front, **changes))


def test_a_state_that_no_search_can_have_is_told():
    found = searched()
    empty = searched_of(NAMES, SMALL).empty()
    assert fault(found, empty, SMALL) is None
    front = found.state.front
    bad = front.population._replace(gains=front.population.gains * np.nan)
    for wrong in (
        damage(found, violation=found.state.violation - 1.0),
        damage(found, score=found.state.score[1:]),
        damage(found, step=0.0 * found.state.step),
        damage(found, costs=found.state.costs[:, :1]),
        damage(found, front={"costs": np.sort(front.costs, axis=0)}),
        damage(found, front={"score": front.score[1:]}),
        damage(found, front={"costs": front.costs * np.inf}),
        damage(found, front={"population": bad}),
    ):
        assert fault(wrong, empty, SMALL) is not None
    assert STRATEGY.trades(SMALL) == ("tracking", "effort")
