"""What the closed loop of one machine does in a control sample, in scalars.

Sensors, controller, drives, objectives. ``population`` runs it over the samples, for many::

    carry = start(loop, zero)
    carry, recorded = sample(loop, told, fixed, sample_time, gains, carry, row)  # once a sample
    judged = loop.judge.judged(carry.sums, positions(loop, carry))
"""

from typing import Any, NamedTuple

import jax.numpy as jnp

from hfc_design.controllers.controller import Controller, PathView, View
from hfc_design.core.lanes import LANES
from hfc_design.files.scenario import Scenario
from hfc_design.motion.contour import local_error
from hfc_design.motion.samples import AxisSamples, PathFrame, Samples
from hfc_design.objectives.judge import Judge
from hfc_design.objectives.objective import Moment
from plants import Drive, Machine


class Sensors(NamedTuple):
    """What stands between the state of an axis and the controller."""

    encoder_resolution: float = 0.0  # in the units of the drive; 0 means ideal
    velocity_from_encoder: bool = False  # else an ideal tachometer


class Loop(NamedTuple):
    """The closed loop as code; everything else is data. One ``Loop`` compiles once a shape."""

    machine: Machine
    controller: Controller
    judge: Judge
    substeps: int = 1
    limits: tuple[float | None, ...] = ()  # of the drives' commands; (): none
    sensors: tuple[Sensors | None, ...] = ()  # of each axis, None where ideal; (): all are


def closed_loop(scenario: Scenario, controller: Controller) -> Loop:
    """The loop of ``scenario`` with ``controller`` in it."""
    machine = scenario.plant.machine
    own = [scenario.sensors.of(axis) for axis in machine.axes]
    sensors = tuple(
        None
        if wanted.encoder_resolution == wanted.noise == 0.0 and wanted.velocity == "tachometer"
        else Sensors(wanted.encoder_resolution, wanted.velocity == "encoder")
        for wanted in own
    )
    limits = tuple(scenario.target.limits.values())
    return Loop(
        machine,
        controller,
        scenario.judge(),
        scenario.simulation.substeps,
        limits if any(limits) else (),
        sensors if any(sensors) else (),
    )


class Carry(NamedTuple):
    """What the machine carries from sample to sample."""

    states: tuple[Any, ...]  # of each drive
    angles: tuple[dict[str, Any], ...]  # what its encoders read at the previous sample
    memory: Any  # of the controller
    sums: Any  # of the objectives


class Recorded(NamedTuple):
    """One axis at the start of a sample; of whole motions leaves are (steps, individuals)."""

    error: Any
    error_rate: Any
    command: Any
    state: Any


def start(loop: Loop, zero: Any) -> Carry:
    """A machine before the first sample: everything is ``zero``."""
    return Carry(
        loop.machine.initial_state(zero),
        tuple(dict.fromkeys(drive.encoders, zero) for drive in loop.machine.drives),
        loop.controller.initial_memory(zero),
        loop.judge.initial(zero),
    )


def positions(loop: Loop, carry: Carry) -> list[Any]:
    """Where each axis is."""
    pairs = zip(loop.machine.drives, carry.states, strict=True)
    return [getattr(state, drive.position) for drive, state in pairs]


def sample(
    loop: Loop, told: Any, fixed: Any, sample_time: Any, gains: Any, carry: Carry, row: Samples
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
    for drive, state, command, happens in zip(
        machine.drives, carry.states, commands, row.axes, strict=True
    ):
        position = getattr(state, drive.position)
        error = happens.reference - position
        error_rate = happens.reference_rate - getattr(state, drive.velocity)
        deviation = position - happens.target
        moments.append(
            Moment(error, error_rate, deviation, command, happens.reference_rate, row.settled)
        )
        outputs.append(Recorded(error, error_rate, command, state))
    sums = loop.judge.update(carry.sums, tuple(moments), row.path)
    return Carry(states, angles, memory, sums), tuple(outputs)


def axis_signals(drive: Drive, fixed: Any, seen: Any, row: AxisSamples) -> dict[str, Any]:
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


def _path_view(loop: Loop, seen: tuple[Any, ...], row: Samples) -> PathView | None:
    """The path and the contour error as the control can know it: by what it measures."""
    path: PathFrame | None = row.path
    if path is None:
        return None
    x, y = (
        getattr(state, drive.seen[0]) - axis.reference
        for drive, state, axis in zip(loop.machine.drives, seen, row.axes, strict=True)
    )
    error = local_error(x, y, path.tangent_x, path.tangent_y, path.curvature)
    return PathView(path.tangent_x, path.tangent_y, path.curvature, error)


def _accepted(loop: Loop, k: int, fixed: Any, command: Any) -> Any:
    """The command that reaches drive ``k``."""
    limit = loop.limits[k] if loop.limits else None
    if limit is not None:
        command = jnp.clip(command, -limit, limit)
    return loop.machine.drives[k].accepted(fixed, command)


def _measured(
    loop: Loop, k: int, fixed: Any, carry: Carry, row: AxisSamples, sample_time: Any
) -> tuple[Any, dict[str, Any]]:
    """The state of axis ``k`` as the controller sees it, and the angles its encoders read."""
    drive, previous = loop.machine.drives[k], carry.angles[k]
    state = drive.measured(fixed, carry.states[k])
    sensors = loop.sensors[k] if loop.sensors else None
    if sensors is None:
        return state, previous
    angles = {}
    for (angle, _), disturbance in zip(drive.encoders.items(), row.noise, strict=True):
        value = getattr(state, angle) + disturbance
        if sensors.encoder_resolution:
            step = sensors.encoder_resolution
            value = step * jnp.floor(value / step + 0.5)
        angles[angle] = value
    seen = dict(angles)
    if sensors.velocity_from_encoder:
        for angle, velocity in drive.encoders.items():
            seen[velocity] = (angles[angle] - previous[angle]) / sample_time
    return state._replace(**seen), angles
