"""The bound: against programmes formed by hand, SciPy's integrator, and motions that exist."""

from functools import cache

import numpy as np
import pytest

from hfc_design.attainable.attainable import attainable
from hfc_design.attainable.rollout import rolled_out, rollout_of
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.evaluating import evaluate

LIMIT = 250.0
RAMP = {"limits.command": LIMIT, "simulation.duration_s": 0.6}
DESIGNS = "lin-lee-1999-table-1", "lin-lee-1999-table-2", "pd-only"


@cache
def of(name, **changes):
    scenario = load_scenario(
        name, {**RAMP, **{k.replace("__", "."): v for k, v in changes.items()}}
    )
    (found,) = attainable(scenario).values()
    return scenario, found


@pytest.mark.parametrize("name", ["c-axis-ramp", "c-axis-ramp-cutting"])
def test_nobody_is_below_the_bound_and_the_best_voltage_is_close(name):
    scenario, found = of(name)
    assert found.simple <= found.bound <= found.reached < 1.35 * found.bound
    for design in DESIGNS:
        error = evaluate(design, scenario).axes[0].motion.error
        assert found.reached < np.abs(error).sum()
    play, generator = rollout_of(scenario), np.random.default_rng(3)
    for _ in range(20):
        other = np.clip(found.voltage + generator.normal(0, 5.0, len(found.voltage)), -LIMIT, LIMIT)
        assert found.bound < np.abs(rolled_out(play, other).error).sum()


def test_the_best_voltage_does_in_the_simulator_what_is_told_of_it():
    """Fed back through a design's loop: its commands played give its errors, to the last digits."""
    scenario, found = of("c-axis-ramp")
    assert np.abs(found.voltage).max() <= LIMIT
    assert np.abs(rolled_out(rollout_of(scenario), found.voltage).error).sum() == found.reached
    motion = evaluate("lin-lee-1999-table-1", scenario).axes[0].motion
    error = rolled_out(rollout_of(scenario), np.asarray(motion.command)).error
    np.testing.assert_allclose(error, motion.error, atol=1e-12)


def test_a_delay_and_a_smaller_limit_raise_the_bound():
    brief = {"simulation__duration_s": 0.1}
    _, found = of("c-axis-ramp", **brief)
    _, late = of("c-axis-ramp", limits__delay_samples=1, **brief)
    _, weak = of("c-axis-ramp", limits__command=120.0, **brief)
    assert found.bound < late.bound
    assert found.bound < weak.bound
    assert late.voltage[0] == 0.0


def test_the_target_of_the_step_is_out_of_reach_as_its_scenario_says():
    """By the inequality of Cauchy and Schwarz: n times the squares are at least the sum squared."""
    (scenario,) = (
        x for x in load_scenario("c-axis-practical").each_motion() if x.name.endswith(".step")
    )
    (found,) = attainable(scenario).values()
    steps = len(found.voltage)
    error = np.asarray(rolled_out(rollout_of(scenario), found.voltage).error)
    least, best = found.bound / np.sqrt(found.samples * steps), np.sqrt(np.mean(error**2))
    assert 1.3e-3 < least < best < 2.2e-3
    target = scenario.fitness.tolerances["rms_error"].tolerance
    assert target == "1 mrad"
