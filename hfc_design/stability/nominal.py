"""Linearisation of a sliding drive, for feed-forward and linear design.

At rest friction has no slope: the bristles of LuGre are a spring there, a dry contact holds still.
At very low speed its slope is negative where it falls towards the Coulomb level (Stribeck). The
drive is therefore linearised at the speed from which on the part of the command that grows with
the speed is the larger one: friction slides there, as it does at every higher speed.
``Drive.step`` itself is differentiated, in float64; the steps of converters and encoders are left
out, because a rounding has the slope 0 everywhere and 1 in the mean.

Cogging is left out as well. It keeps a drive from ever moving steadily, and comes and goes while
the drive slides. Steps from many places along the way are therefore averaged, with the weights of
a window (the square of Hann's): the weighted sum of a wave is 0 if the wave is long compared with
the distance of the places, and short compared with the way.
"""

from functools import lru_cache, partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from hfc_design.core import devices
from hfc_design.core.numbers import Floats, Parameters
from hfc_design.core.plugins import own_code
from hfc_design.core.records import UserError
from hfc_design.stability.margins import balanced
from plants import Drive

#: Integration steps in a control sample, at first and at most.
SUBSTEPS, MOST_SUBSTEPS = 16, 1024
REFUSED = "the drive {} cannot be linearised: {}"
#: Advice for a drive that never moves steadily, not even in the mean over its way.
UNSTEADY = (
    "a likely reason is a force that depends on the position with non-zero mean, such as "
    "a spring: leave it out of the model, or use a controller that needs no linear "
    "model, such as pid"
)
GAP = (
    "its backlash is the cause: set plant.parameters.backlash=0 for a linear model; "
    "[stress] tests backlash"
)
#: Largest distance to the unit circle of a pole that does not settle by itself.
SETTLES = 1e-9
#: Speeds that are tried [of the position, per s], the highest first.
SPEEDS = 10.0 ** np.arange(6.0, -6.25, -0.25)
#: Newton's steps towards a steady motion, the change [1] at which it has converged, and the change
#: at which it is near enough.
TRIES, SETTLED, NEAR = 20, 1e-9, 1e-5
#: Largest number that counts as 0 beside numbers of size 1.
RANK = 1e-9
#: Factor to which the sought speed is known.
CLOSE = 1.0 + 1e-9
#: Places along the way, as shares of it.
SHARES = (np.arange(1024) + 0.5) / 1024 - 0.5
#: Lengths of travel that are tried [of the position]: one of them contains many waves of a periodic
#: force, each with many places. The lengths are not round, since a wavelength may be.
WAYS = 1.618 * 10.0 ** np.arange(-6.0, 6.5, 0.5)
#: Largest remaining share of a force's slope for which its mean along a way counts as 0.
LEFT = 1e-3
#: Remaining shares below this count as equal: they are rounding, which grows with the way.
NOTHING = 1e-9


class Step(NamedTuple):
    """Integration step from a state, and its derivatives."""

    after: Floats  # (states,)
    a: Floats  # (states, states)
    b: Floats  # (states,)
    load: Floats  # (states,)
    along: Floats  # (states,) change of the states over a unit of travel
    changed: float  # change of the step by this travel, as a share of it; inf: the step failed


class Motion(NamedTuple):
    """Steady motion: speed, command and all other values are the same from step to step."""

    speed: float
    state: Floats  # (states,) at position 0
    command: float
    along: Floats  # (states,) change of the states over a unit of travel


class Steady(NamedTuple):
    """Command and state that a part of a motion needs in the steady state."""

    command: float
    state: Floats  # (states,)


class Slides:
    """Drive with differentiated steps, averaged over a ``way``; JAX must have float64.

    ``along`` (states,) is the change of the states over a unit of travel. By default all encoders
    are shifted along the way, and ``along`` is found from the mean of the steps.
    """

    def __init__(
        self, drive: Drive, parameters: Parameters, way: float = 0.0, along: Floats | None = None
    ):
        fields, rows = type(drive.initial_state(0.0))._fields, reported(drive, parameters)
        #: Position that is fed back, as a row (states,).
        self.seen, rate = (np.eye(len(fields))[fields.index(name)] for name in drive.seen)
        signals = {name: np.asarray(row, float) for name, row in rows.items()}
        self.outputs = {"error": -self.seen, "error_rate": -rate, **signals}
        rates = {drive.velocity, drive.seen[1], *drive.encoders.values()}
        self._moving = np.array([float(name in rates) for name in fields])
        places = {*drive.encoders, drive.position, drive.seen[0]}
        moved = np.array([float(name in places) for name in fields]) if along is None else along
        self._shifts = way * np.outer(SHARES if way else [0.0], moved)
        self._taken, self._known = partial(differentiated, drive, parameters), along
        self.fastest = partial(drive.fastest, parameters)

    def step(self, state: Floats, command: float, dt: float) -> Step:
        """Return the step from a state under a command, without a load, averaged over all places.

        The mean does not depend on the place of the state.
        """
        parts = self._taken(state, command, dt, self._shifts)[0]
        after, a, b, load = map(np.asarray, parts)
        if not all(np.isfinite(part).all() for part in parts):
            return Step(after, a, b, load, self.seen, np.inf)
        along, changed = self._along(a)
        if len(self._shifts) > 1:
            a, changed = a - np.outer(a @ along - along, self.seen), 0.0
        return Step(after, a, b, load, along, changed)

    def _along(self, a: Floats) -> tuple[Floats, float]:
        """Return the change of states over a unit of travel that alters a step least, and how much.

        The first is (states,), the second a share in units that balance the step; 0: the whole
        drive can be shifted without any effect.
        """
        if self._known is not None:
            return self._known, 0.0
        a, units = balanced(a)
        moved, others = a - np.eye(len(a)), self.seen == 0.0
        along = self.seen.copy()
        along[others] = -np.linalg.lstsq(moved[:, others], moved @ self.seen, RANK)[0]
        off = np.linalg.norm(moved @ along) / np.linalg.norm(along)
        return units * along / (units @ self.seen), float(off)

    def left(self, dt: float) -> tuple[float, Floats]:
        """Return how much of the effect of travel remains in the mean of the steps, and ``along``.

        The first is a share; inf if travel has no effect on any step, or if a step fails.
        """
        mean, slopes = self._taken(np.zeros(len(self.seen)), 0.0, dt, self._shifts)
        if not np.isfinite(slopes).all():
            return np.inf, self.seen
        a = np.asarray(mean[1])
        along, _ = self._along(a)
        each = np.linalg.norm(slopes @ along - along, axis=1)
        left, whole = np.linalg.norm(a @ along - along), np.sqrt(np.mean(each**2))
        return float(left / whole) if whole else np.inf, along

    def motion(self, speed: float, dt: float, near: Motion | None = None) -> Motion | None:
        """Return the steady motion with a speed, in steps of ``dt`` [s]; None if none is found.

        Newton's method begins without forces and, where that fails, with the contacts of the motion
        ``near`` it: within a backlash no command moves the parts behind it.
        """
        motion = self._from(speed * self._moving, 0.0, speed, dt)
        if motion is None and near is not None:
            state = near.state + (speed - near.speed) * self._moving
            motion = self._from(state, near.command, speed, dt)
        return motion

    def _from(self, state: Floats, command: float, speed: float, dt: float) -> Motion | None:
        moved = np.inf
        for _ in range(TRIES):
            one = self.step(state, command, dt)
            if one.changed > RANK:
                return None
            off = np.append(state + speed * dt * one.along - one.after, -self.seen @ state)
            try:
                move = np.linalg.solve(self._bordered(one.a, one.b), off)
            except np.linalg.LinAlgError:
                return None
            state, command = state + move[:-1], command + float(move[-1])
            before, moved = moved, np.abs(move).max() / max(np.abs(state).max(), abs(command))
            # If a drive is stiff, or steps begin far away, rounding keeps the change above SETTLED.
            if moved <= SETTLED or before <= moved <= NEAR:
                return Motion(speed, state, command, one.along)
        return None

    def _bordered(self, a: Floats, b: Floats) -> Floats:
        """Return the matrix from a change of state and command to that of step and position."""
        return np.block([[a - np.eye(len(a)), b[:, None]], [self.seen[None], np.zeros((1, 1))]])

    def asks(self, a: Floats, b: Floats, change: Floats) -> Steady:
        """Return command u and state x at position 0 that solve ``(a - 1) x + b u = change``."""
        solution = np.linalg.solve(self._bordered(a, b), np.append(change, 0.0))
        return Steady(float(solution[-1]), solution[:-1])

    def slowest(self, dt: float) -> Motion | None:
        """Return the motion at the lowest speed above which the command's growing part dominates.

        For the command u of steady motion at the speed v, the growing part is ``v du/dv``, the
        other part ``u - v du/dv``. Without Coulomb friction the motion is that of the lowest speed
        of all, without viscous friction that of the highest.
        """
        candidate, low = None, None
        for speed in SPEEDS.tolist():
            motion = self.motion(speed, dt, candidate)
            if candidate is not None and motion is not None and not self._grows(motion, dt):
                low = speed
                break
            candidate = motion or candidate
        while candidate is not None and low is not None and candidate.speed > CLOSE * low:
            speed = float(np.sqrt(low * candidate.speed))
            motion = self.motion(speed, dt, candidate)
            if motion is not None and self._grows(motion, dt):
                candidate = motion
            else:
                low = speed
        return candidate

    def _grows(self, motion: Motion, dt: float) -> bool:
        one = self.step(motion.state, motion.command, dt)
        growing = motion.speed * self.asks(one.a, one.b, dt * motion.along).command
        return bool(abs(motion.command - growing) <= abs(growing))


def averaged(drive: Drive, parameters: Parameters, dt: float) -> Slides | None:
    """Return the drive averaged over the way on which position-dependent forces have the mean 0.

    None if there are no such forces, or if their mean is not 0 along any way, as for a spring.
    """
    each = [
        Slides(drive, parameters, way, Slides(drive, parameters, way).left(dt)[1]) for way in WAYS
    ]
    left = [max(one.left(dt)[0], NOTHING) for one in each]
    best = int(np.argmin(left))
    return each[best] if left[best] < LEFT else None


@partial(jax.jit, static_argnums=0)
def reported(drive: Drive, parameters: Parameters) -> dict[str, Any]:
    """Return for each signal of the drive its derivatives (states,) by the states."""
    kind, fixed = type(drive.initial_state(0.0)), drive.coefficients(parameters)
    states = jnp.ones(len(kind._fields))
    rows: dict[str, Any] = jax.jacfwd(lambda x: drive.signals(fixed, kind(*x)))(states)
    return rows


@partial(jax.jit, static_argnums=0)
def differentiated(
    drive: Drive, parameters: Parameters, x: Any, command: Any, dt: Any, shifts: Any
) -> Any:
    """Return means over ``shifts`` of state after a step, derivatives by state, command and load.

    The last result is the derivative by the state at each shift, (shifts, states, states).
    """
    kind, fixed = type(drive.initial_state(0.0)), drive.coefficients(parameters)

    def step(x: Any, command: Any, load: Any) -> Any:
        moved = drive.step(fixed, kind(*x), command, (load, load, load), dt)
        return jnp.stack([jnp.asarray(part, float) for part in moved])

    def both(shift: Any) -> Any:
        about = (x + shift, command, 0.0)
        return step(*about) - shift, *jax.jacfwd(step, argnums=(0, 1, 2))(*about)

    parts = jax.vmap(both)(shifts)
    turns = jnp.pi * (jnp.arange(len(shifts)) + 0.5) / len(shifts)
    weights = jnp.sin(turns) ** 4 / jnp.sum(jnp.sin(turns) ** 4)
    return [jnp.tensordot(weights, part, axes=1) for part in parts], parts[1]


class Nominal(NamedTuple):
    """Linear model of a sliding drive near a speed: ``x(k+1) = a x + b u``, for a control sample.

    The command is held for the sample. The rows of ``outputs`` turn a state into signals; "error"
    and "error_rate" are those of a reference that stands still.
    """

    speed: float  # [of the position, per s]
    a: Floats  # (states, states)
    b: Floats  # (states,)
    outputs: dict[str, Floats]  # (states,) each
    velocity: Steady  # for a unit of it
    acceleration: Steady  # for a unit of it
    coulomb: Steady  # for the direction: extrapolated to speed 0 with the slope at ``speed``
    load: Steady  # for a unit of it


@lru_cache(maxsize=64)
def nominal(
    drive: Drive, parameters: Parameters, sample_time: float, speed: float | None = None
) -> Nominal:
    """Return the drive with ``parameters`` near ``speed``, or near the speed of ``Slides.slowest``.

    Raises:
        UserError: the drive has no steady motion, or cannot be moved from one.
    """
    devices.configure()
    with own_code(" cannot be linearised", ("plant", drive.name)), jax.enable_x64(True):
        slides = Slides(drive, parameters)
        operating_point = _operating_point(slides, sample_time, speed)
        if operating_point is None and (
            mean := averaged(drive, parameters, sample_time / SUBSTEPS)
        ):
            slides, operating_point = mean, _operating_point(mean, sample_time, speed)
    if operating_point is None:
        at = "any speed" if speed is None else f"{speed:g} {drive.units['error_rate']}"
        cause = GAP if getattr(parameters, "backlash", 0.0) > 0.0 else UNSTEADY
        why = f"found no steady motion at {at}; {cause}"
        raise UserError(REFUSED.format(drive.name, why))
    motion, one, substeps = operating_point
    a, b, load = _sampled(one, substeps)
    if not _controllable(a, b):
        why = "its command does not control all states that do not settle by themselves"
        raise UserError(REFUSED.format(drive.name, why))
    velocity = slides.asks(a, b, sample_time * motion.along)
    rising = 0.5 * sample_time**2 * motion.along + sample_time * velocity.state
    coulomb = Steady(
        motion.command - motion.speed * velocity.command,
        motion.state - motion.speed * velocity.state,
    )
    acceleration, load_own = slides.asks(a, b, rising), slides.asks(a, b, -load)
    parts = (velocity, acceleration, coulomb, load_own)
    return Nominal(motion.speed, a, b, slides.outputs, *parts)


def _operating_point(
    slides: Slides, sample_time: float, speed: float | None
) -> tuple[Motion, Step, int] | None:
    """Return a steady motion, a step from it, and the number of such steps in a control sample."""
    dt = sample_time / SUBSTEPS
    if speed is None:
        slowest = slides.slowest(dt)
        if slowest is None:
            return None
        speed = slowest.speed
    substeps = SUBSTEPS
    while slides.fastest(sample_time / substeps) < abs(speed) and substeps < MOST_SUBSTEPS:
        substeps *= 2
    every = sample_time / substeps
    motion = slides.motion(speed, every) or slides.motion(speed, every, slides.slowest(dt))
    return motion and (motion, slides.step(motion.state, motion.command, every), substeps)


def _sampled(one: Step, substeps: int) -> tuple[Floats, Floats, Floats]:
    """Return state, command and load matrices of ``substeps`` equal steps."""
    whole, power_sum = np.eye(len(one.a)), np.zeros_like(one.a)
    for _ in range(substeps):
        power_sum = power_sum + whole
        whole = whole @ one.a
    return whole, power_sum @ one.b, power_sum @ one.load


def _controllable(a: Floats, b: Floats) -> bool:
    """Whether the command moves everything that does not settle by itself (Hautus' test)."""
    a, units = balanced(a)
    b = b / units / (np.abs(b / units).max() or 1.0)
    lasting = [pole for pole in np.linalg.eigvals(a) if abs(pole) >= 1.0 - SETTLES]
    each = [np.column_stack([a - pole * np.eye(len(a)), b]) for pole in lasting]
    ranks = [np.linalg.matrix_rank(one, RANK * np.linalg.norm(one, 2)) for one in each]
    return all(rank == len(a) for rank in ranks)
