"""The bound: against programmes formed by hand, SciPy's integrator, and motions that exist."""

from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import linprog

from hfc_design.attainable.attainable import attainable
from hfc_design.attainable.certificate import Bounds, certified
from hfc_design.attainable.freed import ANGLE, MOMENTUM, freed, sampled, undriven
from hfc_design.attainable.playing import played, player
from hfc_design.attainable.programme import Linear, programme
from hfc_design.attainable.reach import reach
from hfc_design.attainable.sliding import Case, bent
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.evaluating import evaluate
from plants.c_axis import CAxisParameters, CAxisState, coefficients, derivative

LIMIT = 250.0
RAMP = {"limits.command": LIMIT, "simulation.duration_s": 0.6}
MACHINE = freed(CAxisParameters())
DESIGNS = "lin-lee-1999-table-1", "lin-lee-1999-table-2", "pd-only"


@cache
def of(name, **changes):
    scenario = load_scenario(
        name, {**RAMP, **{k.replace("__", "."): v for k, v in changes.items()}}
    )
    (found,) = attainable(scenario).values()
    return scenario, found


def test_the_freed_machine_moves_as_lugre_does_under_its_own_bristles():
    """SciPy's Radau on LL eq. 2, its z given to the linear machine as an input."""
    c = coefficients(CAxisParameters())

    @jax.jit
    def slopes(x, voltage):
        return jnp.stack(derivative(c, CAxisState(*x), voltage, 3.0))

    def rates(time, x):
        return np.asarray(slopes(x, 200.0 * np.sin(30.0 * time)))

    def linear(time, x):
        z = true.sol(time)[5]
        voltage = 200.0 * np.sin(30.0 * time)
        return MACHINE.a @ x + MACHINE.voltage * voltage + MACHINE.bristle * z + MACHINE.load * 3.0

    given = {"method": "Radau", "rtol": 1e-10, "atol": 1e-13, "dense_output": True}
    true = solve_ivp(rates, (0.0, 0.2), np.zeros(6), **given)
    found = solve_ivp(linear, (0.0, 0.2), np.zeros(5), **given)
    assert found.y[ANGLE, -1] == pytest.approx(true.y[3, -1], abs=1e-9)
    z, speed = true.y[5, -1], true.y[4, -1]
    momentum = CAxisParameters().spindle_inertia * speed + 126.5 * z
    assert found.y[MOMENTUM, -1] == pytest.approx(momentum, abs=1e-8)


def test_any_multipliers_prove_no_more_than_the_programme_and_the_best_ones_as_much():
    """A dense programme of six samples, by columns of answers instead of states."""
    time, steps = 0.02, 6
    one = sampled(MACHINE, time)
    errors = 1e-4 * np.array([1.0, 2.0, 4.0, 6.0, 9.0, 12.0])
    voltage = np.full(steps, 3.0)
    zeros = np.zeros(steps)
    answers = np.zeros((steps, steps))
    for j in range(steps):
        x = one.voltage
        for k in range(j, steps):
            answers[k, j] = x[ANGLE]
            x = one.a @ x
    eye = np.eye(steps)
    primal = linprog(
        [*zeros, *np.ones(2 * steps)],
        A_eq=np.hstack([answers, eye, -eye]),
        b_eq=errors,
        bounds=[(-3.0, 3.0)] * steps + [(0.0, None)] * 2 * steps,
    )
    system = Linear(np.array([one.a] * steps), np.array([one.voltage[:, None]] * steps), ANGLE)
    found = programme(system, errors, -voltage[:, None], voltage[:, None]).least_sum()
    assert np.abs(found.errors).sum() == pytest.approx(primal.fun, rel=1e-6)
    bounds = Bounds(voltage, zeros, zeros)
    best = certified(MACHINE, one, errors, np.clip(found.multipliers, -1, 1), bounds)
    assert best.bound == pytest.approx(primal.fun, rel=1e-6)
    assert best.bound <= primal.fun
    random = np.random.default_rng(0).uniform(-1, 1, (200, steps))
    for multipliers in [*random, *np.sign(random), np.zeros(steps)]:
        assert certified(MACHINE, one, errors, multipliers, bounds).bound <= primal.fun


def test_what_bristles_take_away_is_no_less_than_any_that_are_tried():
    """Bristles of a hundred pieces a sample, the worst by hand: nearly as much, never more."""
    time, steps, pieces = 0.002, 8, 100
    one, fine = sampled(MACHINE, time), sampled(MACHINE, time / pieces)
    multipliers = np.array([1.0, -1.0, 1.0, 0.5, -0.2, 1.0, -1.0, 0.3])
    low, high = -7e-5 * np.linspace(0.1, 1.0, steps), 5e-5 * np.linspace(0.0, 1.0, steps)
    proof = certified(
        MACHINE, one, np.zeros(steps), multipliers, Bounds(np.zeros(steps), low, high)
    )
    back, taken = np.zeros(5), 0.0
    for k in range(steps - 1, -1, -1):
        back[ANGLE] += multipliers[k]
        for _ in range(pieces):
            by = back @ fine.bristle
            taken += max(by * low[k], by * high[k])
            back = back @ fine.a
    assert proof.bound <= -taken
    assert proof.bound == pytest.approx(-taken, rel=5e-3)


def test_bristles_and_states_stay_within_reach():
    """Of a hundred motions by random voltages, load and all."""
    scenario = load_scenario("c-axis-ramp-cutting", {**RAMP, "simulation.duration_s": 0.15})
    play = player(scenario)
    one, generator = sampled(MACHINE, 0.001), np.random.default_rng(1)
    start = CAxisState(*play.samples.start[0])
    moved = undriven(MACHINE, play.samples, 1, start)
    loads = play.samples.axes[0].loads
    steps = len(moved) - 1
    found = reach(MACHINE, one, moved, loads, np.full(steps, LIMIT))
    for k in range(100):
        held = int(generator.integers(1, 50))
        voltage = LIMIT * np.sign(generator.standard_normal(steps // held + 1)).repeat(held)[:steps]
        states = played(play, np.append(voltage, 0.0)).states
        z, speed = np.abs(states[:, 5]), np.abs(states[:, 4])
        assert (z[1:] <= found.bristles * (1 + 1e-6)).all(), k
        assert (speed[1:] <= found.speed).all(), k
        momentum = 5.102 * states[:, 4] + 126.5 * states[:, 5]
        assert (np.abs(momentum[1:]) <= found.states[:, MOMENTUM]).all(), k
        bending = np.abs(np.diff(momentum, 2)) / 0.001**2
        assert (bending <= 1.01 * np.maximum(found.bending[:-1], found.bending[1:])).all(), k


def test_bristles_follow_what_is_known_of_the_speed():
    """The bounds hold along random motions whose speed is known to within a band, signs too."""
    play = player(load_scenario("c-axis-ramp", {**RAMP, "simulation.duration_s": 0.3}))
    one, generator = sampled(MACHINE, 0.001), np.random.default_rng(2)
    moved = undriven(MACHINE, play.samples, 1, CAxisState(*play.samples.start[0]))
    loads, steps = play.samples.axes[0].loads, len(moved) - 1
    reached = reach(MACHINE, one, moved, loads, np.full(steps, LIMIT))
    widest = Bounds(np.full(steps, LIMIT), -reached.bristles, reached.bristles)
    case = Case(MACHINE, one, moved, np.zeros(steps), reached, widest, np.inf)
    narrow = 0
    for _ in range(30):
        held = int(generator.integers(10, 80))
        voltage = LIMIT * generator.uniform(-1, 1, steps // held + 1).repeat(held)[:steps]
        states = played(play, np.append(voltage, 0.0)).states
        ends = np.stack([states[:-1, 4], states[1:, 4]])
        low, high = ends.min(axis=0) - 2e-4, ends.max(axis=0) + 2e-4
        found = bent(case, low, high, 0.0)
        for z in (states[:-1, 5], states[1:, 5]):
            assert (found.low - 1e-8 <= z).all()
            assert (z <= found.high + 1e-8).all()
        narrow += (found.high - found.low < 0.1 * MACHINE.largest).sum()
    assert narrow > 30 * steps / 4  # it says something


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["c-axis-ramp", pytest.param("c-axis-ramp-cutting", marks=pytest.mark.slow)]
)
def test_nobody_is_below_the_bound_and_the_best_voltage_is_close(name):
    scenario, found = of(name)
    assert found.simple <= found.bound <= found.reached < 1.35 * found.bound
    for design in DESIGNS:
        error = evaluate(design, scenario).axes[0].motion.error
        assert found.reached < np.abs(error).sum()
    play, generator = player(scenario), np.random.default_rng(3)
    for _ in range(20):
        other = np.clip(found.voltage + generator.normal(0, 5.0, len(found.voltage)), -LIMIT, LIMIT)
        assert found.bound < np.abs(played(play, other).error).sum()


def test_the_best_voltage_does_in_the_simulator_what_is_told_of_it():
    """Fed back through a design's loop: its commands played give its errors, to the last digits."""
    scenario, found = of("c-axis-ramp")
    assert np.abs(found.voltage).max() <= LIMIT
    assert np.abs(played(player(scenario), found.voltage).error).sum() == found.reached
    motion = evaluate("lin-lee-1999-table-1", scenario).axes[0].motion
    error = played(player(scenario), np.asarray(motion.command)).error
    np.testing.assert_allclose(error, motion.error, atol=1e-12)


def test_the_simulators_steps_change_little():
    """The bound is of the equations: sixteen times finer steps leave the best sum as it is."""
    scenario, found = of("c-axis-ramp")
    fine = load_scenario(scenario, {"simulation.substeps": 16})
    total = np.abs(played(player(fine), found.voltage).error[:100]).sum()
    own = np.abs(played(player(scenario), found.voltage).error[:100]).sum()
    assert total == pytest.approx(own, rel=1e-3)


@pytest.mark.slow
def test_a_delay_and_a_smaller_limit_raise_the_bound():
    _, found = of("c-axis-ramp")
    _, late = of("c-axis-ramp", limits__delay_samples=1)
    _, weak = of("c-axis-ramp", limits__command=120.0)
    assert found.bound < late.bound
    assert found.bound < weak.bound
    assert late.voltage[0] == 0.0


def test_motions_of_one_and_two_samples_have_bounds():
    """The voltage of the first sample moves the spindle by next to nothing at the second."""
    _, one = of("c-axis-ramp", simulation__duration_s=0.001)
    assert (one.bound, one.reached, len(one.voltage)) == (0.0, 0.0, 1)
    _, two = of("c-axis-ramp", simulation__duration_s=0.002)
    assert two.bound == pytest.approx(2e-5, rel=1e-3)
    assert two.bound <= two.reached <= 2e-5


def test_a_motion_that_asks_for_nothing_has_a_bound_of_zero():
    _, found = of("c-axis-ramp", reference__velocity=0.0)
    assert found.bound == 0.0
    assert found.reached == pytest.approx(0.0, abs=1e-12)
