"""The C-axis against its equations, against SciPy and against physics."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import oracle
import pytest
from scipy.integrate import solve_ivp

from plants.blocks import STIFF, bristle, rk4, rk4_tr_bdf2
from plants.c_axis import CAxisParameters, CAxisState, coefficients, derivative, step

FIXED, FREE = coefficients(CAxisParameters()), (0.0, 0.0, 0.0)


def test_derivative_is_equation_2():
    random = np.random.default_rng(1)
    for _ in range(100):
        machine = {name: value * random.uniform(0.9, 1.1) for name, value in oracle.MACHINE.items()}
        x = random.normal(size=6) * [5.0, 0.02, 0.2, 0.02, 0.01, 4e-5]
        voltage, load = random.normal(size=2) * [20.0, 5.0]
        found = derivative(coefficients(CAxisParameters(**machine)), CAxisState(*x), voltage, load)
        wanted = oracle.plant(machine)(x, voltage, load)
        np.testing.assert_allclose(found, wanted, rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize(("poles", "pair"), [(2, -4.6 + 20.8j), (4, 3.5 + 29.5j), (6, 8.2 + 32.3j)])
def test_published_gains_have_the_poles_that_settle_the_motor(poles, pair):
    fixed = coefficients(CAxisParameters(poles=poles))
    found = oracle.sliding_poles(
        lambda x, voltage, load: derivative(fixed, CAxisState(*x), voltage, load), 758.405, 743.010
    )
    nearest = found[np.argmin(abs(found - pair))]
    assert nearest == pytest.approx(pair, abs=0.08)
    assert (found.real.max() < 0) == (poles == 2)


def stepped(state, voltage, seconds, steps):
    """The state after ``steps`` RK4 steps without load."""
    return _stepped(FIXED, CAxisState(*map(jnp.float64, state)), voltage, seconds / steps, steps)


@jax.jit
def _stepped(fixed, x, voltage, dt, steps):
    def body(_, x):
        return step(fixed, x, voltage, FREE, dt)

    return jax.lax.fori_loop(0, steps, body, x)


def test_step_converges_with_order_4():
    """The spindle turns steadily, so that nothing has a corner; z starts off its steady value."""
    state, voltage, seconds = [4.0, 0.02, 0.05, 0.0, 0.03, 3e-5], 10.0, 0.05
    rhs = oracle.plant()
    exact = solve_ivp(
        lambda t, x: rhs(x, voltage, 0.0), (0, seconds), state, "DOP853", rtol=1e-13, atol=1e-17
    ).y
    assert exact[4].min() > 0.01
    size = abs(exact).max(axis=1)
    errors = [
        np.max(abs(np.array(stepped(state, voltage, seconds, steps)) - exact[:, -1]) / size)
        for steps in (100, 200, 400, 800)
    ]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert ((orders > 3.8) & (orders < 4.2)).all()


def energy(x, magnetic):
    """Kinetic, elastic and bristle energy [J], and the current's weighed with ``magnetic`` [H]."""
    m = oracle.MACHINE
    return 0.5 * (
        m["rotor_inertia"] * x.rotor_velocity**2
        + m["spindle_inertia"] * x.spindle_velocity**2
        + m["stiffness"] * (x.rotor_angle - x.spindle_angle) ** 2
        + m["bristle_stiffness"] * x.bristle_deflection**2
        + magnetic * x.current**2
    )


# Of its own account LuGre friction never gives energy back below 4 T_c / sigma_1 (there
# sigma_0 g s^2 + sigma_1 |w| (1 - s) >= 0 for every s = z sign(w) / g); above it may, while the
# bristles are bent further than g. From 1.2 mJ the spindle cannot turn faster than that limit.
PASSIVE_SPEED = 4 * 0.7 / 126.5
START_ENERGY = 0.5 * 5.102 * PASSIVE_SPEED**2


@jax.jit
def freed(fixed, start, magnetic):
    """Energies after each of 5,000 steps of 0.2 ms."""

    def body(x, _):
        moved = step(fixed, x, 0.0, FREE, 2e-4)
        return moved, energy(moved, magnetic)

    return jax.lax.scan(body, start, length=5000)[1]


@pytest.mark.parametrize("flux", [0.0, 0.6])
def test_free_machine_only_loses_energy(flux):
    """Without flux the motor is cut off; with it, its terminals are shorted.

    The back EMF takes (L_s lambda_r / L_m) i omega_r from the current, of which the rotor gets
    K_t i omega_r: weighed with the ratio of the two, magnetic energy is passed on and not made.
    """
    leakage = 0.341 - 0.225**2 / 0.306
    magnetic = leakage * 0.225**2 / (0.306 * 0.341)
    fixed = coefficients(CAxisParameters(rotor_flux=flux))
    random = np.random.default_rng(3)
    x = CAxisState(*(random.normal(size=(6, 200)) * [[1], [3e-3], [0.1], [3e-3], [0.02], [4e-5]]))
    if flux == 0.0:
        x = x._replace(current=np.zeros(200))
    factor = np.sqrt(START_ENERGY / energy(x, magnetic))
    possible = np.abs(x.bristle_deflection * factor) < 1.2 / 17000  # T_s / sigma_0
    assert possible.sum() > 50
    start = CAxisState(*(jnp.asarray((part * factor)[possible]) for part in x))

    later = freed(fixed, start, magnetic)
    history = np.concatenate([energy(start, magnetic)[None], later]) / START_ENERGY
    assert history[0] == pytest.approx(1.0)
    assert np.diff(history, axis=0).max() < 1e-9
    assert history[-1].max() < 0.9


class Bristle(NamedTuple):
    deflection: Any


FRICTION = FIXED.friction


@jax.jit
def bent(velocity, dt, steps):
    """Bristle deflections after ``steps`` at constant ``velocity``, starting straight."""

    def rate(z, load):
        return Bristle(bristle(FRICTION, velocity, z.deflection)[1])

    def body(_, z):
        return rk4(rate, z, FREE, dt)

    return jax.lax.fori_loop(0, steps, body, Bristle(jnp.zeros_like(velocity))).deflection


PERIOD = 1e-3


def test_a_light_spindle_that_is_thrown_from_rest_is_followed():
    """It passes the whole range from sticking to stiff within a step or two."""
    light = {"spindle_inertia": 0.3, "stiffness": 2000.0}
    rhs, fixed = oracle.plant(oracle.MACHINE | light), coefficients(CAxisParameters(**light))
    exact, found = np.zeros(6), CAxisState(*np.zeros(6))
    moved = jax.jit(lambda fixed, x, voltage: step(fixed, x, voltage, (0.0,) * 3, PERIOD))
    off, speeds = [], []
    for voltage in np.repeat([400.0, -800.0, 400.0, 0.0], 25):

        def rates(t, x, voltage=voltage):
            return rhs(x.tolist(), voltage, 0.0)

        exact = solve_ivp(rates, (0, PERIOD), exact, "Radau", rtol=1e-7, atol=1e-13).y[:, -1]
        with jax.enable_x64(True):
            found = moved(fixed, found, voltage)
        off.append(abs(found.spindle_velocity - exact[4]))
        speeds.append(abs(exact[4]))
    assert max(speeds) > 1.0
    assert max(off) < 4e-3 * max(speeds)


class Decaying(NamedTuple):
    value: Any
    clock: Any


def decayed(rate):
    """What a step leaves of a field that decays with ``rate`` per step, from 1."""

    def derivative(x, load, implicit):
        return Decaying(-rate * x.value / (1 + implicit * rate), 1.0)

    start = Decaying(jnp.float64(1.0), jnp.float64(0.0))
    return rk4_tr_bdf2(derivative, start, (0.0,) * 3, 1.0, "value", lambda x: rate)


def test_what_a_step_leaves_is_the_function_of_its_method():
    with jax.enable_x64(True):
        for rate in (0.0, 0.1, 1.0, 0.999 * STIFF):
            classical = 1 - rate + rate**2 / 2 - rate**3 / 6 + rate**4 / 24
            assert decayed(rate).value == pytest.approx(classical, rel=1e-14)
        for rate in (1.001 * STIFF, 3.0, 1e2, 1e6):
            middle = (1 - rate / 4) / (1 + rate / 4)
            assert decayed(rate).value == pytest.approx((4 * middle - 1) / (3 + rate), rel=1e-12)
            assert abs(decayed(rate).value) < 0.2
        assert decayed(1e6).clock == 1.0


def test_a_field_that_heads_for_a_fast_decay_is_implicit_at_once():
    def derivative(x, load, implicit):
        return Decaying(-2.0 * x.clock * x.value / (1 + implicit * 2.0 * x.clock), 1.0)

    with jax.enable_x64(True):
        start = Decaying(jnp.float64(1.0), jnp.float64(0.0))
        found = rk4_tr_bdf2(derivative, start, (0.0,) * 3, 1.0, "value", lambda x: 2.0 * x.clock)
    middle = 1 / (1 + 0.25)
    assert found.value == pytest.approx((4 * middle - 1) / 3 / (1 + 2 / 3), rel=1e-14)


def test_bristle_solves_its_implicit_equation():
    friction = coefficients(CAxisParameters()).friction
    velocity = np.array([-1.1, -0.003, 0.0, 1e-4, 0.5])
    g = (0.7 + 0.5 * np.exp(-((velocity / 0.003) ** 2))) / 17000.0
    with jax.enable_x64(True):
        for implicit in (0.0, 2.5e-4, 1.0):
            deflection, rate = bristle(friction, velocity, 2e-5, implicit)
            np.testing.assert_allclose(deflection, 2e-5 + implicit * rate, atol=1e-15)
            np.testing.assert_allclose(rate, velocity - abs(velocity) * deflection / g, atol=1e-15)
