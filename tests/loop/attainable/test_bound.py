"""The bound: against programmes formed by hand, SciPy's integrator, and motions that exist."""

from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hfc_design.attainable.attainable import attainable
from hfc_design.attainable.certificate import Bounds
from hfc_design.attainable.linear_model import ANGLE, MOMENTUM, linear_model, sampled, undriven
from hfc_design.attainable.open_loop import best_voltage
from hfc_design.attainable.reachable import reachable
from hfc_design.attainable.rollout import rolled_out, rollout_of
from hfc_design.attainable.sliding import Case, bent
from hfc_design.files.named_scenario import load_scenario
from plants.c_axis import CAxisParameters, CAxisState, coefficients, derivative

LIMIT = 250.0
RAMP = {"limits.command": LIMIT, "simulation.duration_s": 0.1}
MACHINE = linear_model(CAxisParameters())


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
    true = solve_ivp(rates, (0.0, 0.1), np.zeros(6), **given)
    found = solve_ivp(linear, (0.0, 0.1), np.zeros(5), **given)
    assert found.y[ANGLE, -1] == pytest.approx(true.y[3, -1], abs=1e-9)
    z, speed = true.y[5, -1], true.y[4, -1]
    momentum = CAxisParameters().spindle_inertia * speed + 126.5 * z
    assert found.y[MOMENTUM, -1] == pytest.approx(momentum, abs=1e-8)


def test_bristles_and_states_stay_within_reach():
    """Of a hundred motions by random voltages, load and all."""
    scenario = load_scenario("c-axis-ramp-cutting", RAMP)
    play = rollout_of(scenario)
    one, generator = sampled(MACHINE, 0.001), np.random.default_rng(1)
    start = CAxisState(*play.samples.start[0])
    moved = undriven(MACHINE, play.samples, 1, start)
    loads = play.samples.axes[0].loads
    steps = len(moved) - 1
    found = reachable(MACHINE, one, moved, loads, np.full(steps, LIMIT))
    for k in range(100):
        held = int(generator.integers(1, 50))
        voltage = LIMIT * np.sign(generator.standard_normal(steps // held + 1)).repeat(held)[:steps]
        states = rolled_out(play, np.append(voltage, 0.0)).states
        z, speed = np.abs(states[:, 5]), np.abs(states[:, 4])
        assert (z[1:] <= found.bristles * (1 + 1e-6)).all(), k
        assert (speed[1:] <= found.speed).all(), k
        momentum = 5.102 * states[:, 4] + 126.5 * states[:, 5]
        assert (np.abs(momentum[1:]) <= found.states[:, MOMENTUM]).all(), k
        bending = np.abs(np.diff(momentum, 2)) / 0.001**2
        assert (bending <= 1.01 * np.maximum(found.bending[:-1], found.bending[1:])).all(), k


def test_bristles_follow_what_is_known_of_the_speed():
    """The bounds hold along random motions whose speed is known to within a band, signs too."""
    play = rollout_of(load_scenario("c-axis-ramp", RAMP))
    one, generator = sampled(MACHINE, 0.001), np.random.default_rng(2)
    moved = undriven(MACHINE, play.samples, 1, CAxisState(*play.samples.start[0]))
    loads, steps = play.samples.axes[0].loads, len(moved) - 1
    reached = reachable(MACHINE, one, moved, loads, np.full(steps, LIMIT))
    widest = Bounds(np.full(steps, LIMIT), -reached.bristles, reached.bristles)
    case = Case(MACHINE, one, moved, np.zeros(steps), reached, widest, np.inf)
    narrow = 0
    for _ in range(30):
        held = int(generator.integers(10, 80))
        voltage = LIMIT * generator.uniform(-1, 1, steps // held + 1).repeat(held)[:steps]
        states = rolled_out(play, np.append(voltage, 0.0)).states
        ends = np.stack([states[:-1, 4], states[1:, 4]])
        low, high = ends.min(axis=0) - 2e-4, ends.max(axis=0) + 2e-4
        found = bent(case, low, high)
        for z in (states[:-1, 5], states[1:, 5]):
            assert (found.low - 1e-8 <= z).all()
            assert (z <= found.high + 1e-8).all()
        narrow += (found.high - found.low < 0.1 * MACHINE.largest).sum()
    assert narrow > 30 * steps / 4  # it says something


def test_the_simulators_steps_change_little():
    """The bound is of the equations: sixteen times finer steps leave the best sum as it is."""
    scenario = load_scenario("c-axis-ramp", RAMP)
    play, fine = (rollout_of(load_scenario(scenario, {"simulation.substeps": n})) for n in (1, 16))
    steps = len(play.samples.axes[0].target)
    voltage = best_voltage(play, np.zeros(steps), np.full(steps, LIMIT)).voltage
    total, own = (np.abs(rolled_out(one, voltage).error).sum() for one in (fine, play))
    assert total == pytest.approx(own, rel=1e-3)


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
