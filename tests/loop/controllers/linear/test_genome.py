"""What a search varies of linear controllers: optimal regulators against SciPy, ranges, starts."""

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are
from sledge import imported
from wording import refused

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
        {
            "controller": {"kind": "lqi", "expected_load": 5.0, "load_frequencies_rad_s": [1, 50]}
            | {"notch": True, "lowpass": True},
            "stress.modes": [{"hz": 60.0}, {"hz": 30.0}],
        },
    )
    made = genome_of(scenario)
    notch = made.searched["notch_hz"]  # around the modes, where it starts
    assert (notch.low, notch.start, notch.high) == (15.0, 60.0, 120.0)
    one = taken(fresh(made), slice(5, 6))
    record = made.record(one)
    design = api.with_gains(scenario, "lqi", {k: x for k, x in record.items() if k != "kind"})
    law, found = design.controller.law_gains(), made.gains(one)
    for name, value in law._asdict().items():
        np.testing.assert_allclose(np.ravel(value), np.ravel(getattr(found, name)), rtol=1e-12)


def test_bryson_s_rule():
    """A tolerance is as bad as the largest command: 120 V for 20 urad."""
    settings = {"kind": "lqi", "tolerances": {"error": 2e-5}}
    changes = {"limits.command": 120.0, "controller": settings}
    made = genome_of(api.load_scenario("c-axis-ramp", changes))
    assert made.searched["error"].start == pytest.approx(120.0 / 2e-5)
    assert made.record(made.empty())["weights"]["error"] == pytest.approx(6e6)


@pytest.mark.parametrize(
    ("kind", "scenario"),
    [("lqr", "c-axis-ramp"), ("lqi", "c-axis-ramp"), ("lqi", "feed-drive-line")],
)
def test_regulators_are_those_of_scipy(kind, scenario):
    """All over the ranges; scaled for SciPy, whose answers else lose most of their digits."""
    made = genome(kind, scenario)
    states, scale = made.states, made.scale
    values = made.values(fresh(made, 20))
    weights = np.stack([values[name] for name in states.names], axis=1)
    found = regulator.regulators(states, weights, scale)
    a, b = states.a * scale[:, None] / scale, (states.b * scale)[:, None]
    for own, gains in zip(weights / scale, found / scale, strict=True):
        value = solve_discrete_are(a, b, np.diag(own**2), np.eye(1))
        expected = -np.linalg.solve(1.0 + b.T @ value @ b, b.T @ value @ a)[0]
        np.testing.assert_allclose(gains, expected, atol=1e-7 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("kind", "scenario", "own"),
    [
        ("pid+ff", "c-axis-ramp", {}),
        ("pid+ff", "c-axis-ramp-cutting", SIGNALS | {"expected_load": 5.0}),
        ("pid+ff", "c-axis-sine", {"load_frequencies_rad_s": [2.0, 30.0]}),
        ("lqi", "c-axis-sine", {"load_frequencies_rad_s": [2.0, 30.0]}),
    ],
)
def test_individuals_stay_in_their_ranges_and_become_their_records(kind, scenario, own):
    made, rng = genome(kind, scenario, **own), np.random.default_rng(3)
    found = fresh(made)
    moved = made.mutated(found, np.full(300, 1.0), rng)
    mixed = made.nudged(made.blended(moved, found, rng.uniform(-0.25, 1.25, 300)), rng)
    for population in (found, mixed):
        for name, values in made.values(population).items():
            one = made.searched[name]
            # a logarithm and back loses a digit or two
            assert (values >= one.low - 1e-9 * abs(one.low)).all()
            assert (values <= one.high + 1e-9 * abs(one.high)).all()
    gains = made.gains(mixed)
    record = made.record(taken(mixed, slice(7, 8)))
    assert record["kp"] == gains.kp[7]
    assert record["feed_forward"]["velocity"] == gains.velocity[7]
    rows = () if gains.signals is None else gains.signals[:, 7]
    assert list(record["signals"].values()) == list(rows)
    pairs = [[x["in_phase"], x["quadrature"]] for x in record["resonators"]]
    assert np.array_equal(pairs, [pair[:, 7] for pair in gains.resonators])
    assert set(record.get("weights", {})) <= set(made.searched)


@pytest.mark.parametrize(
    ("settings", "key"),
    [
        ({"signals": ["current", "current"]}, "signals"),
        ({"signals": ["deflection_rate", "rotor_velocity"]}, "signals"),
        ({"ranges": {"kq": [1, 2]}}, "ranges.kq"),
        ({"kind": "lqr", "tolerances": {"error": 1e-5}}, "tolerances"),
        ({"coulomb_width": 0.0}, "coulomb_width"),
    ],
)
def test_settings_that_cannot_be_searched_are_told_in_a_line(settings, key):
    with refused() as found:
        genome(**{"kind": "pid+ff"} | settings)
    assert f"controller.{key}" in found.refusal


def of_sledge(kind, plant, **settings):
    step = {"kind": "step", "height": 1.0}
    own = {"plant": {"name": plant}, "reference": step, "controller": {"kind": kind, **settings}}
    return genome_of(api.load_scenario({**own, "simulation": {"sample_time_s": 0.01}}))


@pytest.mark.parametrize("kind", ["pid+ff", "lqi"])
def test_a_drive_of_one_s_own_is_searched_in_its_units(kind, own):
    """2 kg under 3 N s/m, the speed told once more: loops from 0.1 to 50 rad/s in bandwidth."""
    api.register(imported("mine").SLEDGE)
    made = of_sledge(kind, "sledge")
    values = made.gains(fresh(made))
    inside = np.isfinite(values.kp) & (values.kp > 0.0)
    assert inside.all()
    start = made.gains(made.empty())
    assert start.velocity == pytest.approx(3.0)
    assert start.acceleration == pytest.approx(2.0, rel=0.02)  # held for a sample
    assert start.coulomb == pytest.approx(0.0, abs=1e-6)
    assert made.signals == ()  # the speed is what error_rate tells
    assert 2.0 * 0.1**2 < start.kp < 2.0 * 50.0**2 + 3.0 * 50.0


def test_a_drive_that_cannot_be_differentiated_is_told_in_a_line(own):
    mine = imported("mine")
    api.register(mine.BRANCHING)
    with refused() as found:
        of_sledge("lqi", "sledge")
    assert found.where == "plant 'sledge' cannot be linearised"


def test_feed_forward_counts_what_the_gains_on_signals_give():
    """At steady speed a gain on the deflection gives g s; that much less is fed forward."""
    plain, fed = genome("pid+ff"), genome("pid+ff", **SIGNALS)
    individual = fed.empty()
    alone, gains = plain.gains(plain.empty()), fed.gains(individual)
    delta = 0.4 / 200.0  # deflection at 1 rad/s of viscous friction [rad]
    assert gains.velocity == pytest.approx(alone.velocity - gains.signals[0] * delta)
    assert gains.coulomb == pytest.approx(alone.coulomb - gains.signals[0] * 0.7 / 200.0)


def test_a_range_of_one_s_own():
    made = genome("pid+ff", ranges={"kp": [1e3, 1e4], "velocity_multiple": [1.0, 1.0]})
    values = made.values(fresh(made))
    assert values["kp"].min() >= 1e3 * (1 - 1e-12)
    assert values["kp"].max() <= 1e4 * (1 + 1e-12)
    assert (values["velocity_multiple"] == 1.0).all()


def test_gains_for_a_cascade_have_real_roots_and_no_filter():
    """Kv and 1/Tn are the roots of z^2 - kp/kd z + ki/kd; the integral has the present error."""
    made = genome("pid+ff", control="cascade")
    gains = made.gains(fresh(made))
    before = gains.kp - gains.ki * 0.001
    assert (before**2 >= 4.0 * gains.ki * gains.kd).all()
    assert (gains.ki < gains.kp**2 / (4.1 * gains.kd)).any()
    for absent in (gains.filter_pole, gains.velocity, gains.coulomb):
        assert not np.any(absent)
    record = made.record(made.empty())
    assert record["derivative_hz"] == 0.0
    free = genome("pid+ff", control="cascade", ranges={"velocity_multiple": [1.0, 1.0]})
    assert free.gains(free.empty()).velocity != 0.0
