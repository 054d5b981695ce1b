"""A cart with viscous friction alone, and what it does by SciPy: an oracle for identification.

With F the command and the load in N: mass dv/dt = force_gain F - viscous_friction v - pull - load.
"""

from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from scipy.signal import cont2discrete, dlsim

from hfc_design.identify.fit import Fit, Problem, settled
from hfc_design.identify.parameters import free_parameters
from hfc_design.identify.recording import Recording
from hfc_design.identify.replay import replay
from plants import Drive
from plants.drive import only_positive

EVERY = 1e-3  # sample time [s]


class Cart(NamedTuple):
    mass: float = 2.0  # [kg]
    viscous_friction: float = 8.0  # [N s/m]
    force_gain: float = 1.0  # [1]
    pull: float = 0.5  # [N]


class CartState(NamedTuple):
    position: Any  # [m]
    velocity: Any  # [m/s]


def step(p, x, force, loads, dt):
    """Exact for a constant force."""
    tau = p.mass / p.viscous_friction
    end = (p.force_gain * force - p.pull - loads[1]) / p.viscous_friction
    decayed = jnp.exp(-dt / tau)
    velocity = end + (x.velocity - end) * decayed
    return CartState(x.position + end * dt + (x.velocity - end) * tau * (1.0 - decayed), velocity)


CART = Drive(
    name="cart",
    parameters=Cart,
    fault=only_positive(Cart, pull=(lambda value: True, "any number")),
    units={
        "error": "m",
        "error_rate": "m/s",
        "command": "N",
        "load": "N",
        "velocity": "m/s",
        "position": "m",
    },
    initial_state=lambda zero: CartState(zero, zero),
    step=step,
    signals=lambda c, x: {"velocity": x.velocity},
    position="position",
    velocity="velocity",
    encoders={"position": "velocity"},
)


def driven(cart, force):
    """(steps,) where it goes from rest, by SciPy's zero-order hold."""
    rates = np.array([[0.0, 1.0], [0.0, -cart.viscous_friction / cart.mass]])
    pushed = np.array([[0.0], [1.0 / cart.mass]])
    system = cont2discrete((rates, pushed, np.array([[1.0, 0.0]]), np.zeros((1, 1))), EVERY)
    return dlsim(system, cart.force_gain * np.asarray(force) - cart.pull)[1][:, 0]


def forced(steps, seed=0):
    """(steps,) a force of three sines, smooth beside a sample."""
    time, turn = EVERY * np.arange(steps), 2.0 * np.pi
    phases = np.random.default_rng(seed).uniform(0.0, turn, 3)
    waves = zip((3.0, 2.0, 1.5), (0.5, 1.7, 4.3), phases, strict=True)
    return sum(a * np.sin(turn * f * time + p) for a, f, p in waves)


def recorded(place, force):
    """A log of the position alone."""
    still = np.zeros(len(place))
    outputs = {"position": np.asarray(place)}
    return Recording(outputs, force, None, still, still, still + 1.0, EVERY, 0.0)


def cart_fit(names, place, force, start=None, *, late=False, bandwidth=0.0, drive=CART):
    """The fit by one start of a log: the delay looked for too where ``late``."""
    wanted = free_parameters(drive, start or {}, names)
    residual = replay(wanted, recorded(place, force), bandwidth, 1)
    moves = np.append(np.ones(len(names)), [float(late), 0.0])
    problem = Problem(wanted, residual, np.array([np.std(place)]), moves, bandwidth)
    return settled(problem, wanted.begun, 1)


def fit_with(wanted, residual, slopes, *, scale=1.0, replayed=None, bandwidth=0.0):
    """A fit where it began, with this residual (steps,) and slopes (steps, names + 2)."""
    count = len(wanted.names) + 2
    problem = Problem(wanted, replayed, np.array([scale]), np.ones(count), bandwidth)
    return Fit(problem, wanted.begun, residual[:, None], slopes[:, None], 1)


def noisy(place, noise, seed):
    """A place as it is measured."""
    return place + np.random.default_rng(seed).normal(0.0, noise, len(place))
