"""Simulation of a plant under the recorded command, held near the recorded motion.

In open loop all errors of the model accumulate, and after some seconds the simulated axis is far
off. Therefore the replay is an observer: in each sample its positions and velocities are corrected
by a share of the deviation from the recorded position, as for a rigid body. The residual shows what
the model lacks, at frequencies above the observer's; with a fast observer it is the residual of
least squares on the inverse dynamics, with a filter of the same bandwidth (Gautier, Janot and
Vandanjon, IEEE Trans. Control Systems Technology 21, 2013). Without an observer it is the plain
open loop.

The closed loop that recorded a log is replayed under the recorded reference and load.
"""

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np

from hfc_design.controllers.controller import Stepped, View
from hfc_design.core.numbers import SAME, Floats, Gains, Memory, Parameters, Scalar, State, Xp
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import controller_of
from hfc_design.files.scenario import Scenario
from hfc_design.identify.parameters import FreeParameters
from hfc_design.identify.recording import Recording
from hfc_design.logs.columns import rates_of
from hfc_design.motion.samples import AxisSamples, Samples
from hfc_design.simulation.closed_loop import LoopState, closed_loop, next_state, start
from hfc_design.simulation.repeats import ScaledCommand
from plants import Drive

#: Shortest lag [samples]; shorter ones count as 0.
SHORTEST = 1e-3
#: Damping ratio of the observer.
DAMPED = 0.7
#: Periods of its bandwidth after which its residual counts: if the axis began at rest only noise
#: has to decay, otherwise exp(-2 pi 0.7 x 3) = 2e-6 of the initial error is left.
RESTED, FORGOTTEN = 1.0, 3.0
#: Parameters of one machine, delay of its command in samples, part of the delay that is a lag,
#: and a constant load -> residual of each recorded output (steps, outputs).
#: JAX takes it as an argument: the recording is data.
Residual: TypeAlias = Callable[..., Scalar]
#: Rate of each angle of a drive, and its travel for a travel of the axis of 1.
Body: TypeAlias = tuple[tuple[str, tuple[str, float]], ...]


class Rows(NamedTuple):
    """A recording, (steps, ...) each; inside the loop the values of one sample."""

    command: Scalar
    place: Scalar
    loads: Scalar  # (2 substeps + 1,) in each sample, see ``load_between``
    outputs: Scalar
    usable: Scalar


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Replay:
    """A ``Residual``; recordings of a length share one program, for any observer."""

    drive: Drive = field(metadata={"static": True})
    body: Body = field(metadata={"static": True})
    names: tuple[str, ...] = field(metadata={"static": True})  # of the outputs
    substeps: int = field(metadata={"static": True})
    rows: Rows  # leaves (steps,), outputs (steps, outputs)
    begun: tuple[Scalar, Scalar]  # place and rate of the axis before the first sample
    sample_time: Scalar  # [s]
    gains: tuple[Scalar, Scalar]  # of the observer, for the place and for the rate [1/s]
    unknown: Scalar  # (outputs,) see ``centred``

    def __call__(
        self, parameters: Parameters, late: Scalar, lag: Scalar = 0.0, load: Scalar = 0.0
    ) -> Scalar:
        """(steps, outputs) recorded less simulated, 0 where it does not count."""
        drive, step = self.drive, self.sample_time / self.substeps
        fixed = drive.coefficients(parameters)

        time = jnp.maximum(lag, SHORTEST)
        left = jnp.where(lag > SHORTEST, jnp.exp(-1.0 / time), 0.0)
        share = jnp.where(lag > SHORTEST, time * (1.0 - left), 0.0)  # of a sample, in the mean

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
    """The residual of a machine against the recording, where it counts.

    Args:
        free: parameters of the replayed drive; gears are known from their start.
        log: recording with commands, loads and positions.
        bandwidth: bandwidth of the observer [Hz]; 0: open loop.
        substeps: integration steps in a sample.
    """
    assert log.command is not None
    drive, every = free.drive, log.sample_time
    body, angular = rigid_body(drive, free.start), 2.0 * np.pi * bandwidth
    # An observer finds out how the log began; when it has forgotten what it took it for, it counts.
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
    """(steps, outputs) measured outputs."""
    return np.stack([*log.outputs.values()], axis=-1)


def zeros(body: Body, log: Recording, known: Collection[str]) -> Floats:
    """(outputs,) 1 for an encoder with an unknown zero, otherwise 0.

    In open loop that includes the axis' own encoder: its first sample has noise like every other.
    """
    return np.array([float(name in dict(body) and name not in known) for name in log.outputs])


def centred(off: Scalar, usable: Scalar, unknown: Floats) -> Scalar:
    """(steps, outputs) residual without the mean of those outputs whose zero is ``unknown``."""
    return off - unknown * usable[:, None] * jnp.sum(off, axis=0) / jnp.sum(usable)


def load_between(load: Floats, substeps: int) -> Floats:
    """(steps, 2 substeps + 1) a load until the next sample, at the times that an integrator needs.

    With linear interpolation an oscillation would be too small: by (w T)^2 / 12 of itself at
    w rad/s. The middle of a segment is off the mean of its ends by an eighth of the second
    difference.
    """
    rise = np.diff(load, append=load[-1])
    turns = np.diff(rise, prepend=rise[0])  # at each sample
    bend = 0.5 * (turns + np.append(turns[1:], 0.0))
    share = np.arange(2 * substeps + 1) / (2 * substeps)
    return load[:, None] + np.outer(rise, share) - np.outer(bend, 0.5 * share * (1.0 - share))


def delayed(command: Scalar, late: Scalar) -> Scalar:
    """(steps,) mean in each sample of commands that act ``late`` samples later."""
    samples = jnp.arange(len(command), dtype=float)
    return jnp.interp(samples - late, samples, command)


def read(drive: Drive, fixed: Parameters, state: State, outputs: Iterable[str]) -> Scalar:
    """(outputs,) outputs of a machine, without the steps of its encoders."""
    shown = state._asdict() | drive.signals(fixed, state)
    return jnp.stack([shown[name] for name in outputs])


def shifted(body: Body, state: State, place: Scalar, rate: Scalar) -> State:
    """The state with the position and velocity of the whole axis increased."""
    changes = {name: getattr(state, name) + share * place for name, (_, share) in body}
    changes |= {name: getattr(state, name) + share * rate for _, (name, share) in body}
    return state._replace(**changes)


@cache  # a replay inside of compiled code finds it here
def rigid_body(drive: Drive, parameters: Parameters) -> Body:
    """Travel of each angle per unit of travel of the axis, without deformation.

    Such a shift causes no forces. It includes gears, with the ratios in ``parameters`` (floats).
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


class Pushed(ScaledCommand):
    """A controller with a signal added to its command; its gains are that signal and its own."""

    def step(self, xp: Xp, gains: Gains, memory: Memory, view: View) -> Stepped:
        """The command of the axis, and the memory for the next step."""
        added, inner = gains
        commands, memory = self.inner.step(xp, inner, memory, view)
        return tuple(command + added for command in commands), memory


def closed_loop_residual(scenario: Scenario, design: Design, log: Recording) -> Residual:
    """The residual of the closed loop of a machine against the recording, where it counts.

    Sensors, limits and substeps are those of ``scenario``, without the steps of encoders.
    """
    controller, wide = controller_of(design, scenario)
    smooth = closed_loop(scenario, controller).smooth._replace(controller=Pushed(controller))
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
            after = next_state(smooth, nominal, fixed, every, (added, gains), before, sampled)
            return after, missing * counts

        rows = samples, outputs, log.usable, log.added
        missing = jax.lax.scan(sample, start(smooth, fixed, zero, (put,)), rows)[1]
        return centred(missing, log.usable, unknown)

    return jax.tree_util.Partial(off)


def _samples(log: Recording, substeps: int, noises: int) -> AxisSamples:
    """Inputs of the axis in each sample, a leaf (steps,) each."""
    assert log.reference is not None
    reference, every, still = log.reference, log.sample_time, np.zeros(len(log.load))
    faster = np.diff(reference, 2, prepend=reference[0], append=reference[-1])
    return AxisSamples(
        reference=reference,
        reference_rate=np.gradient(reference, every),  # where it is, not half a sample later
        loads=tuple(load_between(log.load, substeps).T),
        noise=(still,) * noises,
        target=reference,
        reference_acceleration=faster / every**2,
        sliding=still,
        end=reference,
        heading=still,
    )
