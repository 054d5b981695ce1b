"""The scalar building blocks of a control step and their derivatives."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from plants.blocks import decay, ratio


@pytest.mark.parametrize(("lowest", "error"), [(-10.0, 7e-7), (-87.0, 8e-6)])
def test_decay_in_float32(lowest, error):
    x = np.linspace(lowest, 0.0, 1_000_001).astype(np.float32)
    found = np.asarray(jax.jit(decay)(x), np.float64)
    assert abs(found / np.exp(x.astype(np.float64)) - 1).max() < error


def test_decay_in_float32_ends_in_zero():
    x = np.array([-88.0, -200.0, -1e30, -np.inf], np.float32)
    assert (np.asarray(jax.jit(decay)(x)) == 0.0).all()
    assert decay(jnp.float32(0.0)) == pytest.approx(1.0, abs=2e-7)


def test_decay_in_float64_is_exp():
    x = np.linspace(-700.0, 0.0, 10_001)
    np.testing.assert_allclose(jax.jit(decay)(x), np.exp(x), rtol=1e-15)
    assert np.isnan(decay(jnp.float64(np.nan)))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_decay_is_its_own_derivative(dtype):
    for x in (-80.0, -3.3, -0.5, 0.0):
        assert jax.grad(decay)(dtype(x)) == pytest.approx(float(np.exp(x)), rel=1e-5)


def test_ratio_follows_the_quotient_rule():
    value, slope = jax.jvp(ratio, (3.0, 4.0), (0.5, -0.25))
    assert value == 0.75
    assert slope == pytest.approx((0.5 * 4.0 - 3.0 * -0.25) / 4.0**2)
