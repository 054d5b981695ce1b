"""The self-organising fuzzy controller of a feed drive (Jee & Koren 1995), for the simulator."""

from functools import cache, partial

import jax.numpy as jnp

from hfc_design import aflc as law
from hfc_design.adaptation import blamed_soflc
from hfc_design.controllers.controller import Controller


@cache
def soflc(sample_time: float) -> Controller:
    """The controller of kind ``soflc``, sampled every ``sample_time`` [s].

    Its gains are ``AdaptiveGains``.
    """
    step = partial(law.step, jnp, blamed_soflc, sample_time)
    return Controller("soflc", law.initial_memory, step)
