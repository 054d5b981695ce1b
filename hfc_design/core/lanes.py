"""The functions of laws for JAX scalars: ``simulation`` vectorises, ``codegen`` translates them."""

from jax import numpy as jnp

from hfc_design.core.numbers import Xp
from plants.blocks import bell, larger, once, pick, ratio, smaller

LANES = Xp(jnp.where, smaller, larger, bell, jnp.tanh, ratio, once, pick, jnp.sqrt, jnp.floor)
