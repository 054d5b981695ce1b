"""Back-propagation against derivatives that JAX finds, momentum and the law by hand."""

import jax
import jax.numpy as jnp
import numpy as np

from hfc_design.controllers.neural.network import Weights, changes, passed
from hfc_design.core.numbers import SCALARS

RATE, SLOPE = 0.3, 0.7


def cost(weights, inputs, targets):
    """Half the sum of the squares of the output errors, written once more with matrices."""
    hidden, output = weights
    active = jnp.tanh(SLOPE * (hidden[:, :-1] @ inputs + hidden[:, -1]))
    return 0.5 * jnp.sum((targets - output[:, :-1] @ active - output[:, -1]) ** 2)


def test_weights_move_down_the_derivative_of_the_squares():
    random = np.random.default_rng(0)  # two inputs, five hidden units, two outputs
    weights = Weights(random.normal(size=(5, 3)).tolist(), random.normal(size=(2, 6)).tolist())
    still, inputs, targets = Weights([[0.0] * 3] * 5, [[0.0] * 6] * 2), [0.4, -1.1], [0.3, -2.0]
    answer = passed(SCALARS, weights, SLOPE, inputs)
    off = [t - o for t, o in zip(targets, answer.outputs, strict=True)]
    moved = changes(SCALARS, weights, still, answer, off, RATE, 0.9, SLOPE)
    with jax.enable_x64(True):
        own = Weights(*map(jnp.array, weights))
        found = jax.jit(jax.grad(cost))(own, *map(jnp.array, (inputs, targets)))
    for steps, slopes in zip(moved, found, strict=True):
        np.testing.assert_allclose(np.array(steps), -RATE * np.array(slopes), rtol=1e-12)
