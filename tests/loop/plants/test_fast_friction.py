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

        exact = solve_ivp(rates, (0, PERIOD), exact, "Radau", rtol=1e-10, atol=1e-16).y[:, -1]
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
