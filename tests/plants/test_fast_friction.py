"""Friction of fast spindles in one step of 1 ms: against SciPy's Radau and against formulas."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import oracle
import pytest
from scipy.integrate import solve_ivp

from plants.blocks import STIFF, bristle, rk4_tr_bdf2
from plants.c_axis import CAxisParameters, CAxisState, coefficients, step

GAINS = (758.405, 743.010)  # of the PD part of Table I
PERIOD = 1e-3


def ramp(speed):
    return lambda t: (speed * t, speed)


def reversals(speed, period=0.2):
    rate = 2 * np.pi / period
    return lambda t: (speed / rate * (1 - np.cos(rate * t)), speed * np.sin(rate * t))


def stop(speed, period=0.2):
    """From rest to rest."""
    rate = 2 * np.pi / period

    def reference(t):
        t = min(t, period)
        return 0.5 * speed * (t - np.sin(rate * t) / rate), 0.5 * speed * (1 - np.cos(rate * t))

    return reference


def angles(reference, samples, dtype, **machine):
    """(samples,) spindle angle [rad] at the end of each, under the PD gains, from rest."""
    with jax.enable_x64(True):
        fixed = jax.tree.map(dtype, coefficients(CAxisParameters(**machine)))
        kp, kd = map(dtype, GAINS)

        def sample(x, told):
            place, rate = told
            voltage = kp * (place - x.spindle_angle) + kd * (rate - x.spindle_velocity)
            new = step(fixed, x, voltage, (dtype(0),) * 3, dtype(PERIOD))
            return new, new.spindle_angle

        told = np.array([reference(n * PERIOD) for n in range(samples)], dtype)
        start = CAxisState(*jnp.zeros(6, dtype))
        return np.asarray(jax.lax.scan(sample, start, tuple(told.T))[1], float)


@pytest.mark.parametrize(
    ("reference", "bound"),  # [rad]; about twice what is measured
    [
        *((ramp(speed), 2e-10) for speed in (0.002, 0.02, 0.05, 0.1)),
        *((ramp(speed), 2e-9) for speed in (0.2, 0.5, 1.1)),
        (reversals(0.05), 6e-8),
        (reversals(0.5), 3e-6),
        (reversals(1.1), 3e-6),
        (stop(0.05), 1e-7),
        (stop(0.5), 5e-7),
        (stop(1.1), 1e-6),
    ],
)
def test_one_step_a_millisecond_follows_radau(reference, bound):
    exact = oracle.closed_loop(None, *GAINS, 0.3, method="Radau", reference=reference)[0][1:, 3]
    assert abs(angles(reference, 300, np.float64) - exact).max() < bound
    # An angle of 0.3 rad is a multiple of 3e-8 in float32.
    assert abs(angles(reference, 300, np.float32) - exact).max() < bound + 5e-7


def test_a_light_spindle_that_is_thrown_from_rest_is_followed():
    """It passes the whole range from sticking to stiff within a step or two."""
    light = {"spindle_inertia": 0.3, "stiffness": 2000.0}
    rhs, fixed = oracle.plant(oracle.MACHINE | light), coefficients(CAxisParameters(**light))
    exact, found = np.zeros(6), CAxisState(*np.zeros(6))
    off, speeds = [], []
    for voltage in np.repeat([400.0, -800.0, 400.0, 0.0], 25):

        def rates(t, x, voltage=voltage):
            return rhs(x.tolist(), voltage, 0.0)

        exact = solve_ivp(rates, (0, PERIOD), exact, "Radau", rtol=1e-10, atol=1e-16).y[:, -1]
        with jax.enable_x64(True):
            found = step(fixed, found, voltage, (0.0,) * 3, PERIOD)
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
