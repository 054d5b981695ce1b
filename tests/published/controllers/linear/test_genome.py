"""What a search varies of linear controllers: optimal regulators against SciPy, ranges, starts."""

import numpy as np
import pytest

from hfc_design import api
from hfc_design.runs.individuals import genome_of
from hfc_design.simulation.loop_margins import loop_margins

KINDS = ("pid+ff", "lqr", "lqi")
SIGNALS = {"signals": ["deflection", "deflection_rate"]}


def genome(kind, scenario="c-axis-ramp", **settings):
    return genome_of(api.load_scenario(scenario, {"controller": {"kind": kind, **settings}}))


@pytest.mark.parametrize("kind", KINDS)
def test_the_start_is_a_stable_loop_that_follows_a_ramp(kind):
    made = genome(kind, **(SIGNALS if kind == "pid+ff" else {}))
    scenario = api.load_scenario("c-axis-ramp", {"controller": {"kind": kind}})
    start = made.record(made.empty())
    design = api.with_gains(scenario, kind, {k: x for k, x in start.items() if k != "kind"})
    assert loop_margins(design, scenario).stable
    # What the nominal drive asks for is fed forward, less what the gains on signals give.
    found = api.evaluate(design, scenario)
    assert not found.diverged
    assert abs(found.metrics["final_error_rad"]) < 1e-5
    assert found.fitness > 1000.0  # of Table I 381


@pytest.mark.parametrize("kind", KINDS)
def test_a_search_finds_a_better_one(kind):
    """Half a second under a load, thirty individuals: from the start onwards."""
    small = {"simulation.duration_s": 0.5, "search.population": 30, "search.generations": 4}
    scenario = api.load_scenario("c-axis-ramp-cutting", {**small, "controller": {"kind": kind}})
    made = genome_of(scenario)
    start = {k: x for k, x in made.record(made.empty()).items() if k != "kind"}
    first = api.evaluate(api.with_gains(scenario, kind, start), scenario)
    found = api.design(scenario)
    assert found.evaluation.merit > 1.2 * first.merit
    assert found.design.kind.name == kind


@pytest.mark.parametrize("kind", KINDS)
def test_the_start_holds_against_a_load_that_is_told(kind):
    """On the C-axis, friction and all: under a load of 5 rad/s a tenth of the error is left."""
    load = {"sines": [{"amplitude": 1.0, "frequency_rad_s": 5.0}]}
    late = {}
    for frequencies in ((), (5.0,)):
        own = {"kind": kind, "load_frequencies_rad_s": frequencies}
        changes = {"load": load, "simulation.duration_s": 10.0, "controller": own}
        start = api.load_scenario("c-axis-ramp", changes)
        made = genome_of(start)
        gains = {k: x for k, x in made.record(made.empty()).items() if k != "kind"}
        found = api.evaluate(api.with_gains(start, kind, gains), start)
        late[frequencies] = np.std(found.axes[0].motion.error[8700:])
    assert 0.0 < late[(5.0,)] < 0.1 * late[()]
