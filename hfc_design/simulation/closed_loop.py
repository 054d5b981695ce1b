"""One control sample of the closed loop of one machine, in scalars.

Sensors, controller, drives and objectives act in turn. ``stepping`` runs this for a population::

    machine = start(loop, fixed, zero, samples.start)
    watch = first_monitor(loop, zero, machine)
    after = next_state(loop, nominal, fixed, sample_time, gains, machine, row)  # once a sample
    watch, recorded = monitored(loop, fixed, sample_time, machine, after.commands, watch, row)
    judged = loop.judge.judged(watch.sums, positions(loop, after.states))
"""

from collections.abc import Sequence
from math import ceil
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from hfc_design.controllers.controller import Controller, PathView, View, begun
from hfc_design.core.lanes import LANES
from hfc_design.core.numbers import Gains, Memory, Parameters, Scalar, State
from hfc_design.files.scenario import Scenario
from hfc_design.motion.contour import off_path
from hfc_design.motion.samples import AxisSamples, Samples
from hfc_design.objectives.judge import Judge
from hfc_design.objectives.objective import Moment, Sums
from hfc_design.simulation.flattening import Code, separate
from hfc_design.simulation.sensors import (
    Angles,
    Rates,
    Sensors,
    converted,
    folded,
    in_steps,
    largest_command,
    measured,
    read,
    sensors_of,
    without_steps,
)
from plants import Drive, Machine
from plants.around import Sampled, Standing, sampled, surrounded


class Loop(NamedTuple):
    """The closed loop: its floats are inputs of a compiled program, the rest selects the program.

    One program therefore serves all values of the floats. A change of a name, of a count, or of
    which fields are None selects another program.
    """

    machine: Machine
    controller: Controller
    judge: Judge
    substeps: int
    limits: tuple[float | None, ...]  # largest command of each drive; None: unlimited
    sensors: tuple[Sensors | None, ...]  # of each axis, None where ideal
    resolutions: tuple[float | None, ...]  # of the drives' converters, None where ideal
    around: tuple[Sampled, ...] = ()  # effects around each drive; empty: none can be simulated

    @property
    def doubled(self) -> bool:
        """Whether a copy of the machine, with slightly shifted initial positions, is simulated."""
        return any(one.doubled for one in self.judge.measured)

    def coefficients(self, parameters: Sequence[Parameters]) -> tuple[Parameters, ...]:
        """Return the coefficients for a step, computed from the parameters of each axis.

        For parameters without effects around the drive (not ``Standing``) the effects are those of
        the loop.
        """
        axis_parameters = tuple(parameters)
        if self.around:
            pairs = zip(axis_parameters, self.around, strict=True)
            each = (x if isinstance(x, Standing) else Standing(x, around) for x, around in pairs)
            axis_parameters = tuple(each)
        return self.machine.coefficients(axis_parameters)

    @property
    def apart(self) -> tuple[Code, tuple[float, ...]]:
        """Code and numbers of the loop, see ``separate``; texts such as titles are left out."""
        return separate(self._replace(judge=self.judge.wordless))

    @property
    def smooth(self) -> "Loop":
        """The loop for differentiation: without the steps of encoders and converters.

        The slope of these steps would be 0. Metrics other than the objectives are not computed.
        """
        sensors = tuple(sensors and without_steps(sensors) for sensors in self.sensors)
        ideal = (None,) * len(self.resolutions)
        judge = self.judge._replace(measured=())
        return self._replace(judge=judge, sensors=sensors, resolutions=ideal)


def closed_loop(scenario: Scenario, controller: Controller, later: float | None = None) -> Loop:
    """Return the loop of ``scenario`` with ``controller`` in it.

    If ``later`` is a number of samples, the loop can have all effects around the drives (modes and
    gaps, for example), with delays that are up to ``later`` longer than in the scenario.
    """
    machine, simulation = scenario.machine, scenario.simulation
    every = simulation.sample_time_s
    sensors = (sensors_of(scenario.sensors.of(axis), every) for axis in machine.axes)
    limits = [scenario.limits.of(axis) for axis in machine.axes]
    longest = scenario.longest_delay
    standing: tuple[Sampled, ...] = ()
    if longest is not None or later is not None:
        waits = ceil((longest or 0.0) + (later or 0.0))
        machine = surrounded(machine, waits, simulation.substeps)
        standing = tuple(sampled(x, every, simulation.substeps, waits) for x in scenario.around)
    return Loop(
        machine,
        controller,
        scenario.judge(),
        simulation.substeps,
        tuple(map(largest_command, limits)),
        tuple(sensors),
        tuple(axis_limits.resolution or None for axis_limits in limits),
        standing,
    )


#: Time over which a velocity is averaged to see whether an axis sticks or only trembles [s].
STANDING = 0.01


class LoopState(NamedTuple):
    """State of a machine and its controller that is carried from sample to sample."""

    states: tuple[State, ...]  # of each drive
    angles: tuple[Angles, ...]  # earlier readings of encoders, or estimates of observers, by axis
    rates: tuple[Rates, ...]  # velocities that the observers estimated, by axis
    memory: Memory  # of the controller
    commands: tuple[Scalar, ...]  # of the previous sample


class Monitor(NamedTuple):
    """Sums and means of a machine's motion that are carried from sample to sample."""

    means: tuple[Scalar, ...]  # of the velocities, over about the last ``STANDING``
    sums: tuple[Sums, ...]  # of the objectives
    off: tuple[Scalar, ...] = ()  # initial position of the copy less the machine's, of each axis


class Recorded(NamedTuple):
    """Values of one axis at the start of a sample; leaves (steps, individuals) in a whole motion.

    The command is the one that the drive gets in that sample.
    """

    error: Scalar
    error_rate: Scalar
    command: Scalar
    state: State


def start(
    loop: Loop,
    fixed: tuple[Parameters, ...],
    zero: Scalar,
    started: tuple[State, ...],
    gains: Gains | None = None,
) -> LoopState:
    """Return the state before the first sample, of a machine at ``started`` and its controller.

    Earlier readings of the encoders are those at ``started``. With ``gains`` the initial memory of
    the controller may depend on them.
    """
    blank = loop.machine.initial_state(zero)
    states = tuple(
        blank_state._replace(**{name: zero + x for name, x in state._asdict().items()})
        for blank_state, state in zip(blank, started, strict=True)
    )
    law = loop.controller
    memory = law.initial_memory(zero) if gains is None else begun(law, LANES, zero, gains)
    angles, rates = [], []
    each = zip(loop.machine.drives, fixed, states, loop.sensors, strict=True)
    for drive, coefficients, state, sensors in each:
        observed = sensors is not None and sensors.velocity == "observer"
        count, step = (sensors.samples, sensors.encoder_resolution) if sensors else (1, None)
        seen = drive.measured(coefficients, state)
        first = {angle: in_steps(getattr(seen, angle), step) for angle in drive.encoders}
        angles.append({angle: (value,) * count for angle, value in first.items()})
        rated = drive.encoders.items() if observed else ()
        rates.append({angle: getattr(state, velocity) for angle, velocity in rated})
    return LoopState(states, tuple(angles), tuple(rates), memory, (zero,) * len(states))


def first_monitor(
    loop: Loop, zero: Scalar, machine: LoopState, copy: LoopState | None = None
) -> Monitor:
    """Return the monitor before the first sample; a ``copy`` begins at shifted positions."""
    pairs = zip(loop.machine.drives, machine.states, strict=True)
    means = tuple(getattr(state, drive.velocity) for drive, state in pairs)
    watch = Monitor(means, loop.judge.initial(zero))
    if copy is None:
        return watch
    places = (positions(loop, each.states) for each in (machine, copy))
    return watch._replace(off=tuple(b - a for a, b in zip(*places, strict=True)))


def positions(loop: Loop, states: tuple[State, ...]) -> list[Scalar]:
    """Return the position of each axis."""
    pairs = zip(loop.machine.drives, states, strict=True)
    return [getattr(state, drive.position) for drive, state in pairs]


def next_state(
    loop: Loop,
    nominal: tuple[Parameters, ...],
    fixed: tuple[Parameters, ...],
    sample_time: Scalar,
    gains: Gains,
    before: LoopState,
    row: Samples,
) -> LoopState:
    """Return the state after one control sample: measure, control, convert the commands, move.

    ``nominal`` are the parameters that the control assumes, ``fixed`` the ``coefficients`` of the
    true parameters, ``row`` one column of the samples, with loads and noise as tuples of scalars.
    ``sample_time`` [s] is not taken from ``row``.
    """
    machine, axes = loop.machine, range(len(loop.machine.drives))
    each = (_sensed(loop, k, fixed[k], before, row.axes[k], sample_time) for k in axes)
    seen, signals, angles, rates = zip(*each, strict=True)
    view = View(signals, _path_view(loop, seen, row), nominal)
    raw_commands, memory = loop.controller.step(LANES, gains, before.memory, view)
    held_commands = tuple(
        converted(raw_commands[k], loop.limits[k], loop.resolutions[k]) for k in axes
    )
    commands = tuple(machine.drives[k].accepted(fixed[k], held_commands[k]) for k in axes)
    loads = tuple(axis.loads for axis in row.axes)
    states = machine.moved(fixed, before.states, commands, loads, sample_time, loop.substeps)
    return _in_precision(before, LoopState(states, angles, rates, memory, commands))


def _in_precision(before: LoopState, after: LoopState) -> LoopState:
    """Return ``after`` in the precision of ``before``: a user's law may return float64 arrays."""

    def rounded(old: Any, new: Any) -> Any:
        kinds = getattr(old, "dtype", None), getattr(new, "dtype", None)
        real = all(kind is not None and jnp.issubdtype(kind, jnp.floating) for kind in kinds)
        return new.astype(kinds[0]) if real and kinds[0] != kinds[1] else new

    try:
        cast_state: LoopState = jax.tree.map(rounded, before, after)
    except ValueError:  # the memory has another structure, which is reported later
        return after
    return cast_state


def monitored(
    loop: Loop,
    fixed: tuple[Parameters, ...],
    sample_time: Scalar,
    before: LoopState,
    commands: tuple[Scalar, ...],
    watch: Monitor,
    row: Samples,
    copy: tuple[State, ...] = (),
) -> tuple[Monitor, tuple[Recorded, ...]]:
    """Return the monitor after a sample that began in ``before``, and the record of each axis.

    ``commands`` are those of the sample; ``copy`` has the states of the copy, if there is one.
    """
    moments, outputs = [], []
    happening = row._replace(sample_time=sample_time)
    for k, command in enumerate(commands):
        before_it, mean = before.commands[k], watch.means[k]
        moment = _moment(loop, k, fixed[k], before.states[k], command, before_it, mean, happening)
        outputs.append(Recorded(moment.error, moment.error_rate, command, before.states[k]))
        if copy:
            moment = _apart(loop, k, moment, before.states[k], copy[k], watch.off[k])
        moments.append(moment)
    sums = loop.judge.update(watch.sums, tuple(moments), row.path)
    means = tuple(moment.velocity for moment in moments)
    return Monitor(means, sums, watch.off), tuple(outputs)


def _sensed(
    loop: Loop, k: int, fixed: Parameters, before: LoopState, row: AxisSamples, sample_time: Scalar
) -> tuple[State, dict[str, Scalar], Angles, Rates]:
    """Return measured state and signals of axis ``k``; angles and rates for the next sample."""
    drive, sensors = loop.machine.drives[k], loop.sensors[k]
    if loop.around:
        row = row._replace(noise=tuple(fixed.around.noise * x for x in row.noise))
    known = before.angles[k], before.rates[k]
    measurement = measured(sensors, drive, fixed, before.states[k], known, row, sample_time)
    seen, angles, rates = measurement
    return seen, read(sensors, drive, axis_signals(drive, fixed, seen, row), row), angles, rates


def _moment(
    loop: Loop,
    k: int,
    fixed: Parameters,
    state: State,
    command: Scalar,
    previous: Scalar,
    before: Scalar,
    row: Samples,
) -> Moment:
    """Return the inputs of objectives from axis ``k``; ``before`` is its mean velocity so far."""
    drive, happens = loop.machine.drives[k], row.axes[k]
    position, limit = getattr(state, drive.position), loop.limits[k]
    rate = happens.reference_rate
    velocity = getattr(state, drive.velocity)
    taken = row.sample_time / (row.sample_time + STANDING)
    limit = jnp.inf if limit is None else limit
    low, high = drive.accepted(fixed, -limit), drive.accepted(fixed, limit)
    return Moment(
        error=folded(loop.sensors[k], happens.reference - position),
        error_rate=rate - velocity,
        deviation=-folded(loop.sensors[k], happens.target - position),
        command=command,
        reference_rate=rate,
        settled=row.settled,
        command_change=command - previous,
        limited=(command <= low) | (command >= high),
        sliding=happens.sliding,
        beyond=jnp.maximum((position - happens.end) * happens.heading, 0.0),
        late=row.late,
        time=row.time,
        sample_time=row.sample_time,
        velocity=before + taken * (velocity - before),
    )


def _apart(loop: Loop, k: int, moment: Moment, mine: State, theirs: State, off: Scalar) -> Moment:
    """Return the moment with distance and rate of the copy of axis ``k``, as shares of ``off``."""
    drive = loop.machine.drives[k]
    places = {drive.position: drive.velocity, **drive.encoders}
    apart, rate = 0.0, 0.0
    for share, (place, velocity) in enumerate(places.items(), 1):  # unequal: see ``unsettled``
        apart = apart + (getattr(theirs, place) - getattr(mine, place)) / (share * off)
        rate = rate + (getattr(theirs, velocity) - getattr(mine, velocity)) / (share * off)
    return moment._replace(apart=apart, apart_rate=rate)


def axis_signals(
    drive: Drive, fixed: Parameters, seen: State, row: AxisSamples
) -> dict[str, Scalar]:
    """Return the signals of an axis for the controller, from its state as measured (``seen``)."""
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
    """Return the path, with the contour error at the measured positions; None without a path."""
    path = row.path
    if path is None:
        return None
    each = zip(loop.machine.drives, seen, row.axes, strict=True)
    off = [getattr(state, drive.seen[0]) - axis.reference for drive, state, axis in each]
    contour, orientation, _ = off_path(path, off)
    turned = 0.0 if orientation is None else orientation
    tangent, curvature, speed, feed, bend, *_ = path
    return PathView(tangent, curvature, contour, turned, speed, feed, bend)
