"""Replay of a log: simulation of a plant under the recorded command, near the recorded motion.

In open loop all errors of the model accumulate, and after some seconds the simulated axis is far
from the recorded one. Therefore the replay is an observer: in each sample it corrects the simulated
positions and velocities by a share of the deviation from the recorded position, as for a rigid
body. The residual shows what the model lacks at frequencies above the bandwidth of the observer.
With a fast observer it is the residual of least squares on the inverse dynamics, with a filter of
the same bandwidth (Gautier, Janot and Vandanjon, IEEE Trans. Control Systems Technology 21, 2013).

The closed loop in which a log was recorded is replayed under the recorded reference and load.
"""

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np

from hfc_design.core.numbers import SAME, Floats, Gains, Parameters, Scalar, State
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import controller_of
from hfc_design.files.scenario import Scenario
from hfc_design.identify.parameters import FreeParameters
from hfc_design.identify.recording import Recording
from hfc_design.logs.columns import rates_of
from hfc_design.motion.samples import AxisSamples, Samples
from hfc_design.simulation.closed_loop import LoopState, closed_loop, next_state, start
from hfc_design.simulation.frequency import Excited
from plants import Drive

#: Shortest lag [samples]; shorter ones count as 0.
SHORTEST = 1e-3
#: Damping ratio of the observer.
DAMPED = 0.7
#: Periods of the observer's bandwidth after which the residual counts, for an axis that starts at
#: rest (only noise must decay) or in motion (exp(-2 pi 0.7 x 3) = 2e-6 of the error is left).
RESTED, FORGOTTEN = 1.0, 3.0
#: Function (parameters of one machine, delay of its command [samples], part of the delay that is a
#: lag [samples], constant load) -> residual (steps, outputs) of the recorded outputs. As a pytree
#: of JAX it is data: the recording in it is an input of compiled programs.
Residual: TypeAlias = Callable[..., Scalar]
#: For each angle of a drive: name, (name of its rate, its travel per unit of travel of the axis).
Body: TypeAlias = tuple[tuple[str, tuple[str, float]], ...]


class Rows(NamedTuple):
    """Recorded signals, arrays (steps, ...); inside the loop the values of one sample."""

    command: Scalar
    place: Scalar
    loads: Scalar  # 2 substeps + 1 in each sample, see ``load_between``
    outputs: Scalar
    usable: Scalar


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Replay:
    """A ``Residual`` under the recorded command; logs of one length share one compiled program."""

    drive: Drive = field(metadata={"static": True})
    body: Body = field(metadata={"static": True})
    names: tuple[str, ...] = field(metadata={"static": True})  # of the outputs
    substeps: int = field(metadata={"static": True})
    rows: Rows  # the recording
    begun: tuple[Scalar, Scalar]  # position and velocity of the axis before the first sample
    sample_time: Scalar  # [s]
    gains: tuple[Scalar, Scalar]  # of the observer, for the position [1], the velocity [1/s]
    unknown: Scalar  # (outputs,) see ``centred``

    def __call__(
        self, parameters: Parameters, late: Scalar, lag: Scalar = 0.0, load: Scalar = 0.0
    ) -> Scalar:
        """Return outputs (steps, outputs), recorded less simulated; 0 where they do not count."""
        drive, step = self.drive, self.sample_time / self.substeps
        fixed = drive.coefficients(parameters)

        time = jnp.maximum(lag, SHORTEST)
        left = jnp.where(lag > SHORTEST, jnp.exp(-1.0 / time), 0.0)
        share = jnp.where(lag > SHORTEST, time * (1.0 - left), 0.0)  # mean of it in a sample

        def sample(before: tuple[State, Scalar], row: Rows) -> tuple[tuple[State, Scalar], Scalar]:
            state, current = before
            missing = row.outputs - read(drive, fixed, state, self.names)
            behind = row.place - getattr(state, drive.seen[0])
            state = shifted(self.body, state, self.gains[0] * behind, self.gains[1] * behind)
            off = current - row.command
            command = drive.accepted(fixed, row.command + share * off)
            for k in range(self.substeps):
                loads = tuple(row.loads[2 * k + x] + load for x in range(3))
                state = drive.step(fixed, state, command, loads, step)
            return (state, row.command + left * off), missing * row.usable

        rows = self.rows._replace(command=delayed(self.rows.command, late - lag))
        first = rows.command[0]
        begun = shifted(self.body, drive.initial_state(0.0 * first), *self.begun), first
        return centred(jax.lax.scan(sample, begun, rows)[1], rows.usable, self.unknown)


def replay(free: FreeParameters, log: Recording, bandwidth: float, substeps: int) -> Replay:
    """Return the residual of a machine under the recorded command.

    Args:
        free: parameters of the replayed drive; ratios of gears are taken from their start.
        log: recording with commands, loads and positions.
        bandwidth: bandwidth of the observer [Hz]; 0: open loop.
        substeps: integration steps in a sample.
    """
    assert log.command is not None
    drive, every = free.drive, log.sample_time
    body, angular = rigid_body(drive, free.start), 2.0 * np.pi * bandwidth
    # An observer starts in a state that may be wrong; its residual counts when this is forgotten.
    periods = bandwidth * every * np.arange(len(log.usable)) * (1.0 + SAME)
    waits = FORGOTTEN if log.rate else RESTED
    counted = np.where(periods < waits, 0.0, log.usable) if bandwidth else log.usable
    rows = Rows(log.command, log.place, load_between(log.load, substeps), stacked(log), counted)
    return Replay(
        drive,
        body,
        tuple(log.outputs),
        substeps,
        rows,
        begun=(float(log.place[0]), log.rate),
        sample_time=every,
        gains=(every * 2.0 * DAMPED * angular, every * angular**2),
        unknown=zeros(body, log, [drive.seen[0]] if bandwidth else []),
    )


def stacked(log: Recording) -> Floats:
    """Return the measured outputs (steps, outputs)."""
    return np.stack([*log.outputs.values()], axis=-1)


def zeros(body: Body, log: Recording, known: Collection[str]) -> Floats:
    """Return (outputs,) 1 for an encoder with an unknown zero, which is not in ``known``, else 0.

    In open loop the position that is fed back has an unknown zero too: its first sample has noise.
    """
    return np.array([float(name in dict(body) and name not in known) for name in log.outputs])


def centred(off: Scalar, usable: Scalar, unknown: Floats) -> Scalar:
    """Return a residual (steps, outputs) less the mean of each output whose zero is ``unknown``."""
    return off - unknown * usable[:, None] * jnp.sum(off, axis=0) / jnp.sum(usable)


def load_between(load: Floats, substeps: int) -> Floats:
    """Return a load (steps, 2 substeps + 1) from each sample to the next, for the integrator.

    Linear interpolation would reduce an oscillation of w rad/s by the share (w T)^2 / 12, where T
    is the sample time. Therefore the middle of a segment deviates from the mean of its ends by an
    eighth of the second difference.
    """
    rise = np.diff(load, append=load[-1])
    turns = np.diff(rise, prepend=rise[0])  # at each sample
    bend = 0.5 * (turns + np.append(turns[1:], 0.0))
    share = np.arange(2 * substeps + 1) / (2 * substeps)
    return load[:, None] + np.outer(rise, share) - np.outer(bend, 0.5 * share * (1.0 - share))


def delayed(command: Scalar, late: Scalar) -> Scalar:
    """Return the mean (steps,) in each sample of a command that acts ``late`` samples later."""
    samples = jnp.arange(len(command), dtype=float)
    return jnp.interp(samples - late, samples, command)


def read(drive: Drive, fixed: Parameters, state: State, outputs: Iterable[str]) -> Scalar:
    """Return the named ``outputs`` (outputs,) of a state, without the steps of encoders."""
    shown = state._asdict() | drive.signals(fixed, state)
    return jnp.stack([shown[name] for name in outputs])


def shifted(body: Body, state: State, place: Scalar, rate: Scalar) -> State:
    """Return the state with the axis moved by ``place``, and its velocity raised by ``rate``."""
    changes = {name: getattr(state, name) + share * place for name, (_, share) in body}
    changes |= {name: getattr(state, name) + share * rate for _, (name, share) in body}
    return state._replace(**changes)


@cache  # so that a replay in compiled code finds the result
def rigid_body(drive: Drive, parameters: Parameters) -> Body:
    """Return the travel of each angle per unit of travel of the axis, without deformation.

    Such a motion causes no forces. Gears have the ratios in ``parameters``, which are floats.
    """
    pairs = rates_of(drive)
    names = list(pairs)
    fixed = drive.coefficients(parameters)

    def after(places: Scalar) -> Scalar:
        zero = drive.initial_state(0.0 * places[0])
        state = zero._replace(**dict(zip(names, places, strict=True)))
        stepped = drive.step(fixed, state, 0.0, (0.0, 0.0, 0.0), 1e-3)
        return jnp.stack([getattr(stepped, name) for name in (*names, *pairs.values())])

    with jax.enable_x64(True), jax.ensure_compile_time_eval():
        change = np.asarray(jax.jacfwd(after)(jnp.zeros(len(names))))
    change = change - np.eye(*change.shape)
    _, sizes, directions = np.linalg.svd(change)
    still = directions[sizes <= 1e-9 * max(sizes.max(), 1.0)]
    moves = still.T @ (still @ np.ones(len(names))) if len(still) else np.ones(len(names))
    first = moves[names.index(drive.seen[0])]
    shares = moves / first if abs(first) > 1e-6 else np.ones(len(names))
    return tuple((name, (pairs[name], float(s))) for name, s in zip(names, shares, strict=True))


def closed_loop_residual(scenario: Scenario, design: Design, log: Recording) -> Residual:
    """Return the residual of the closed loop under the recorded reference and load.

    Sensors, limits and substeps are those of ``scenario``, except that encoders have no steps.
    """
    controller, wide = controller_of(design, scenario)
    smooth = closed_loop(scenario, controller).smooth._replace(
        controller=Excited(controller, False)
    )
    gains: Gains = jax.tree.map(lambda leaf: leaf[..., 0], wide)
    drive, every, nominal = smooth.machine.drives[0], log.sample_time, scenario.plant.values()
    body = rigid_body(drive, nominal[0])
    readings = scenario.sensors.of(scenario.plant.machine.axes[0]).readings
    samples = _samples(log, smooth.substeps, len(drive.encoders) + len(readings))
    outputs, unknown = stacked(log), zeros(body, log, [drive.seen[0]])

    def off(parameters: Parameters, late: Scalar, lag: Scalar = 0.0, load: Scalar = 0.0) -> Scalar:
        fixed = smooth.coefficients((parameters,))
        zero = 0.0 * late
        put = shifted(body, drive.initial_state(zero), log.place[0], log.rate)

        def sample(
            before: LoopState, row: tuple[AxisSamples, Scalar, Scalar, Scalar]
        ) -> tuple[LoopState, Scalar]:
            happens, shown, counts, added = row
            happens = happens._replace(loads=tuple(x + load for x in happens.loads))
            missing = shown - read(drive, fixed[0], before.states[0], log.outputs)
            sampled = Samples((happens,), None, 0.0, every, 0.0, 0.0, (), ())
            after = next_state(smooth, nominal, fixed, every, (gains, (added,)), before, sampled)
            return after, missing * counts

        rows = samples, outputs, log.usable, log.added
        begun = start(smooth, fixed, zero, (put,), (gains, (zero,)))
        missing = jax.lax.scan(sample, begun, rows)[1]
        return centred(missing, log.usable, unknown)

    return jax.tree_util.Partial(off)


def _samples(log: Recording, substeps: int, noises: int) -> AxisSamples:
    """Return the recorded inputs of the axis, arrays (steps,); ``noises`` counts noises, all 0."""
    assert log.reference is not None
    reference, every = log.reference, log.sample_time
    rate = np.gradient(reference, every)  # at the sample, not half a sample later
    faster = np.diff(reference, 2, prepend=reference[0], append=reference[-1]) / every**2
    loads, noise = load_between(log.load, substeps).T, np.zeros((noises, len(reference)))
    return AxisSamples(reference, rate, tuple(loads), tuple(noise), reference, faster)
