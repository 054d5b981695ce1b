"""Search strategies of a user's own: one file, known by an option, a script or a package."""

import numpy as np
import pytest
from own_strategies import SIZES
from sledge import hfc, imported, installed
from wording import refused, refused_command

from hfc_design import api
from hfc_design.runs import individuals


def test_a_hierarchy_keeps_the_bounds_that_a_strategy_sets(searching):
    strategies = imported("hunt")

    class Narrow(strategies.ClimbSettings):
        kp_range: tuple[float, float] = (500.0, 501.0)
        scale_range: float = 1.0
        root_limit: float = 0.5

    api.register(strategies.CLIMB._replace(settings=Narrow))
    scenario = api.load_scenario("c-axis-ramp", {"search.preset": "climb", **SIZES})
    genome = individuals.genome_of(scenario)
    found = genome.fresh(np.arange(105), np.random.default_rng(0))
    assert 500.0 <= found.gains[:, 0].min() <= found.gains[:, 0].max() <= 501.0
    assert found.gains[:, 1].max() > 1000.0  # the default
    assert (found.scales == found.scales[0]).all()
    assert abs(found.consequents[:, -1]).max() == 0.5


def test_one_that_is_known_and_not_asked_for_is_refused(searching):
    for others in ((), ("--preset", "l-shade")):
        found = refused_command("design", "c-axis-ramp", "--strategy", "hunt:CLIMB", *others)
        assert found.count("\n") == 1


def test_a_package_brings_a_strategy(searching):
    installed(searching, "[hfc_design.strategies]", "climb = hunt:CLIMB")
    scenario = api.load_scenario("c-axis-ramp", {"search.preset": "climb", **SIZES})
    assert scenario.search.step == 0.3
    assert "a hill climber" in hfc("list", "strategies").stdout


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ({"search.preset": "swarm"}, "preset"),
        ({"search.preset": "climb", "search.tournament": 3}, "tournament"),
        ({"search.kp_range": [5.0, 1.0]}, "kp_range"),
    ],
)
def test_searches_that_cannot_be(change, where, searching):
    api.register(imported("hunt").CLIMB)
    with refused() as found:
        api.load_scenario("c-axis-ramp", change)
    assert f"{where} = " in found.refusal
