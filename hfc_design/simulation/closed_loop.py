"""What the closed loop of one machine does in a control sample, in scalars.

Sensors, controller, plant, objectives. ``simulate`` runs it over the samples, for a population::

    carry = start(loop, axes, zero)
    carry, recorded = sample(loop, fixed, sample_time, gains, carry, row)  # once a sample
    judged = loop.judge.judged(carry.sums, positions(loop, carry))
"""

from typing import Any, NamedTuple

import jax.numpy as jnp
from jax import lax

from hfc_design.controllers.kinds import Controller
from hfc_design.files.scenario import Scenario
from hfc_design.motion.signals import AxisSamples, Samples
from hfc_design.objectives.judge import Judge
from hfc_design.objectives.objective import Moment
from plants import Plant


class Sensors(NamedTuple):
    """What stands between the machine's state and the controller."""

    encoder_resolution: float = 0.0  # in the units of the plant; 0 means ideal
    velocity_from_encoder: bool = False  # else an ideal tachometer


class Loop(NamedTuple):
    """The closed loop as code; everything else is data. One ``Loop`` compiles once a shape."""

    plant: Plant
    controller: Controller
    judge: Judge
    substeps: int = 1
    command_limit: float | None = None
    sensors: Sensors | None = None


def closed_loop(scenario: Scenario, controller: Controller) -> Loop:
    """The loop of ``scenario`` with ``controller`` in it."""
    wanted = scenario.sensors
    sensors = Sensors(wanted.encoder_resolution, wanted.velocity == "encoder")
    ideal = sensors == Sensors() and not wanted.noise
    return Loop(
        plant=scenario.plant.plant,
        controller=controller,
        judge=scenario.judge(),
        substeps=scenario.simulation.substeps,
        command_limit=scenario.limits.command,
        sensors=None if ideal else sensors,
    )


class AxisCarry(NamedTuple):
    """What one axis carries from sample to sample."""

    state: Any  # of the plant
    memory: Any  # of the controller
    angles: dict[str, Any]  # what the encoders read at the previous sample [rad]


class Carry(NamedTuple):
    """What the machine carries from sample to sample."""

    axes: tuple[AxisCarry, ...]
    sums: Any  # of the objectives


class Recorded(NamedTuple):
    """One axis at the start of a sample; of whole motions leaves are (steps, individuals)."""

    error: Any
    error_rate: Any
    command: Any
    state: Any


def start(loop: Loop, axes: int, zero: Any) -> Carry:
    """A machine of so many ``axes`` before the first sample: everything is ``zero``."""
    axis = AxisCarry(
        loop.plant.initial_state(zero),
        loop.controller.initial_memory(zero),
        dict.fromkeys(loop.plant.encoders, zero),
    )
    return Carry((axis,) * axes, loop.judge.initial(zero))


def positions(loop: Loop, carry: Carry) -> list[Any]:
    """Where each axis is."""
    return [getattr(axis.state, loop.plant.position) for axis in carry.axes]


def sample(
    loop: Loop, fixed: Any, sample_time: Any, gains: Any, carry: Carry, row: Samples
) -> tuple[Carry, tuple[Recorded, ...]]:
    """One control sample of one machine: every axis on its own, then the objectives of all.

    ``fixed`` is what ``Plant.coefficients`` gives for each axis, ``row`` one column of the
    samples, with loads and noise as tuples of scalars and ``sample_time`` [s] apart from it.
    """
    axes, moments, outputs = [], [], []
    for coefficients, axis, happens in zip(fixed, carry.axes, row.axes, strict=True):
        moved, moment, output = _axis_sample(
            loop, coefficients, sample_time, gains, axis, happens, row.settled
        )
        axes.append(moved)
        moments.append(moment)
        outputs.append(output)
    sums = loop.judge.update(carry.sums, tuple(moments), row.path)
    return Carry(tuple(axes), sums), tuple(outputs)


def _axis_sample(
    loop: Loop,
    fixed: Any,
    sample_time: Any,
    gains: Any,
    axis: AxisCarry,
    row: AxisSamples,
    settled: Any,
) -> tuple[AxisCarry, Moment, Recorded]:
    """One control sample of one axis: measure, control, hold the command, move."""
    plant = loop.plant
    state = axis.state
    seen, angles = _measured(
        loop, plant.measured(fixed, state), axis.angles, row.noise, sample_time
    )
    readings = plant.signals(fixed, seen)
    readings["error"] = row.reference - getattr(seen, plant.position)
    readings["error_rate"] = row.reference_rate - getattr(seen, plant.velocity)
    command, memory = loop.controller.step(gains, axis.memory, readings)
    if loop.command_limit is not None:
        command = jnp.clip(command, -loop.command_limit, loop.command_limit)
    command = plant.accepted(fixed, command)
    position = getattr(state, plant.position)
    error = row.reference - position
    error_rate = row.reference_rate - getattr(state, plant.velocity)
    moved = _moved(loop, fixed, state, command, row.loads, sample_time / loop.substeps)
    deviation = position - row.target
    moment = Moment(error, error_rate, deviation, command, row.reference_rate, settled)
    return AxisCarry(moved, memory, angles), moment, Recorded(error, error_rate, command, state)


def _measured(
    loop: Loop, state: Any, previous: dict[str, Any], noise: Any, sample_time: Any
) -> tuple[Any, dict[str, Any]]:
    """The state as the controller sees it, and the angles its encoders read."""
    sensors = loop.sensors
    if sensors is None:
        return state, previous
    angles = {}
    for (angle, _), disturbance in zip(loop.plant.encoders.items(), noise, strict=True):
        value = getattr(state, angle) + disturbance
        if sensors.encoder_resolution:
            step = sensors.encoder_resolution
            value = step * jnp.floor(value / step + 0.5)
        angles[angle] = value
    seen = dict(angles)
    if sensors.velocity_from_encoder:
        for angle, velocity in loop.plant.encoders.items():
            seen[velocity] = (angles[angle] - previous[angle]) / sample_time
    return state._replace(**seen), angles


def _moved(loop: Loop, fixed: Any, state: Any, command: Any, loads: Any, dt: Any) -> Any:
    """The state at the next sample: all substeps under one held command."""
    if loop.substeps == 1:
        return loop.plant.step(fixed, state, command, loads, dt)
    points = jnp.stack(loads)

    def substep(k: Any, state: Any) -> Any:
        here = (points[2 * k], points[2 * k + 1], points[2 * k + 2])
        return loop.plant.step(fixed, state, command, here, dt)

    return lax.fori_loop(0, loop.substeps, substep, state)
