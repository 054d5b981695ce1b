"""Logs of a mass under viscous friction, which SciPy makes."""

import numpy as np
from scipy.signal import cont2discrete, dlsim

EVERY = 1e-3
TIME = EVERY * np.arange(3000)
FORCE = 40.0 * np.sin(5.0 * TIME) + 25.0 * np.sin(23.0 * TIME + 1.0)  # [N]


def moved(mass, friction, force=FORCE, noise=2e-6, seed=0):
    """(steps,) where a mass goes under a force against viscous friction [m], measured."""
    rates = np.array([[0.0, 1.0], [0.0, -friction / mass]])
    parts = (rates, np.array([[0.0], [1.0 / mass]]), np.array([[1.0, 0.0]]), np.zeros((1, 1)))
    place = dlsim(cont2discrete(parts, EVERY), force)[1][:, 0]
    return place + np.random.default_rng(seed).normal(0.0, noise, len(force))


def write(name, head, *columns):
    """A log of columns beside the time."""
    np.savetxt(name, np.stack([TIME, *columns], axis=1), "%.12g", ",", header=head, comments="")
