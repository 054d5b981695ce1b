"""The functions of the control laws on JAX scalars, which the simulator makes vectors of."""

import jax
import jax.numpy as jnp

from hfc_design.core.scalars import Xp
from plants.blocks import decay, ratio


def once(x: jax.Array) -> jax.Array:
    """``x``, finite, computed once: XLA repeats cheap operations in all that use them.

    A division it does not repeat, and it may not drop this one, because 0 x need not be 0. With
    it an adaptive step runs eight times as fast and compiles in half the time.
    """
    return x / (1.0 + 0.0 * x)


LANES = Xp(jnp.where, jnp.minimum, jnp.maximum, decay, ratio, once)
