"""Effects around a drive that are not in its model: delay, lag, load, a mode, a gap, jitter.

``surrounded`` makes another drive of any drive, including users' own, so that no drive has to
model these effects itself.
"""

from collections import namedtuple
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple, cast

import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike

from plants.drive import Coefficients, Drive, Loads, Parameters, Scalar, State
from plants.machine import Machine

#: Fields that are added to the state of a drive with such effects.
MORE = ("part", "lagged", "bent", "swing", "slack", "beat")
#: Jitter is computed from multiples of the golden ratio: evenly distributed in any stretch, and
#: reproducible.
GOLDEN = 0.6180339887498949


class Around(NamedTuple):
    """Size of each effect; numbers, or (machines,)."""

    delay_samples: Any = 0.0  # of the command; fractions too
    lag_s: Any = 0.0  # time constant of the current loop, after the delay [s]
    load: Any = 0.0  # constant, added to that of the scenario [load]
    noise: Any = 1.0  # factor on the noise of the readings
    backlash: Any = 0.0  # between the axis and the encoder that is fed back [error]
    jitter: Any = 0.0  # largest change of the time of a sample, as a share of it
    mode_hz: Any = 0.0  # of a mode in the force; 0: there is none [Hz]
    mode_damping: Any = 0.0  # ratio [1]
    #: Swinging mass as a share of the other mass (Franklin et al., Feedback Control, sec. 2.1, two
    #: masses pushed at the one that is measured); -1: the measured mass is the one that swings.
    mode_share: Any = 0.0


class Sampled(NamedTuple):
    """What a step of one length needs of ``Around``; numbers or (machines,)."""

    waits: tuple[Scalar, ...]  # 1 at the whole samples of the delay, else 0
    late: Scalar  # share of a sample of delay beyond these
    keep: Scalar  # share of a difference that the lag keeps after a step
    mean: Scalar  # mean of this share over a step
    turn: tuple[Scalar, Scalar, Scalar, Scalar]  # matrix of the mode, row by row
    share: Scalar
    load: Scalar
    noise: Scalar
    slack: Scalar  # half the backlash
    jitter: Scalar


class Standing(NamedTuple):
    """Parameters of a drive, or what a step needs of them, and the effects around the drive."""

    inner: Any
    around: Sampled


def sampled(around: Around, sample_time: float, substeps: int, waits: int) -> Sampled:
    """Return ``around`` for integration steps of ``sample_time / substeps`` [s].

    ``waits`` is the longest delay in samples, rounded up.
    """
    dt = sample_time / substeps
    delay, lag, hz = (np.asarray(x, float) for x in (around.delay_samples, around.lag_s, around[6]))
    whole = np.clip(np.ceil(delay) - 1.0, 0.0, None)
    with np.errstate(divide="ignore"):
        keep = np.where(lag > 0.0, np.exp(-dt / np.maximum(lag, 1e-300)), 0.0)
    rest = np.asarray(around.mode_share, float) * (hz > 0.0)
    turn = _turned(np.where(hz > 0.0, hz, 1.0 / dt), np.asarray(around.mode_damping, float), dt)
    given = (around.load, around.noise, 0.5 * np.asarray(around.backlash), around.jitter)
    parts = (delay - whole, keep, lag / dt * (1.0 - keep), turn, rest, *given)
    weights = tuple(np.where(whole == k, 1.0, 0.0) for k in range(waits))
    shape = np.broadcast_shapes(*(np.shape(x) for x in around))
    return Sampled(*_shaped((weights, *parts), shape))


def _turned(hz: ArrayLike, damping: ArrayLike, dt: float) -> tuple[ArrayLike, ...]:
    """Return the matrix for w^2 s - u and s' / dt over a step of ``s'' + 2 z w s' + w^2 s = u``."""
    w = 2.0 * np.pi * np.asarray(hz)
    decay, damped = np.asarray(damping) * w, w * np.sqrt(1.0 - np.asarray(damping) ** 2)
    e, c, s = np.exp(-decay * dt), np.cos(damped * dt), np.sin(damped * dt)
    ratio = decay / damped
    rows = (c + ratio * s, w**2 * dt / damped * s, -s / (damped * dt), c - ratio * s)
    return tuple(e * x for x in rows)


def _shaped(parts: Any, shape: tuple[int, ...]) -> Any:
    """Return each number as a float, or as (machines,)."""
    if isinstance(parts, tuple):
        return tuple(_shaped(part, shape) for part in parts)
    return np.broadcast_to(parts, shape).astype(float) if shape else float(parts)


def plain(parameters: Parameters) -> Parameters:
    """Return the parameters of the drive itself."""
    return parameters.inner if isinstance(parameters, Standing) else parameters


@cache  # always the same object for a machine: it is a key of compiled code
def surrounded(machine: Machine, waits: int, substeps: int) -> Machine:
    """Return the machine with the effects of ``Around``; its parameters are ``Standing``.

    ``waits`` is as in ``sampled``. With the plain parameters of a drive it has no such effects.
    """
    drives = tuple(_around(drive, waits, substeps) for drive in machine.drives)
    machine_forces, forces = machine.forces, None
    if machine_forces is not None:
        counts = [len(drive.initial_state(0.0)) for drive in machine.drives]
        kinds = [type(drive.initial_state(0.0)) for drive in machine.drives]

        def forces(fixed: Any, states: Any, commands: Any) -> Any:
            inner = (k(*x[:n]) for k, x, n in zip(kinds, states, counts, strict=True))
            return machine_forces(tuple(one.inner for one in fixed), tuple(inner), commands)

    return Machine(machine.name, machine.axes, drives, forces)


def commanded(state: State, command: Scalar) -> State:
    """Return the state in which all delayed and lagging commands are equal to ``command``."""
    if state._fields[-len(MORE) :] != MORE:
        return state
    names = [name for name in state._fields if name.startswith("sent_")]
    return state._replace(**dict.fromkeys([*names, "lagged", "bent"], command))


def fine(drive: Drive) -> Drive:
    """Return the drive without steps and limits of its converter and steps of its encoders."""
    place = drive.seen[0]

    def measured(fixed: Coefficients, state: State) -> State:
        if state._fields[-len(MORE) :] != MORE:
            return state
        return state._replace(**{place: getattr(state, place) + state.slack})

    return replace(drive, accepted=lambda fixed, command: command, measured=measured)


def _around(drive: Drive, waits: int, substeps: int) -> Drive:
    kind = type(drive.initial_state(0.0))
    count, seen = len(kind._fields), drive.seen[0]
    sent = [f"sent_{k + 1}" for k in range(waits)]
    more = [*sent, *MORE]
    state_of = cast(Any, namedtuple)("State", (*kind._fields, *more))
    nothing = sampled(Around(), 1.0, 1, waits)

    def inner(state: State) -> State:
        return kind(*state[:count])

    def coefficients(parameters: Parameters) -> Standing:
        standing = parameters if isinstance(parameters, Standing) else Standing(parameters, nothing)
        return Standing(drive.coefficients(standing.inner), standing.around)

    def measured(fixed: Coefficients, state: State) -> State:
        drive_state = inner(state)
        if len(state) > count:
            drive_state = drive_state._replace(**{seen: getattr(drive_state, seen) + state.slack})
        return drive.measured(fixed.inner, drive_state)

    def step(fixed: Standing, state: State, command: Scalar, loads: Loads, dt: Scalar) -> State:
        a, before = fixed.around, inner(state)
        given = (command, *(getattr(state, name) for name in sent))
        old = a.late if substeps == 1 else jnp.clip(a.late * substeps - state.part, 0.0, 1.0)
        acting = command
        if waits:
            pairs = zip(a.waits, pairwise(given), strict=True)
            acting = sum(w * ((1.0 - old) * new + old * late) for w, (new, late) in pairs)
        lagged = acting + a.keep * (state.lagged - acting)
        mean_command = acting + a.mean * (state.lagged - acting)
        off, (one, two, three, four) = state.bent - mean_command, a.turn
        bent, swing = mean_command + one * off + two * state.swing, three * off + four * state.swing
        pushed = mean_command + a.share * (swing - state.swing)
        beat = state.beat + GOLDEN
        beat = beat - jnp.floor(beat)
        time = dt * (1.0 + a.jitter * (2.0 * beat - 1.0))
        after = drive.step(fixed.inner, before, pushed, tuple(x + a.load for x in loads), time)
        slack = state.slack + getattr(before, seen) - getattr(after, seen)
        part = jnp.where(state.part + 1.5 > substeps, 0.0, state.part + 1.0)
        ends = part == 0.0
        delay_line = [jnp.where(ends, new, x) for new, x in pairwise(given)]
        slack = jnp.where(a.slack > 0.0, jnp.clip(slack, -a.slack, a.slack), 0.0)
        return state_of(*after, *delay_line, part, lagged, bent, swing, slack, beat)

    return replace(
        drive,
        initial_state=lambda zero: state_of(*drive.initial_state(zero), *(zero for _ in more)),
        coefficients=coefficients,
        step=step,
        signals=lambda fixed, state: drive.signals(fixed.inner, inner(state)),
        measured=measured,
        accepted=lambda fixed, command: drive.accepted(fixed.inner, command),
    )
