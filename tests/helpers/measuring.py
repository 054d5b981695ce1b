"""Measures of a motion that is simulated, and of swings that are made up."""

from functools import cache

import jax
import jax.numpy as jnp
import numpy as np

from hfc_design.files.loop_setup import controller_of, load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.objectives.metrics import metric
from hfc_design.objectives.objective import Moment
from hfc_design.simulation import population
from hfc_design.simulation.closed_loop import closed_loop

#: A move to 20 mrad and a hold; it is to be settled after 1.5 s.
MOVE = {
    "name": "move",
    "reference": {"kind": "trapezoidal", "distance": 0.02, "velocity": 0.02, "acceleration": 0.2},
    "simulation": {"duration_s": 2.0},
    "fitness": {"settled_after_s": 0.5},
    "limits": {"command": 9.0},
    "load": {"constant": -5.0},
}


def measured(design, scenario, measures):
    """Of the only machine, in float64."""
    found = load_scenario(scenario)
    controller, gains = controller_of(load_design(design), found)
    loop = closed_loop(found, controller)
    loop = loop._replace(judge=loop.judge._replace(measured=tuple(measures)))
    machines = population.one_machine(found.plant.values())
    judged = population.scores(loop, machines, [found.samples()], gains, np.float64)
    return judged.values[0, 0, 0, -len(measures) :]


@cache
def _unsettled():
    own, moment = metric("unsettled"), Moment(*[jnp.zeros(())] * 6, sample_time=jnp.float64(1e-3))

    def one(sums, row):
        apart, speed, half = row
        here = moment._replace(apart=apart, apart_rate=speed, late=half)
        return own.update(sums, (here,), None), None

    def whole(rows):
        return own.value(jax.lax.scan(one, own.initial(jnp.zeros(())), rows)[0])

    return jax.jit(whole)


def unsettled(rate, period, phase=0.0, offset=0.0, size=1.0):
    """Of a swing of a ``size`` in the end that grows by e^(rate t), in a quarter of 0.6 s."""
    time = np.arange(-600, 0) * 1e-3
    turn = (2j * np.pi / period if period else 0.0) + rate
    swing = size * np.exp(turn * time + 1j * phase)
    late = np.repeat([1.0, 2.0], 300)
    with jax.enable_x64(True):
        return float(_unsettled()((offset + swing.real, (turn * swing).real, late)))
