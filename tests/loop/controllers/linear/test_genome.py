"""What a search varies of linear controllers: optimal regulators against SciPy, ranges, starts."""

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are
from sledge import imported

from hfc_design import api
from hfc_design.controllers.genome import taken
from hfc_design.controllers.linear import regulator
from hfc_design.core.records import UserError
from hfc_design.runs.individuals import genome_of

KINDS = ("pid+ff", "lqr", "lqi")
SIGNALS = {"signals": ["deflection", "deflection_rate"]}


def genome(kind, scenario="c-axis-ramp", **settings):
    return genome_of(api.load_scenario(scenario, {"controller": {"kind": kind, **settings}}))


def fresh(made, count=300, seed=1):
    return made.fresh(np.zeros(count, int), np.random.default_rng(seed))


@pytest.mark.parametrize("scenario", ["c-axis-ramp", "feed-drive-line"])
@pytest.mark.parametrize("kind", ["lqr", "lqi"])
def test_regulators_are_those_of_scipy(kind, scenario):
    """All over the ranges; scaled for SciPy, whose answers else lose most of their digits."""
    made = genome(kind, scenario)
    states, scale = made.states, made.scale
    values = made.values(fresh(made, 60))
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
        ("pid+ff", "feed-drive-circle", {}),
        ("lqr", "feed-drive-line", {}),
        ("lqi", "c-axis-sine", {}),
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
    ("settings", "told"),
    [
        ({"signals": ["torque"]}, "controller.signals: 'torque' is no signal of the c-axis"),
        ({"signals": ["current", "current"]}, "controller.signals: a name stands there twice"),
        ({"ranges": {"kq": [1, 2]}}, "controller.ranges.kq: unknown; there is kp, ki, kd"),
        ({"ranges": {"kp": [2, 1]}}, "controller.ranges.kp"),
        ({"ranges": {"current": [1, 2]}}, "controller.ranges.current: is not searched here"),
        (
            {"signals": ["deflection_rate", "rotor_velocity"]},
            "'rotor_velocity' of the c-axis follows from the others",
        ),
        ({"kind": "lqr", "tolerances": {"error": 1e-5}}, "need limits.command"),
        ({"kind": "lqr", "tolerances": {"integral": 1e-5}}, "tolerances.integral: unknown; there"),
        ({"kind": "lqi", "speed": 1e200}, "no steady motion was found at"),
        ({"coulomb_width": 0.0}, "controller.coulomb_width = 0.0"),
    ],
)
def test_settings_that_cannot_be_searched_are_told_in_a_line(settings, told):
    with pytest.raises(UserError) as refused:
        genome(**{"kind": "pid+ff"} | settings)
    assert told in str(refused.value)


def of_sledge(kind, plant, **settings):
    step = {"kind": "step", "height": 1.0}
    own = {"plant": {"name": plant}, "reference": step, "controller": {"kind": kind, **settings}}
    return genome_of(api.load_scenario({**own, "simulation": {"sample_time_s": 0.01}}))


@pytest.mark.parametrize("kind", KINDS)
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
    with pytest.raises(UserError, match=r"^plant 'sledge' cannot be linearised: in mine.py, "):
        of_sledge("lqi", "sledge")
