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
from hfc_design.stability.steady import Near, SteadyMotions, travel
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
#: Largest distance to the unit circle of a pole that does not settle by itself.
SETTLES = 1e-9
#: Speeds that are tried [of the position, per s], the highest first.
SPEEDS = 10.0 ** np.arange(6.0, -6.25, -0.25)
#: Number of times that the interval of the sought speed is divided by as many speeds.
DIVIDED = 6
#: Largest number that counts as 0 beside numbers of size 1.
RANK = 1e-9
#: Places along the way, as shares of it.
SHARES = (np.arange(1024) + 0.5) / 1024 - 0.5
#: Lengths of travel that are tried [of the position]: one of them contains many waves of a periodic
#: force, each with many places. The lengths are not round, since a wavelength may be.
WAYS = 1.618 * 10.0 ** np.arange(-6.0, 6.5, 0.5)
#: Largest remaining share of a force's slope for which its mean along a way counts as 0.
LEFT = 1e-3
#: Remaining shares below this count as equal: they are rounding, which grows with the way.
NOTHING = 1e-9


class Steady(NamedTuple):
    """Command and state that a part of a motion needs in the steady state."""

    command: float
    state: Floats  # (states,)


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
    """Return the drive with ``parameters`` near ``speed``, or near the speed of ``_slowest``.

    Raises:
        UserError: the drive has no steady motion, or cannot be moved from one.
    """
    devices.configure()
    with own_code(" cannot be linearised", ("plant", drive.name)), jax.enable_x64(True):
        slides = _Slides(drive, parameters, np.zeros((1, len(_fields(drive)))))
        motion = slides.motion(sample_time, speed)
        if motion is None and (mean := slides.averaged(sample_time / SUBSTEPS)):
            motion = mean.motion(sample_time, speed)
    if motion is None:
        at = "any speed" if speed is None else f"{speed:g} {drive.units['error_rate']}"
        why = f"found no steady motion at {at}; {UNSTEADY}"
        raise UserError(REFUSED.format(drive.name, why))
    a, b, load = _sampled(motion)
    if not _controllable(a[0], b[0, :, 0]):
        why = "its command does not control all states that do not settle by themselves"
        raise UserError(REFUSED.format(drive.name, why))

    def needed(change: Floats) -> Steady:
        *state, command = motion.near.needed(a, b, change)[0]
        return Steady(float(command), np.array(state))

    along = motion.near.along[..., 0]
    velocity = needed(sample_time * along)
    acceleration = needed(0.5 * sample_time**2 * along + sample_time * velocity.state)
    *state, command = motion.x[0]
    coulomb = Steady(
        float(command) - motion.speed * velocity.command,
        np.array(state) - motion.speed * velocity.state,
    )
    outputs = {name: np.asarray(row[0]) for name, row in motion.near.more[0].items()}
    parts = (velocity, acceleration, coulomb, needed(-load))
    return Nominal(motion.speed, a[0], b[0, :, 0], outputs, *parts)


class _Motion(NamedTuple):
    """Steady motion of a drive, as one lane."""

    speed: float
    x: Floats  # (lanes, states + 1) states and command; all lanes are equal
    near: Near
    steps: int  # in a control sample


class _Slides(NamedTuple):
    """Drive with differentiated steps, averaged over ``shifts``; JAX must have float64."""

    drive: Drive
    parameters: Parameters
    shifts: Floats  # (places, states)

    def motion(self, sample_time: float, speed: float | None) -> _Motion | None:
        """Return the steady motion at a speed, None: at that of ``_slowest``; None: there is none.

        The integration steps are so short that they are stable at this speed.
        """
        lanes = 1
        if speed is None:
            lanes = len(SPEEDS)  # as many as in the search: a program serves one number of lanes
            if (speed := self._slowest(sample_time / SUBSTEPS)) is None:
                return None
        steps = SUBSTEPS
        while (
            self.drive.fastest(self.parameters, sample_time / steps) < abs(speed)
            and steps < MOST_SUBSTEPS
        ):
            steps *= 2
        x, near, exists = self._found(np.full(lanes, speed), sample_time / steps)
        return _Motion(speed, x, near, steps) if exists[0] else None

    def _found(self, speeds: Floats, dt: float) -> tuple[Floats, Near, Any]:
        """Return states and commands at speeds, steps of ``dt`` [s] there, and which exist."""
        drive, fields = self.drive, _fields(self.drive)
        rates = {drive.velocity, drive.seen[1], *drive.encoders.values()}
        moving = np.array([*(float(name in rates) for name in fields), 0.0])

        def step(x: Floats) -> Any:
            return _steps(drive, self.parameters, dt, self.shifts[None], x)

        each = speeds[:, None]
        x, near, exists = SteadyMotions(step, lambda k: k * each * moving, dt, each).found()
        alike = (near.changed <= RANK) | (len(self.shifts) > 1)
        return x, near, exists & alike & near.b.any(axis=(1, 2))

    def _slowest(self, dt: float) -> float | None:
        """Return the lowest speed above which the command's growing part dominates.

        For the command u of steady motion at the speed v, the growing part is ``v du/dv``, the
        other part ``u - v du/dv``. Without Coulomb friction the result is the lowest speed of all,
        without viscous friction the highest. None: the drive moves steadily at none of ``SPEEDS``.
        """
        speeds = SPEEDS
        for _ in range(DIVIDED):
            x, near, exists = self._found(speeds, dt)
            if not exists.any():
                return None
            growing = speeds * near.needed(near.a, near.b, dt * near.along[..., 0])[:, -1]
            ends = exists & ~(np.abs(x[:, -1] - growing) <= np.abs(growing))
            ends[: exists.argmax() + 1] = False
            low = int(ends.argmax()) if ends.any() else len(speeds)
            k = int(np.flatnonzero(exists[:low])[-1])
            if low == len(speeds):
                return float(speeds[k])
            speeds = np.geomspace(speeds[k], speeds[low], len(SPEEDS))
        return float(speeds[0])

    def averaged(self, dt: float) -> "_Slides | None":
        """Return the drive averaged over a way on which position-dependent forces have the mean 0.

        None if there are no such forces, or if their mean is not 0 along any way, as for a spring.
        """
        drive, fields = self.drive, _fields(self.drive)
        places = {*drive.encoders, drive.position, drive.seen[0]}
        along = np.tile([float(name in places) for name in fields], (len(WAYS), 1))
        x = np.zeros((len(WAYS), len(fields) + 1))
        for _ in range(2):  # the second time along the way on which a step has the least effect
            shifts = (WAYS[:, None] * SHARES)[..., None] * along[:, None]
            _, slopes, (_, each) = _steps(drive, self.parameters, dt, shifts, x)
            a, errors = np.split(np.asarray(slopes)[..., : len(fields)], [len(fields)], axis=1)
            along = travel(a, errors)[..., 0]
            effects = np.asarray(each) @ along[:, None, :, None] - along[:, None, :, None]
            mean = np.linalg.norm((a @ along[..., None])[..., 0] - along, axis=1)
            whole = np.sqrt(np.mean(np.sum(effects**2, axis=(2, 3)), axis=1))
        with np.errstate(divide="ignore", invalid="ignore"):
            left = np.fmax(
                np.where(np.isfinite(mean) & (whole > 0.0), mean / whole, np.inf), NOTHING
            )
        best = int(np.argmin(left))
        return self._replace(shifts=shifts[best]) if left[best] < LEFT else None


def _fields(drive: Drive) -> tuple[str, ...]:
    """Return the names of the states of a drive."""
    fields: tuple[str, ...] = type(drive.initial_state(0.0))._fields
    return fields


@partial(jax.jit, static_argnums=0, compiler_options=devices.QUICKLY)
def _steps(drive: Drive, parameters: Parameters, dt: Any, shifts: Any, x: Any) -> Any:
    """Return ``SteadyMotions.step`` of a drive, each value and slope the mean over ``shifts``.

    ``x`` (lanes, states + 1) are states and commands, ``shifts`` (lanes or 1, places, states). The
    last input is a load. The last result has the derivatives of the signals by the states, and
    those of the states by the states at each place, (lanes, places, states, states).
    """
    kind, fixed = type(drive.initial_state(0.0)), drive.coefficients(parameters)
    place, rate = map(kind._fields.index, drive.seen)
    size, places = len(kind._fields), shifts.shape[1]
    turns = jnp.pi * (jnp.arange(places) + 0.5) / places
    weights = jnp.sin(turns) ** 4 / jnp.sum(jnp.sin(turns) ** 4)

    def step(x: Any, shift: Any) -> Any:
        state, command, load = kind(*(x[:size] + shift)), x[size], x[size + 1]
        moved = drive.step(fixed, state, command, (load, load, load), dt)
        after = jnp.stack([jnp.asarray(part, float) for part in moved]) - shift
        values = jnp.append(after, -x[place])
        return values, values

    def signals(x: Any) -> Any:
        return {"error": -x[place], "error_rate": -x[rate], **drive.signals(fixed, kind(*x))}

    def averaged(x: Any, shifts: Any) -> Any:
        about = jnp.append(x, 0.0)
        slopes, values = jax.vmap(partial(jax.jacfwd(step, has_aux=True), about))(shifts)
        means = [jnp.tensordot(weights, part, axes=1) for part in (values, slopes)]
        return *means, (jax.jacfwd(signals)(x[:size]), slopes[:, :size, :size])

    return jax.vmap(averaged)(x, jnp.broadcast_to(shifts, (len(x), *shifts.shape[1:])))


def _sampled(motion: _Motion) -> tuple[Floats, Floats, Floats]:
    """Return state, command and load matrices, of one lane each, of all steps in a sample."""
    one = motion.near
    whole, power_sum = np.eye(one.a.shape[1])[None], np.zeros_like(one.a)
    for _ in range(motion.steps):
        power_sum = power_sum + whole
        whole = whole @ one.a
    size = one.a.shape[1]
    return whole, power_sum @ one.b, (power_sum @ one.slopes[:, :size, -1:])[..., 0]


def _controllable(a: Floats, b: Floats) -> bool:
    """Whether the command moves everything that does not settle by itself (Hautus' test)."""
    a, units = balanced(a)
    b = b / units / (np.abs(b / units).max() or 1.0)
    lasting = [pole for pole in np.linalg.eigvals(a) if abs(pole) >= 1.0 - SETTLES]
    each = [np.column_stack([a - pole * np.eye(len(a)), b]) for pole in lasting]
    ranks = [np.linalg.matrix_rank(one, RANK * np.linalg.norm(one, 2)) for one in each]
    return all(rank == len(a) for rank in ranks)
