"""Steady motion of a drive: its step differentiated, Newton's method, where friction slides."""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from scipy.linalg import matrix_balance

from hfc_design.core.numbers import Floats, Parameters
from plants import Drive

#: Speeds that are tried [of the position, per s], the highest first.
SPEEDS = 10.0 ** np.arange(6.0, -6.25, -0.25)
#: Newton's steps towards a steady motion, and the change [1] at which it has come.
TRIES, SETTLED = 20, 1e-9
#: A motion is none that rounding leaves open by more than this [1].
OPEN = 1e-3
#: What a dozen roundings make of a number of size 1, at most.
ROUNDED = 1e-14
#: Singular values that count as 0 beside numbers of size 1.
RANK = 1e-9
#: The speed that is looked for is known to this factor.
CLOSE = 1.0 + 1e-9


class Step(NamedTuple):
    """One integration step from a state, and its derivatives."""

    after: Floats  # (states,)
    a: Floats  # (states, states)
    b: Floats  # (states,)
    load: Floats  # (states,)


class Motion(NamedTuple):
    """A steady motion: the same speed, command and everything else from step to step."""

    speed: float
    state: Floats  # (states,) at position 0
    command: float
    along: Floats  # (states,) what a unit of way moves


class Steady(NamedTuple):
    """What a part of a motion asks for, once everything else has settled."""

    command: float
    state: Floats  # (states,)


class Slides:
    """A drive whose steps are differentiated; call it where JAX has float64."""

    def __init__(self, drive: Drive, parameters: Parameters):
        kind = type(drive.initial_state(0.0))
        size, rows = len(kind._fields), reported(drive, parameters)
        #: (states,) the position that is fed back.
        self.seen, rate = (np.eye(size)[kind._fields.index(name)] for name in drive.seen)
        told = {name: np.asarray(row, float) for name, row in rows.items()}
        self.outputs = {"error": -self.seen, "error_rate": -rate, **told}
        rates = {drive.velocity, drive.seen[1], *drive.encoders.values()}
        self._moving = np.array([float(name in rates) for name in kind._fields])
        #: (states,) how far from its state a step may begin.
        self.reach = np.zeros(size)
        self._step = partial(differentiated, drive, parameters)

    def step(self, state: Floats, command: float, dt: float) -> Step:
        """From a state under a command, without a load."""
        after, slopes = self._step(state, command, dt)
        return Step(*map(np.asarray, (after, *slopes)))

    def motion(self, speed: float, dt: float, near: Motion | None = None) -> Motion | None:
        """The steady motion with a speed, in steps of ``dt`` [s]; None where none is found.

        Newton's method begins with no force anywhere and, where that leads nowhere, with what is in
        contact in the motion ``near`` it: within a backlash no command moves what is behind.
        """
        found = self._from(speed * self._moving, 0.0, speed, dt)
        if found is None and near is not None:
            state = near.state + (speed - near.speed) * self._moving
            found = self._from(state, near.command, speed, dt)
        return found

    def _from(self, state: Floats, command: float, speed: float, dt: float) -> Motion | None:
        unit, moved = np.eye(len(self.seen)), np.inf
        for _ in range(TRIES):
            one = self.step(state, command, dt)
            if not all(np.isfinite(part).all() for part in one):
                return None
            along = self._along(one.a)
            if along is None:
                return None
            off = one.after - state - speed * dt * along
            matrix = np.block([[one.a - unit, one.b[:, None]], [self.seen[None], np.zeros((1, 1))]])
            try:
                move = np.linalg.solve(matrix, np.append(-off, -self.seen @ state))
            except np.linalg.LinAlgError:
                return None
            state, command = state + move[:-1], command + float(move[-1])
            scale = max(np.abs(state).max(), abs(command))
            before, moved = moved, np.abs(move).max() / scale
            if moved <= SETTLED or moved >= before:
                left = self._left_open(one, np.linalg.inv(matrix), state, command)
                come = moved <= SETTLED or (np.abs(move) <= left).all()
                if come and left.max() <= OPEN * scale:
                    return Motion(speed, state, command, along)
        return None

    def _left_open(self, one: Step, inverse: Floats, state: Floats, command: float) -> Floats:
        """(states + 1,) how far the rounding of a step moves a state and a command at most.

        Newton's method comes no nearer, and moves on by so much for ever: a stiff drive, or one
        whose steps begin far away, by more than ``SETTLED``.
        """
        size = np.abs(state) + self.reach
        lost = np.abs(one.a) @ size + np.abs(one.b * command) + size
        return np.asarray(np.abs(inverse) @ np.append(ROUNDED * lost, 0.0))

    def _along(self, a: Floats) -> Floats | None:
        """The direction in which all of the drive can be shifted and nothing changes: a d = d."""
        a, units = balanced(a)
        _, sizes, rows = np.linalg.svd(a - np.eye(len(a)))
        free = rows[sizes <= RANK]
        shift = free.T @ (free @ self.seen)
        moved = float(self.seen @ shift)
        return units * shift / (moved * (units @ self.seen)) if moved > RANK else None

    def asks(self, a: Floats, b: Floats, change: Floats) -> Steady:
        """State at position 0 and command with ``(a - 1) x + b u = change``."""
        matrix = np.block([[a - np.eye(len(a)), b[:, None]], [self.seen[None], np.zeros((1, 1))]])
        found = np.linalg.solve(matrix, np.append(change, 0.0))
        return Steady(float(found[-1]), found[:-1])

    def slowest(self, dt: float) -> Motion | None:
        """That of the lowest speed from which on the command's growing part is larger.

        That is ``v du/dv`` beside ``u - v du/dv`` of the command u of steady motion with the speed
        v. Without Coulomb friction it is the lowest of all, without viscous friction the highest.
        """
        found, low = None, None
        for speed in SPEEDS.tolist():
            motion = self.motion(speed, dt, found)
            if motion is None:
                continue
            if found is not None and not self._grows(motion, dt):
                low = speed
                break
            found = motion
        while found is not None and low is not None and found.speed > CLOSE * low:
            speed = float(np.sqrt(low * found.speed))
            motion = self.motion(speed, dt, found)
            if motion is not None and self._grows(motion, dt):
                found = motion
            else:
                low = speed
        return found

    def _grows(self, motion: Motion, dt: float) -> bool:
        one = self.step(motion.state, motion.command, dt)
        growing = motion.speed * self.asks(one.a, one.b, dt * motion.along).command
        return bool(abs(motion.command - growing) <= abs(growing))


def balanced(a: Floats) -> tuple[Floats, Floats]:
    """A step's matrix with its states in units that make it even, and those units (states,).

    With the units of the drive, metres beside radians, or with one part of it far stiffer than the
    others, what is not 0 lies as deep below the largest singular value as what is only rounding.
    """
    with np.errstate(invalid="ignore"):  # of a matrix that is not finite
        even, (units, _) = matrix_balance(a, permute=False, separate=True)
    return np.asarray(even, float), np.asarray(units, float)


@partial(jax.jit, static_argnums=0)
def reported(drive: Drive, parameters: Parameters) -> dict[str, Any]:
    """(states,) what each signal of the drive takes of each state."""
    kind, fixed = type(drive.initial_state(0.0)), drive.coefficients(parameters)
    states = jnp.ones(len(kind._fields))
    rows: dict[str, Any] = jax.jacfwd(lambda x: drive.signals(fixed, kind(*x)))(states)
    return rows


@partial(jax.jit, static_argnums=0)
def differentiated(drive: Drive, parameters: Parameters, x: Any, command: Any, dt: Any) -> Any:
    """The state after a step, and its derivatives by state, command and load."""
    kind, fixed = type(drive.initial_state(0.0)), drive.coefficients(parameters)

    def step(x: Any, command: Any, load: Any) -> Any:
        moved = drive.step(fixed, kind(*x), command, (load, load, load), dt)
        return jnp.stack([jnp.asarray(part, float) for part in moved])

    about = (x, command, 0.0)
    return step(*about), jax.jacfwd(step, argnums=(0, 1, 2))(*about)
