"""What the closed loop of one machine does in a control sample, in scalars.

Sensors, controller, drives, objectives. ``population`` runs it over the samples, for many::

    carry = start(loop, zero, samples.start, samples.beside)
    carry, recorded = sample(loop, told, fixed, sample_time, gains, carry, row)  # once a sample
    judged = loop.judge.judged(carry.sums, positions(loop, carry))
"""

from typing import NamedTuple

import jax.numpy as jnp

from hfc_design.controllers.controller import Controller, PathView, View
from hfc_design.core.numbers import Gains, Memory, Parameters, Scalar, State, Xp
from hfc_design.files.scenario import Scenario
from hfc_design.motion.contour import local_error
from hfc_design.motion.samples import AxisSamples, Samples
from hfc_design.objectives.judge import Judge
from hfc_design.objectives.objective import Moment, Sums
from hfc_design.simulation.sensors import (
    Angles,
    Sensors,
    converted,
    largest_command,
    measured,
    read,
    sensors_of,
)
from plants import Drive, Machine
from plants.blocks import decay, once, pick, ratio

#: The functions of the control laws on JAX scalars, which ``population`` makes vectors of.
LANES = Xp(jnp.where, jnp.minimum, jnp.maximum, decay, ratio, once, pick)


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

    @property
    def doubled(self) -> bool:
        """Whether a copy of the machine, that began a little off, runs beside it."""
        return any(one.doubled for one in self.judge.measured)


def closed_loop(scenario: Scenario, controller: Controller) -> Loop:
    """The loop of ``scenario`` with ``controller`` in it."""
    machine, simulation = scenario.plant.machine, scenario.simulation
    every = simulation.sample_time_s
    sensors = (sensors_of(scenario.sensors.of(axis), every) for axis in machine.axes)
    limits = [scenario.limits.of(axis) for axis in machine.axes]
    return Loop(
        machine,
        controller,
        scenario.judge(),
        simulation.substeps,
        tuple(map(largest_command, limits)),
        tuple(sensors),
        tuple(own.resolution for own in limits),
        tuple(own.delay_samples > 0 for own in limits),
    )


#: How long an axis has to stand until it sticks [s]: the trembling of a noisy command is shorter.
STANDING = 0.01


class Carry(NamedTuple):
    """What the machine carries from sample to sample."""

    states: tuple[State, ...]  # of each drive
    angles: tuple[Angles, ...]  # that its encoders read, or its observers had, before
    rates: tuple[Angles, ...]  # that its observers had
    waiting: tuple[Scalar | None, ...]  # command that acts in this sample, where it is delayed
    memory: Memory  # of the controller
    commands: tuple[Scalar, ...]  # of the previous sample
    means: tuple[Scalar, ...]  # of the velocities, over the last ``STANDING``
    sums: tuple[Sums, ...]  # of the objectives
    beside: "Beside | None" = None


class Beside(NamedTuple):
    """A copy of the machine with a controller of its own, that began a little off."""

    carry: Carry
    off: tuple[Scalar, ...]  # of each axis, by how much


class Recorded(NamedTuple):
    """One axis at the start of a sample; of whole motions leaves are (steps, individuals).

    The command is the one that acts on the drive in the sample.
    """

    error: Scalar
    error_rate: Scalar
    command: Scalar
    state: State


def start(
    loop: Loop, zero: Scalar, started: tuple[State, ...], beside: tuple[State, ...] = ()
) -> Carry:
    """A machine before the first sample, at ``started`` and with nothing to remember.

    Where the loop is ``doubled`` a copy begins at ``beside``.
    """
    states = tuple(type(state)(*(zero + x for x in state)) for state in started)
    angles, rates, pairs = [], [], [*zip(loop.machine.drives, states, strict=True)]
    for drive, state, sensors in zip(loop.machine.drives, states, loop.sensors, strict=True):
        observed = sensors is not None and sensors.velocity == "observer"
        angles.append({angle: getattr(state, angle) for angle in drive.encoders})
        each = drive.encoders.items() if observed else ()
        rates.append({angle: getattr(state, velocity) for angle, velocity in each})
    carry = Carry(
        states,
        tuple(angles),
        tuple(rates),
        tuple(zero if later else None for later in loop.delayed),
        loop.controller.initial_memory(zero),
        (zero,) * len(states),
        tuple(getattr(state, drive.velocity) for drive, state in pairs),
        loop.judge.initial(zero),
    )
    if not loop.doubled or not beside:
        return carry
    copy = start(loop, zero, beside)
    off = (b - a for a, b in zip(positions(loop, carry), positions(loop, copy), strict=True))
    return carry._replace(beside=Beside(copy._replace(sums=()), tuple(off)))


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
    about = (told, fixed, sample_time, gains)
    after, commands = _moved(loop, *about, carry, row)
    moments, outputs = [], []
    happening = row._replace(sample_time=sample_time)
    for k, command in enumerate(commands):
        moment = _moment(loop, k, fixed[k], carry, command, happening)
        moments.append(moment)
        outputs.append(Recorded(moment.error, moment.error_rate, command, carry.states[k]))
    if carry.beside is not None:
        other, off = carry.beside
        moments = [_apart(loop, k, one, carry, other, off[k]) for k, one in enumerate(moments)]
        after = after._replace(beside=Beside(_moved(loop, *about, other, row)[0], off))
    sums = loop.judge.update(carry.sums, tuple(moments), row.path)
    means = tuple(moment.velocity for moment in moments)
    return after._replace(means=means, sums=sums), tuple(outputs)


def _moved(
    loop: Loop,
    told: tuple[Parameters, ...],
    fixed: tuple[Parameters, ...],
    sample_time: Scalar,
    gains: Gains,
    carry: Carry,
    row: Samples,
) -> tuple[Carry, tuple[Scalar, ...]]:
    """The machine a sample later, its sums as they were, and the commands that acted on it."""
    machine, axes = loop.machine, range(len(loop.machine.drives))
    each = (_sensed(loop, k, fixed[k], carry, row.axes[k], sample_time) for k in axes)
    seen, signals, angles, rates = zip(*each, strict=True)
    view = View(signals, _path_view(loop, seen, row), told)
    asked, memory = loop.controller.step(LANES, gains, carry.memory, view)
    held = tuple(converted(asked[k], loop.limits[k], loop.resolutions[k]) for k in axes)
    acting = tuple(carry.waiting[k] if loop.delayed[k] else held[k] for k in axes)
    waiting = tuple(held[k] if loop.delayed[k] else None for k in axes)
    commands = tuple(machine.drives[k].accepted(fixed[k], acting[k]) for k in axes)
    loads = tuple(axis.loads for axis in row.axes)
    states = machine.moved(fixed, carry.states, commands, loads, sample_time, loop.substeps)
    after = Carry(states, angles, rates, waiting, memory, commands, carry.means, carry.sums)
    return after, commands


def _sensed(
    loop: Loop, k: int, fixed: Parameters, carry: Carry, row: AxisSamples, sample_time: Scalar
) -> tuple[State, dict[str, Scalar], Angles, Angles]:
    """State and signals of axis ``k`` as the controller sees them; angles and rates to carry on."""
    drive, sensors, before = (
        loop.machine.drives[k],
        loop.sensors[k],
        (carry.angles[k], carry.rates[k]),
    )
    found = measured(sensors, drive, fixed, carry.states[k], before, row, sample_time)
    seen, angles, rates = found
    return seen, read(sensors, drive, axis_signals(drive, fixed, seen, row), row), angles, rates


def _moment(
    loop: Loop, k: int, fixed: Parameters, carry: Carry, command: Scalar, row: Samples
) -> Moment:
    """What the objectives see of axis ``k``."""
    drive, state, happens = loop.machine.drives[k], carry.states[k], row.axes[k]
    position, limit = getattr(state, drive.position), loop.limits[k]
    rate = happens.reference_rate
    velocity, before = getattr(state, drive.velocity), carry.means[k]
    taken = row.sample_time / (row.sample_time + STANDING)
    limit = jnp.inf if limit is None else limit
    low, high = drive.accepted(fixed, -limit), drive.accepted(fixed, limit)
    return Moment(
        error=happens.reference - position,
        error_rate=rate - velocity,
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
        velocity=before + taken * (velocity - before),
    )


def _apart(loop: Loop, k: int, moment: Moment, carry: Carry, other: Carry, off: Scalar) -> Moment:
    """The moment with how far the copy of axis ``k`` is from it, at each of its encoders."""
    drive, mine, theirs = loop.machine.drives[k], carry.states[k], other.states[k]
    places = {drive.position: drive.velocity, **drive.encoders}
    apart, rate = 0.0, 0.0
    for share, (place, velocity) in enumerate(places.items(), 1):  # unlike: see ``unsettled``
        apart = apart + (getattr(theirs, place) - getattr(mine, place)) / (share * off)
        rate = rate + (getattr(theirs, velocity) - getattr(mine, velocity)) / (share * off)
    return moment._replace(apart=apart, apart_rate=rate)


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
