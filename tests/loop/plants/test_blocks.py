"""The scalar building blocks of a control step and their derivatives."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from plants.blocks import bell, larger, smaller

RATE = 4.0


@pytest.mark.parametrize(("lowest", "error"), [(-10.0, 1.1e-6), (-87.0, 8.5e-6)])
def test_bell_in_float32(lowest, error):
    distance = np.sqrt(np.linspace(0.0, -lowest / RATE, 1_000_001)).astype(np.float32)
    found = np.asarray(jax.jit(bell, static_argnums=0)(RATE, distance), np.float64)
    exact = np.exp(-RATE * distance.astype(np.float64) ** 2)
    assert abs(found / exact - 1).max() < error


def test_bell_in_float64_is_exp():
    distance = np.linspace(-13.0, 13.0, 10_001)
    exact = np.exp(-RATE * distance**2)
    np.testing.assert_allclose(jax.jit(bell, static_argnums=0)(RATE, distance), exact, rtol=1e-13)
    assert np.isnan(bell(RATE, jnp.float64(np.nan)))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_slope_of_bell(dtype):
    for x in (-4.0, -0.9, 0.0, 0.3):
        exact = -2.0 * RATE * x * np.exp(-RATE * x * x)
        assert jax.grad(bell, argnums=1)(RATE, dtype(x)) == pytest.approx(exact, rel=1e-5)


def test_bounds_keep_a_nan():
    assert [float(larger(x, -1.0)) for x in (-2.0, 0.5)] == [-1.0, 0.5]
    assert [float(smaller(x, 1.0)) for x in (2.0, 0.5)] == [1.0, 0.5]
    assert np.isnan(larger(np.nan, -1.0))
    assert np.isnan(smaller(np.nan, 1.0))
