"""A drive linearised while it slides: what feed-forward and linear design know of it.

At rest friction is no slope: the bristles of LuGre are a spring there, a dry contact holds still.
At a creep its slope is negative where it falls towards the Coulomb level (Stribeck). So the drive
is linearised at the speed from which on the part of the command that grows with the speed is the
larger one: friction slides there, as it does at every higher speed. ``Drive.step`` itself is
differentiated, in float64; the steps of converters and encoders are no part of it, because a
rounding has the slope 0 everywhere and 1 in the mean.
"""

from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from hfc_design.core import devices
from hfc_design.core.numbers import Floats, Parameters
from hfc_design.core.records import UserError
from plants import Drive

#: Speeds that are tried [of the position, per s], the highest first.
SPEEDS = 10.0 ** np.arange(6.0, -6.25, -0.25)
#: Integration steps in a control sample, at first and at most.
SUBSTEPS, MOST_SUBSTEPS = 16, 1024
#: Newton's steps towards a steady motion, and the change [1] at which it has come.
TRIES, SETTLED = 20, 1e-9
#: Singular values below this share of the largest count as 0.
RANK = 1e-9


class Steady(NamedTuple):
    """What a part of the motion asks for, once everything else has settled."""

    command: float
    state: Floats  # (states,)


class Nominal(NamedTuple):
    """A sliding drive near a speed: ``x(k+1) = a x + b u``, held for a control sample.

    The rows of ``outputs`` turn a state into signals; "error" and "error_rate" are those of a
    reference that stands still.
    """

    speed: float  # [of the position, per s]
    a: Floats  # (states, states)
    b: Floats  # (states,)
    outputs: dict[str, Floats]  # (states,) each
    velocity: Steady  # for a unit of it
    acceleration: Steady  # for a unit of it
    coulomb: Steady  # for the direction: what is there at speed 0, by the slope at ``speed``
    load: Steady  # for a unit of it


class _Step(NamedTuple):
    """One integration step from a state, and its derivatives."""

    after: Floats  # (states,)
    a: Floats  # (states, states)
    b: Floats  # (states,)
    load: Floats  # (states,)


@lru_cache(maxsize=64)
def nominal(
    drive: Drive, parameters: Parameters, sample_time: float, speed: float | None = None
) -> Nominal:
    """The drive with ``parameters`` near ``speed``, or near the one that is found.

    Raises:
        UserError: it has no steady motion, or cannot be moved from one.
    """
    devices.configure()
    with jax.enable_x64(True):
        stepped, outputs = _differentiated(drive, parameters)
        seen = -outputs["error"]
        fault = f"the drive {drive.name} cannot be linearised: "

        def sliding(at: float, dt: float) -> tuple[Floats, float, Floats] | None:
            return _sliding(stepped, _guess(drive, at), seen, at, dt)

        if speed is None:
            speed = _sliding_speed(sliding, stepped, seen, sample_time)
        substeps = SUBSTEPS
        while (
            drive.fastest(parameters, sample_time / substeps) < speed and substeps < MOST_SUBSTEPS
        ):
            substeps *= 2
        found = sliding(speed, sample_time / substeps) if speed else None
        if found is None:
            at = f"at {speed:g} {drive.units['error_rate']}" if speed else "at any speed"
            raise UserError(f"{fault}no steady motion was found {at}")
        state, command, along = found
        one = stepped(state, command, sample_time / substeps)
    a, b, load = _sampled(one, substeps)
    if fault_of := _uncontrollable(a, b, drive):
        raise UserError(fault + fault_of)
    velocity = _solved(a, b, sample_time * along, seen)
    rising = 0.5 * sample_time**2 * along + sample_time * velocity.state
    coulomb = Steady(command - speed * velocity.command, state - speed * velocity.state)
    return Nominal(
        speed,
        a,
        b,
        outputs,
        velocity,
        _solved(a, b, rising, seen),
        coulomb,
        _solved(a, b, -load, seen),
    )


Stepped = Callable[[Floats, float, float], _Step]


def _differentiated(drive: Drive, parameters: Parameters) -> tuple[Stepped, dict[str, Floats]]:
    """A step of the drive with its derivatives, and the row of every signal."""
    kind = type(drive.initial_state(0.0))
    fixed, size = drive.coefficients(parameters), len(kind._fields)

    def stepped(x: Floats, command: float, dt: float) -> _Step:
        after, slopes = _both(drive, parameters, x, command, dt)
        return _Step(*map(np.asarray, (after, *slopes)))

    position, rate = (np.eye(size)[kind._fields.index(name)] for name in drive.seen)
    rows = jax.jacfwd(lambda x: drive.signals(fixed, kind(*x)))(jnp.ones(size))
    told = {name: np.asarray(row, float) for name, row in rows.items()}
    return stepped, {"error": -position, "error_rate": -rate, **told}


@partial(jax.jit, static_argnums=0)
def _both(drive: Drive, parameters: Parameters, x: Any, command: Any, dt: Any) -> Any:
    """The state after a step, and its derivatives by state, command and load."""
    kind, fixed = type(drive.initial_state(0.0)), drive.coefficients(parameters)

    def step(x: Any, command: Any, load: Any) -> Any:
        moved = drive.step(fixed, kind(*x), command, (load, load, load), dt)
        return jnp.stack([jnp.asarray(part, float) for part in moved])

    about = (x, command, 0.0)
    return step(*about), jax.jacfwd(step, argnums=(0, 1, 2))(*about)


def _guess(drive: Drive, speed: float) -> Floats:
    """A state that moves with ``speed``, everything else at rest."""
    zero = drive.initial_state(0.0)
    rates = {drive.velocity, drive.seen[1], *drive.encoders.values()}
    return np.array([speed if name in rates else 0.0 for name in zero._fields])


def _sliding(
    stepped: Stepped, state: Floats, seen: Floats, speed: float, dt: float
) -> tuple[Floats, float, Floats] | None:
    """Steady motion with ``speed``: state at position 0, command, what a unit of way moves.

    By Newton's method; None where it does not settle.
    """
    command, unit = 0.0, np.eye(len(state))
    for _ in range(TRIES):
        one = stepped(state, command, dt)
        if not all(np.isfinite(part).all() for part in one):
            return None
        along = _along(one.a, seen)
        if along is None:
            return None
        off = one.after - state - speed * dt * along
        matrix = np.block([[one.a - unit, one.b[:, None]], [seen[None], np.zeros((1, 1))]])
        try:
            move = np.linalg.solve(matrix, np.append(-off, -seen @ state))
        except np.linalg.LinAlgError:
            return None
        state, command = state + move[:-1], command + float(move[-1])
        if np.abs(move).max() <= SETTLED * max(np.abs(state).max(), abs(command)):
            return state, command, along
    return None


def _along(a: Floats, seen: Floats) -> Floats | None:
    """The direction in which the whole drive can be shifted and nothing changes: a d = d."""
    _, sizes, rows = np.linalg.svd(a - np.eye(len(a)))
    free = rows[sizes <= RANK * sizes[0]]
    shift = free.T @ (free @ seen)
    moved = float(seen @ shift)
    return shift / moved if moved > RANK else None


def _sliding_speed(sliding: Any, stepped: Stepped, seen: Floats, sample_time: float) -> float:
    """The speed above which the command's share that grows with it is the larger one; 0: none.

    Without Coulomb friction that is the lowest speed, without viscous friction the highest.
    """
    dt = sample_time / SUBSTEPS
    slides: list[float] = []
    for speed in SPEEDS.tolist():
        if (found := sliding(speed, dt)) is None:
            continue
        state, command, along = found
        one = stepped(state, command, dt)
        slope = _solved(one.a, one.b, dt * along, seen).command
        viscous = abs(slope * speed)
        if abs(command - slope * speed) > viscous and slides:
            break
        slides.append(speed)
    return slides[-1] if slides else 0.0


def _solved(a: Floats, b: Floats, asked: Floats, seen: Floats) -> Steady:
    """State and command with ``(a - 1) x + b u = asked`` and the position 0."""
    matrix = np.block([[a - np.eye(len(a)), b[:, None]], [seen[None], np.zeros((1, 1))]])
    found = np.linalg.solve(matrix, np.append(asked, 0.0))
    return Steady(float(found[-1]), found[:-1])


def _sampled(one: _Step, substeps: int) -> tuple[Floats, Floats, Floats]:
    """State, command and load matrices of so many equal steps."""
    whole, held = np.eye(len(one.a)), np.zeros_like(one.a)
    for _ in range(substeps):
        held = held + whole
        whole = whole @ one.a
    return whole, held @ one.b, held @ one.load


def _uncontrollable(a: Floats, b: Floats, drive: Drive) -> str | None:
    """What the command cannot move, in words (Hautus' test of the modes that do not decay)."""
    scale = np.abs(b).max()
    if scale == 0.0:
        return "the command moves nothing"
    for pole in np.linalg.eigvals(a):
        if abs(pole) < 1.0 - 1e-9:
            continue
        sizes = np.linalg.svd(np.column_stack([a - pole * np.eye(len(a)), b / scale]))[1]
        if sizes[-1] <= RANK * sizes[0]:
            return "a part of it that does not settle by itself is not moved by the command"
    return None
