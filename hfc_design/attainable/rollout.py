"""Simulation of the scenario's machine under given voltages, and its linearisation."""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array

from hfc_design.attainable.linear_program import Linear
from hfc_design.core import devices
from hfc_design.core.numbers import Floats, Parameters
from hfc_design.files.scenario import Scenario
from hfc_design.motion.samples import Samples
from hfc_design.simulation.sensors import converted, largest_command
from plants import Machine
from plants.c_axis import CAxisState

#: Index of the spindle's angle in the state of the drive.
ANGLE = CAxisState._fields.index("spindle_angle")


class Rollout(NamedTuple):
    """Inputs of a simulation except the voltage: the machine, its settings and its samples."""

    machine: Machine
    substeps: int
    limit: float | None  # [V]
    resolution: float | None  # of the converter [V]
    fixed: tuple[Parameters, ...]  # coefficients of the machine's only drive
    samples: Samples


class RolledOut(NamedTuple):
    """A simulated motion, in float64."""

    voltage: Floats  # (steps,) that acted [V]
    states: Floats  # (steps, 6) at the start of each sample
    error: Floats  # (steps,) [rad]


def rollout_of(scenario: Scenario) -> Rollout:
    """Return the rollout of the nominal machine of a ``scenario`` with one motion."""
    plant, axis = scenario.plant, scenario.plant.machine.axes[0]
    limits = scenario.limits.of(axis)
    return Rollout(
        plant.machine,
        scenario.simulation.substeps,
        largest_command(limits),
        limits.resolution or None,
        jax.tree.map(float, plant.machine.coefficients(plant.values())),
        scenario.samples(),
    )


def rolled_out(
    one: Rollout, voltage: Floats, feedback: tuple[Floats, Floats] | None = None
) -> RolledOut:
    """Return the first samples of the motion, under ``voltage`` (samples,) [V].

    ``feedback`` can hold the motion near states (samples, 6) by gains (samples, 6): the voltage is
    reduced by the gain times the deviation from the state. Limit and converter act on the result.
    """
    devices.configure()
    steps, start = len(voltage), np.array(one.samples.start[0], dtype=float)
    loads = np.asarray(one.samples.axes[0].loads).T[:steps]
    near, gain = feedback or (np.zeros((steps, len(start))),) * 2
    how, converter = (one.machine, one.substeps), (one.limit, one.resolution)
    clock = float(one.samples.sample_time)
    with jax.enable_x64(True):
        outputs = _played(how, converter, one.fixed, clock, start, loads, voltage, near, gain)
    voltages, states = (np.asarray(x) for x in outputs)
    target = np.asarray(one.samples.axes[0].target)[:steps]
    return RolledOut(voltages, states, target - states[:, ANGLE])


def answers(one: Rollout, voltage: Floats, states: Floats) -> Linear:
    """Return how small changes of voltage (samples,) and states (samples, 6) move the next one."""
    devices.configure()
    loads = np.asarray(one.samples.axes[0].loads).T[: len(voltage)]
    how, clock = (one.machine, one.substeps), float(one.samples.sample_time)
    with jax.enable_x64(True):
        a, b = _answers(how, one.fixed, clock, states, loads, voltage)
    return Linear(np.asarray(a), np.asarray(b)[..., None], ANGLE)


def _moved(
    how: tuple[Machine, int],
    fixed: tuple[Parameters, ...],
    time: Array,
    x: Array,
    loads: Array,
    voltage: Array,
) -> Array:
    """Return the state (6,) a sample later, by the same step as in every simulation."""
    machine, substeps = how
    states, given = (CAxisState(*x),), tuple(loads)
    (state,) = machine.moved(fixed, states, (voltage,), (given,), time, substeps)
    return jnp.stack(list(state))


@partial(jax.jit, static_argnums=0)
def _played(
    how: tuple[Machine, int],
    converter: tuple[Array | None, Array | None],
    fixed: tuple[Parameters, ...],
    time: Array,
    start: Array,
    loads: Array,
    voltage: Array,
    near: Array,
    gain: Array,
) -> tuple[Array, Array]:
    def body(x: Array, row: tuple[Array, ...]) -> tuple[Array, tuple[Array, Array]]:
        load, command, place, back = row
        acting = converted(command - back @ (x - place), *converter)
        return _moved(how, fixed, time, x, load, acting), (acting, x)

    return lax.scan(body, start, (loads, voltage, near, gain))[1]


@partial(jax.jit, static_argnums=0)
def _answers(
    how: tuple[Machine, int],
    fixed: tuple[Parameters, ...],
    time: Array,
    states: Array,
    loads: Array,
    voltage: Array,
) -> tuple[Array, Array]:
    def each(x: Array, load: Array, acting: Array) -> tuple[Array, Array]:
        a, b = jax.jacfwd(partial(_moved, how, fixed, time), argnums=(0, 2))(x, load, acting)
        return a, b

    return jax.vmap(each)(states, loads, voltage)
