"""Single drives under voltages that are given: what they do in steps of one program."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

#: Numbers of steps that are compiled; a path is filled up to one of them.
LENGTHS = (400, 6_000, 16_000)


@partial(jax.jit, static_argnums=0)
def _moved(step, c, x, voltages, load, dt):
    def body(x, voltage):
        after = step(c, x, voltage, (load, load, load), dt)
        return after, after

    return jax.lax.scan(body, x, voltages)[1]


def path(drive, p, start, voltages, dt, load=0.0):
    """(steps, states) after each of ``voltages``."""
    steps = len(voltages)
    filled = np.zeros(min(length for length in LENGTHS if length >= steps))
    filled[:steps] = voltages
    x = type(drive.initial_state(0.0))(*map(jnp.float64, start))
    return np.stack(_moved(drive.step, drive.coefficients(p), x, filled, load, dt), 1)[:steps]
