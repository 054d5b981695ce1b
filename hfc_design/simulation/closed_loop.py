"""What the closed loop of one machine does in a control sample, in scalars.

Sensors, controller, drives, objectives. ``population`` runs it over the samples, for many::

    carry = start(loop, zero)
    carry, recorded = sample(loop, told, fixed, sample_time, gains, carry, row)  # once a sample
    judged = loop.judge.judged(carry.sums, positions(loop, carry))
"""

from math import exp, floor, pi
from typing import NamedTuple

import jax.numpy as jnp

from hfc_design.controllers.controller import Controller, PathView, View
from hfc_design.core.numbers import Gains, Memory, Parameters, Scalar, State, Xp
from hfc_design.files.design import Limits
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

    encoder_resolution: float  # in the units of the drive; 0 means ideal
    velocity: str  # where it comes from, see ``SensorSettings``
    observer: tuple[float, float]  # gains of the observer of velocity
    readings: tuple[tuple[str, float], ...]  # other signals that are measured, their resolutions


class Loop(NamedTuple):
    """The closed loop as code; everything else is data. One ``Loop`` compiles once a shape."""

    machine: Machine
    controller: Controller
    judge: Judge
    substeps: int
    limits: tuple[float | None, ...]  # of the drives' commands
    sensors: tuple[Sensors | None, ...]  # of each axis, None where ideal
    resolutions: tuple[float, ...]  # of the drives' converters, 0 where ideal
    delayed: tuple[bool, ...]  # whether a command acts a sample later


def closed_loop(scenario: Scenario, controller: Controller) -> Loop:
    """The loop of ``scenario`` with ``controller`` in it."""
    machine, simulation = scenario.plant.machine, scenario.simulation
    sensors = (_sensors(scenario.sensors.of(x), simulation.sample_time_s) for x in machine.axes)
    limits = [scenario.limits.of(axis) for axis in machine.axes]
    return Loop(
        machine,
        controller,
        scenario.judge(),
        simulation.substeps,
        tuple(map(_largest, limits)),
        tuple(sensors),
        tuple(own.resolution for own in limits),
        tuple(own.delay_samples > 0 for own in limits),
    )


def _sensors(wanted: SensorSettings, sample_time: float) -> Sensors | None:
    read = tuple((name, own.resolution) for name, own in wanted.readings.items())
    exact = wanted.encoder_resolution == wanted.noise == 0.0
    if exact and wanted.velocity == "tachometer" and not read:
        return None
    gains = observer_gains(wanted.observer_hz or 0.0, sample_time)
    return Sensors(wanted.encoder_resolution, wanted.velocity, gains, read)


def observer_gains(bandwidth: float, sample_time: float) -> tuple[float, float]:
    """Gains alpha and beta of an observer of a ``bandwidth`` [Hz] in samples of a time [s].

    It follows an angle as the tracking loops of type II do that resolver-to-digital converters
    and encoder interfaces of drives have (Analog Devices, data sheet of the AD2S1210), sampled: a
    critically damped alpha-beta filter with both poles at exp(-2 pi f T) (Brookner 1998, sec. 1.3).
    """
    pole = exp(-2.0 * pi * bandwidth * sample_time)
    return 1.0 - pole**2, (1.0 - pole) ** 2


def _largest(limits: Limits) -> float | None:
    """The largest command in whole steps of the converter."""
    if limits.command is None or not limits.resolution:
        return limits.command
    return limits.resolution * floor(limits.command / limits.resolution * (1.0 + 1e-12))


class Carry(NamedTuple):
    """What the machine carries from sample to sample."""

    states: tuple[State, ...]  # of each drive
    angles: tuple[dict[str, Scalar], ...]  # that its encoders read, or its observers had, before
    rates: tuple[dict[str, Scalar], ...]  # that its observers had
    waiting: tuple[Scalar | None, ...]  # command that acts in this sample, where it is delayed
    memory: Memory  # of the controller
    sums: tuple[Sums, ...]  # of the objectives


class Recorded(NamedTuple):
    """One axis at the start of a sample; of whole motions leaves are (steps, individuals).

    The command is the one that acts on the drive in the sample.
    """

    error: Scalar
    error_rate: Scalar
    command: Scalar
    state: State


def start(loop: Loop, zero: Scalar) -> Carry:
    """A machine before the first sample: everything is ``zero``."""
    drives = loop.machine.drives
    observed = (own is not None and own.velocity == "observer" for own in loop.sensors)
    pairs = zip(drives, observed, strict=True)
    return Carry(
        loop.machine.initial_state(zero),
        tuple(dict.fromkeys(drive.encoders, zero) for drive in drives),
        tuple(dict.fromkeys(drive.encoders if own else (), zero) for drive, own in pairs),
        tuple(zero if later else None for later in loop.delayed),
        loop.controller.initial_memory(zero),
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
    seen, angles, rates = zip(
        *(_measured(loop, k, fixed[k], carry, row.axes[k], sample_time) for k in axes), strict=True
    )
    signals = tuple(axis_signals(machine.drives[k], fixed[k], seen[k], row.axes[k]) for k in axes)
    signals = tuple(_read(loop, k, signals[k], row.axes[k]) for k in axes)
    view = View(signals, _path_view(loop, seen, row), told)
    asked, memory = loop.controller.step(LANES, gains, carry.memory, view)
    held = tuple(_converted(loop, k, asked[k]) for k in axes)
    acting = tuple(carry.waiting[k] if loop.delayed[k] else held[k] for k in axes)
    waiting = tuple(held[k] if loop.delayed[k] else None for k in axes)
    commands = tuple(machine.drives[k].accepted(fixed[k], acting[k]) for k in axes)
    loads = tuple(axis.loads for axis in row.axes)
    states = machine.moved(fixed, carry.states, commands, loads, sample_time, loop.substeps)
    moments, outputs = [], []
    each = zip(machine.drives, carry.states, commands, row.axes, strict=True)
    for drive, state, command, happens in each:
        position = getattr(state, drive.position)
        error = happens.reference - position
        error_rate = happens.reference_rate - getattr(state, drive.velocity)
        deviation = position - happens.target
        rate = happens.reference_rate
        moments.append(Moment(error, error_rate, deviation, command, rate, row.settled))
        outputs.append(Recorded(error, error_rate, command, state))
    sums = loop.judge.update(carry.sums, tuple(moments), row.path)
    return Carry(states, angles, rates, waiting, memory, sums), tuple(outputs)


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


def _converted(loop: Loop, k: int, command: Scalar) -> Scalar:
    """What the converter of drive ``k`` holds of a command: bound, then in whole steps."""
    if (limit := loop.limits[k]) is not None:
        command = jnp.clip(command, -limit, limit)
    return _in_steps(command, loop.resolutions[k])


def _in_steps(value: Scalar, step: float) -> Scalar:
    """The nearest multiple of a step; the value itself without one."""
    return step * jnp.floor(value / step + 0.5) if step else value


def _read(loop: Loop, k: int, signals: dict[str, Scalar], row: AxisSamples) -> dict[str, Scalar]:
    """The signals of axis ``k`` with those that are measured apart as their sensors read them."""
    sensors = loop.sensors[k]
    if sensors is None or not sensors.readings:
        return signals
    noise = row.noise[len(loop.machine.drives[k].encoders) :]
    each = zip(sensors.readings, noise, strict=True)
    return signals | {
        name: _in_steps(signals[name] + disturbance, resolution)
        for (name, resolution), disturbance in each
    }


def _measured(
    loop: Loop, k: int, fixed: Parameters, carry: Carry, row: AxisSamples, sample_time: Scalar
) -> tuple[State, dict[str, Scalar], dict[str, Scalar]]:
    """The state of axis ``k`` as the controller sees it; angles and rates for the next sample.

    The position is always the reading. The velocity of an observer is that of its own estimate,
    which goes on with it and is corrected by what the reading is off.
    """
    drive, before, rates = loop.machine.drives[k], carry.angles[k], carry.rates[k]
    state = drive.measured(fixed, carry.states[k])
    sensors = loop.sensors[k]
    if sensors is None:
        return state, before, rates
    alpha, beta = sensors.observer
    seen, angles, estimates = {}, {}, {}
    for (angle, velocity), disturbance in zip(drive.encoders.items(), row.noise, strict=False):
        reading = _in_steps(getattr(state, angle) + disturbance, sensors.encoder_resolution)
        seen[angle] = angles[angle] = reading
        if sensors.velocity == "encoder":
            seen[velocity] = (reading - before[angle]) / sample_time
        elif sensors.velocity == "observer":
            expected = before[angle] + sample_time * rates[angle]
            off = reading - expected
            angles[angle] = expected + alpha * off
            seen[velocity] = estimates[angle] = rates[angle] + beta * off / sample_time
    return state._replace(**seen), angles, estimates
