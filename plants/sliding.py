"""Drive of the first order against sliding friction, with stops computed at their exact time.

Solves ``tau dv/dt = K (drive - friction) - v``, ``dp/dt = v``; ``drive`` is the command or force
that moves the axis. Friction depends on speed and direction; at rest it has a break-away level.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import jax.numpy as jnp

from plants.drive import Scalar

#: Record with only the fields ``position`` and ``velocity``.
State = TypeVar("State", bound=Any)


class Slide(NamedTuple):
    """Coefficients of motion and friction."""

    gain: Scalar  # K, velocity over drive
    time_constant: Scalar  # tau [s]
    friction: Callable[[Scalar, Scalar], Scalar]  # (direction, speed) -> level, in units of drive
    stiction_rise: Scalar = 0.0  # break-away level less the friction at speed 0


def slid(slide: Slide, x: State, drive: Scalar, dt: Scalar) -> State:
    """Return the state ``dt`` [s] later under a constant ``drive``.

    A first leg lasts until the axis stops, a second one uses the rest of the step: the axis rests,
    or breaks away again. Each leg is the exact solution of the linear part under the mean of the
    friction at its ends. The step is of second order, exact where friction is constant, and stable
    for every ``dt``. It stops at the right time, which a fixed Runge-Kutta step would run past.
    """
    stopped, left = _leg(slide, x, drive, dt)
    return _leg(slide, stopped, drive, left)[0]


def _leg(slide: Slide, x: State, drive: Scalar, time: Scalar) -> tuple[State, Scalar]:
    """Return the motion in one direction until a stop or ``time`` [s], and the time [s] left."""
    rests = x.velocity == 0
    sticks = (
        rests
        & (drive <= slide.friction(1.0, 0.0) + slide.stiction_rise)
        & (-drive <= slide.friction(-1.0, 0.0) + slide.stiction_rise)
    )
    direction = jnp.sign(jnp.where(rests, drive, x.velocity))
    settled = -jnp.expm1(-time / slide.time_constant)

    before = slide.friction(direction, jnp.abs(x.velocity))
    target = slide.gain * (drive - direction * before)  # velocity that the drive tends to
    foreseen = direction * (x.velocity + (target - x.velocity) * settled)
    after = slide.friction(direction, jnp.maximum(foreseen, 0.0))
    target = slide.gain * (drive - direction * 0.5 * (before + after))
    change = (target - x.velocity) * settled
    velocity = x.velocity + change

    stops = velocity * direction < 0.0
    duration = jnp.where(
        stops, slide.time_constant * jnp.log1p(-x.velocity / jnp.where(stops, target, 1.0)), time
    )
    change = jnp.where(stops, -x.velocity, change)
    moved = type(x)(
        # from the integral of the drive's equation: tau (v - v_0) = target t - (p - p_0)
        position=x.position + target * duration - slide.time_constant * change,
        velocity=jnp.where(stops, 0.0, velocity),
    )
    return (
        type(x)(*(jnp.where(sticks, a, b) for a, b in zip(x, moved, strict=True))),
        jnp.where(stops, time - duration, 0.0),
    )
