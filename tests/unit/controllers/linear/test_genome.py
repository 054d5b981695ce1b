"""What a search varies of linear controllers: optimal regulators against SciPy, ranges, starts."""

import numpy as np
import pytest

from hfc_design import api
from hfc_design.controllers.genome import taken
from hfc_design.controllers.linear import regulator
from hfc_design.runs.individuals import genome_of

SIGNALS = {"signals": ["deflection", "deflection_rate"]}


def genome(kind, scenario="c-axis-ramp", **settings):
    return genome_of(api.load_scenario(scenario, {"controller": {"kind": kind, **settings}}))


def fresh(made, count=300, seed=1):
    return made.fresh(np.zeros(count, int), np.random.default_rng(seed))


def test_an_integrator_by_hand():
    """x+ = x + b u, cost w^2 x^2 + u^2: p = w^2 + p/(1 + b^2 p), its positive root."""
    b, w = 0.1, 3.0
    p = w**2 / 2.0 + np.sqrt(w**4 / 4.0 + w**2 / b**2)
    states = regulator.Measured(("error",), np.eye(1), np.array([b]))
    found = regulator.regulators(states, np.array([[w]]))
    assert found == pytest.approx(-b * p / (1.0 + b**2 * p))


def test_what_has_no_regulator_is_a_failure_and_no_exception():
    """The command does not move an unstable state; the one beside it can be held."""
    states = regulator.Measured(("x", "y"), np.diag([1.2, 0.9]), np.array([0.0, 1.0]))
    found = regulator.regulators(states, np.array([[1.0, 1.0], [np.nan, 1.0]]))
    assert np.isnan(found).all()


def test_the_record_holds_what_the_law_does():
    """With a load that is expected: gain x load in the file is the constant of the law."""
    scenario = api.load_scenario(
        "c-axis-ramp-cutting",
        {"controller": {"kind": "lqi", "expected_load": 5.0, "load_frequencies_rad_s": [1, 50]}},
    )
    made = genome_of(scenario)
    one = taken(fresh(made), slice(5, 6))
    record = made.record(one)
    design = api.with_gains(scenario, "lqi", {k: x for k, x in record.items() if k != "kind"})
    law, found = design.controller.gains(), made.gains(one)
    for name, value in law._asdict().items():
        np.testing.assert_allclose(np.ravel(value), np.ravel(getattr(found, name)), rtol=1e-12)


def test_feed_forward_counts_what_the_gains_on_signals_give():
    """At steady speed a gain on the deflection gives g s; that much less is fed forward."""
    plain, fed = genome("pid+ff"), genome("pid+ff", **SIGNALS)
    individual = fed.empty()
    alone, gains = plain.gains(plain.empty()), fed.gains(individual)
    delta = 0.4 / 200.0  # deflection at 1 rad/s of viscous friction [rad]
    assert gains.velocity == pytest.approx(alone.velocity - gains.signals[0] * delta)
    assert gains.coulomb == pytest.approx(alone.coulomb - gains.signals[0] * 0.7 / 200.0)


def test_bryson_s_rule():
    """A tolerance is as bad as the largest command: 120 V for 20 urad."""
    settings = {"kind": "lqi", "tolerances": {"error": 2e-5}}
    changes = {"limits.command": 120.0, "controller": settings}
    made = genome_of(api.load_scenario("c-axis-ramp", changes))
    assert made.searched["error"].start == pytest.approx(120.0 / 2e-5)
    assert made.record(made.empty())["weights"]["error"] == pytest.approx(6e6)


def test_a_range_of_one_s_own():
    made = genome("pid+ff", ranges={"kp": [1e3, 1e4], "velocity_multiple": [1.0, 1.0]})
    values = made.values(fresh(made))
    assert values["kp"].min() >= 1e3 * (1 - 1e-12)
    assert values["kp"].max() <= 1e4 * (1 + 1e-12)
    assert (values["velocity_multiple"] == 1.0).all()
