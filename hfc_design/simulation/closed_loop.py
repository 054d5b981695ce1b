"""What the closed loop of one machine does in a control sample, in scalars.

Sensors, controller, drives, objectives. ``population`` runs it over the samples, for many::

    carry = start(loop, zero, samples.start)
    carry, recorded = sample(loop, told, fixed, sample_time, gains, carry, row)  # once a sample
    judged = loop.judge.judged(carry.sums, positions(loop, carry))
"""

from typing import NamedTuple

import jax.numpy as jnp

from hfc_design.controllers.controller import Controller, PathView, View
from hfc_design.core.numbers import Gains, Memory, Parameters, Scalar, State, Xp
from hfc_design.files.machine import SensorSettings
from hfc_design.files.scenario import Scenario
from hfc_design.motion.contour import local_error
from hfc_design.motion.samples import AxisSamples, Samples
from hfc_design.objectives.judge import Judge
from hfc_design.objectives.objective import Moment, Sums
from plants import Drive, Machine
from plants.blocks import decay, once, pick, ratio

#: The functions of the control laws on JAX scalars, which ``population`` makes vectors of.
LANES = Xp(jnp.where, jnp.minimum, jnp.maximum, decay, ratio, once, pick)


class Sensors(NamedTuple):
    """What stands between the state of an axis and the controller."""

    encoder_resolution: float = 0.0  # in the units of the drive; 0 means ideal
    velocity_from_encoder: bool = False  # else an ideal tachometer


class Loop(NamedTuple):
    """The closed loop as code; everything else is data. One ``Loop`` compiles once a shape."""

    machine: Machine
    controller: Controller
    judge: Judge
    substeps: int
    limits: tuple[float | None, ...]  # of the drives' commands
    sensors: tuple[Sensors | None, ...]  # of each axis, None where ideal


def closed_loop(scenario: Scenario, controller: Controller) -> Loop:
    """The loop of ``scenario`` with ``controller`` in it."""
    machine = scenario.plant.machine
    sensors = tuple(_sensors(scenario.sensors.of(axis)) for axis in machine.axes)
    limits = tuple(scenario.target.limits.values())
    substeps = scenario.simulation.substeps
    return Loop(machine, controller, scenario.judge(), substeps, limits, sensors)


def _sensors(wanted: SensorSettings) -> Sensors | None:
    if wanted.encoder_resolution == wanted.noise == 0.0 and wanted.velocity == "tachometer":
        return None
    return Sensors(wanted.encoder_resolution, wanted.velocity == "encoder")


class Carry(NamedTuple):
    """What the machine carries from sample to sample."""

    states: tuple[State, ...]  # of each drive
    angles: tuple[dict[str, Scalar], ...]  # what its encoders read at the previous sample
    memory: Memory  # of the controller
    commands: tuple[Scalar, ...]  # of the previous sample
    sums: tuple[Sums, ...]  # of the objectives


class Recorded(NamedTuple):
    """One axis at the start of a sample; of whole motions leaves are (steps, individuals)."""

    error: Scalar
    error_rate: Scalar
    command: Scalar
    state: State


def start(loop: Loop, zero: Scalar, started: tuple[State, ...]) -> Carry:
    """A machine before the first sample, at ``started`` and with nothing to remember."""
    states = tuple(type(state)(*(zero + x for x in state)) for state in started)
    pairs = zip(loop.machine.drives, states, strict=True)
    return Carry(
        states,
        tuple({angle: getattr(state, angle) for angle in drive.encoders} for drive, state in pairs),
        loop.controller.initial_memory(zero),
        (zero,) * len(states),
        loop.judge.initial(zero),
    )


def positions(loop: Loop, carry: Carry) -> list[Scalar]:
    """Where each axis is."""
    pairs = zip(loop.machine.drives, carry.states, strict=True)
    return [getattr(state, drive.position) for drive, state in pairs]


def sample(
    loop: Loop,
    told: tuple[Parameters, ...],
    fixed: tuple[Parameters, ...],
    sample_time: Scalar,
    gains: Gains,
    carry: Carry,
    row: Samples,
) -> tuple[Carry, tuple[Recorded, ...]]:
    """One control sample of one machine: measure, control, hold the commands, move.

    ``told`` are the parameters that the control believes in, ``fixed`` what ``coefficients``
    makes of the true ones, ``row`` one column of the samples, with loads and noise as tuples of
    scalars and ``sample_time`` [s] apart from it.
    """
    machine, axes = loop.machine, range(len(loop.machine.drives))
    seen, angles = zip(
        *(_measured(loop, k, fixed[k], carry, row.axes[k], sample_time) for k in axes), strict=True
    )
    signals = tuple(axis_signals(machine.drives[k], fixed[k], seen[k], row.axes[k]) for k in axes)
    view = View(signals, _path_view(loop, seen, row), told)
    commands, memory = loop.controller.step(LANES, gains, carry.memory, view)
    commands = tuple(_accepted(loop, k, fixed[k], commands[k]) for k in axes)
    loads = tuple(axis.loads for axis in row.axes)
    states = machine.moved(fixed, carry.states, commands, loads, sample_time, loop.substeps)
    moments, outputs = [], []
    happening = row._replace(sample_time=sample_time)
    for k in axes:
        moment = _moment(loop, k, fixed[k], carry, commands[k], happening)
        moments.append(moment)
        outputs.append(Recorded(moment.error, moment.error_rate, commands[k], carry.states[k]))
    sums = loop.judge.update(carry.sums, tuple(moments), row.path)
    return Carry(states, angles, memory, commands, sums), tuple(outputs)


def _moment(
    loop: Loop, k: int, fixed: Parameters, carry: Carry, command: Scalar, row: Samples
) -> Moment:
    """What the objectives see of axis ``k``."""
    drive, state, happens = loop.machine.drives[k], carry.states[k], row.axes[k]
    position, limit = getattr(state, drive.position), loop.limits[k]
    rate = happens.reference_rate
    limit = jnp.inf if limit is None else limit
    low, high = drive.accepted(fixed, -limit), drive.accepted(fixed, limit)
    return Moment(
        error=happens.reference - position,
        error_rate=rate - getattr(state, drive.velocity),
        deviation=position - happens.target,
        command=command,
        reference_rate=rate,
        settled=row.settled,
        command_change=command - carry.commands[k],
        limited=(command <= low) | (command >= high),
        sliding=happens.sliding,
        beyond=jnp.maximum((position - happens.end) * jnp.sign(happens.end), 0.0),
        late=row.late,
        time=row.time,
        sample_time=row.sample_time,
    )


def axis_signals(
    drive: Drive, fixed: Parameters, seen: State, row: AxisSamples
) -> dict[str, Scalar]:
    """What an axis tells the controller."""
    position, velocity = drive.seen
    return {
        **drive.signals(fixed, seen),
        "error": row.reference - getattr(seen, position),
        "error_rate": row.reference_rate - getattr(seen, velocity),
        "reference": row.reference,
        "reference_rate": row.reference_rate,
        "reference_acceleration": row.reference_acceleration,
    }


def _path_view(loop: Loop, seen: tuple[State, ...], row: Samples) -> PathView | None:
    """The path and the contour error as the control can know it: by what it measures."""
    path = row.path
    if path is None:
        return None
    each = zip(loop.machine.drives, seen, row.axes, strict=True)
    x, y = (getattr(state, drive.seen[0]) - axis.reference for drive, state, axis in each)
    return PathView(*path, local_error(x, y, *path))


def _accepted(loop: Loop, k: int, fixed: Parameters, command: Scalar) -> Scalar:
    """The command that reaches drive ``k``."""
    limit = loop.limits[k]
    if limit is not None:
        command = jnp.clip(command, -limit, limit)
    return loop.machine.drives[k].accepted(fixed, command)


def _measured(
    loop: Loop, k: int, fixed: Parameters, carry: Carry, row: AxisSamples, sample_time: Scalar
) -> tuple[State, dict[str, Scalar]]:
    """The state of axis ``k`` as the controller sees it, and the angles its encoders read."""
    drive, previous = loop.machine.drives[k], carry.angles[k]
    state = drive.measured(fixed, carry.states[k])
    sensors = loop.sensors[k]
    if sensors is None:
        return state, previous
    angles = {}
    for (angle, _), disturbance in zip(drive.encoders.items(), row.noise, strict=True):
        value = getattr(state, angle) + disturbance
        if step := sensors.encoder_resolution:
            value = step * jnp.floor(value / step + 0.5)
        angles[angle] = value
    seen = dict(angles)
    if sensors.velocity_from_encoder:
        for angle, velocity in drive.encoders.items():
            seen[velocity] = (angles[angle] - previous[angle]) / sample_time
    return state._replace(**seen), angles
