"""Two bodies joined by a stiff spring behind backlash, both with friction that really holds them.

One step is solved exactly for the pieces of straight lines that spring and friction are made of,
so that it is stable whatever its length and finds sticking without a threshold. Energy grows in
steps alone in which flanks touch or part, by a percent where they are short beside a swing of the
spring; ``motion`` takes several of them.
"""

from typing import NamedTuple, TypeAlias

import jax.numpy as jnp
from jax import lax

from plants.blocks import bell, once
from plants.drive import Scalar


class Joined(NamedTuple):
    """A driving body and a driven one; any units that belong together, here N, mm and s."""

    driving_mass: Scalar  # [N s2/mm]
    driving_damping: Scalar  # [N s/mm]
    driving_friction: Scalar  # Coulomb's [N]
    driven_mass: Scalar  # [N s2/mm]
    viscous: Scalar  # friction of the driven body [N s/mm]
    coulomb: Scalar  # of the driven body [N]
    stiction_rise: Scalar  # break-away force less the Coulomb friction [N]
    inverse_stribeck_velocity: Scalar  # [s/mm]
    stiffness: Scalar  # [N/mm]
    damping_time: Scalar  # damping over stiffness of the spring [s]
    half_gap: Scalar  # half of the backlash [mm]


class Motion(NamedTuple):
    """The two bodies since some moment."""

    deflection: Scalar  # of the driving body from the driven one, 0 in the middle of the gap [mm]
    driving_velocity: Scalar  # [mm/s]
    velocity: Scalar  # of the driven body [mm/s]
    way: Scalar  # of the driven body since that moment [mm]
    before: Scalar  # its velocity a step ago [mm/s]


def motion(
    c: Joined, start: Motion, push: Scalar, load: Scalar, time: Scalar, steps: int
) -> Motion:
    """The bodies ``time`` [s] later, the one pushed and the other loaded by constant forces [N].

    The spring acts as ``k dead_zone(d + c/k dd/dt)`` on its deflection d: continuous where the
    flanks meet, never pulling, losing energy whatever it does. The driven body has Coulomb friction
    with Stribeck's rise: at rest it bears any force up to the break-away level.
    """
    forces = _forces(c, push, load, time / steps)
    moved: Motion = lax.fori_loop(0, steps, lambda _, x: _step(c, forces, x), start)
    return moved


def sliding_friction(c: Joined, velocity: Scalar) -> Scalar:
    """Magnitude of the driven body's friction [N] without its viscous part."""
    return c.coulomb + c.stiction_rise * bell(1.0, velocity * c.inverse_stribeck_velocity)


class _Forces(NamedTuple):
    """What all steps share. A body's velocity at the end of one is ``ease`` times a force."""

    push: Scalar  # [N]
    load: Scalar  # [N]
    dt: Scalar  # [s]
    reach: Scalar  # from the start to where the spring's force is taken [s]
    driving_kept: Scalar  # force that would keep a velocity, M / dt - b / 2 [N s/mm]
    driving_ease: Scalar  # 1 / (M / dt + b / 2) [mm/(N s)]
    driven_kept: Scalar
    driven_ease: Scalar


def _forces(c: Joined, push: Scalar, load: Scalar, dt: Scalar) -> _Forces:
    driving, driven = c.driving_mass / dt, c.driven_mass / dt
    return _Forces(
        push,
        load,
        dt,
        0.5 * dt + c.damping_time,
        driving - 0.5 * c.driving_damping,
        1.0 / (driving + 0.5 * c.driving_damping),
        driven - 0.5 * c.viscous,
        1.0 / (driven + 0.5 * c.viscous),
    )


def _step(c: Joined, f: _Forces, x: Motion) -> Motion:
    """The implicit midpoint rule, with friction against the velocity at the end.

    Of second order but for the step in which a body comes to rest. Where the curve of the friction
    is taken is extrapolated from the velocities at hand.
    """
    middle = jnp.where(x.velocity == 0.0, 0.0, 1.5 * x.velocity - 0.5 * x.before)
    friction = once(sliding_friction(c, middle))
    push = f.driving_kept * x.driving_velocity + f.push
    pull = f.driven_kept * x.velocity - f.load
    half = 0.5 * f.reach
    known = x.deflection + half * (x.driving_velocity - x.velocity)
    driving = _Body(push, c.driving_friction, half * f.driving_ease)
    driven = _Body(-pull, friction, half * f.driven_ease)
    force = once(_spring(c, known, driving, driven))

    driving_after = f.driving_ease * _beyond(push - force, c.driving_friction)
    after = f.driven_ease * _beyond(pull + force, friction)
    driving_way = 0.5 * f.dt * (x.driving_velocity + driving_after)
    way = 0.5 * f.dt * (x.velocity + after)
    deflection = once(x.deflection + (driving_way - way))
    return Motion(deflection, once(driving_after), once(after), x.way + way, x.velocity)


def _beyond(force: Scalar, friction: Scalar) -> Scalar:
    """What is left of a force after Coulomb friction; 0 where that holds it."""
    return force - jnp.clip(force, -friction, friction)


class _Body(NamedTuple):
    """A body as the spring meets it."""

    force: Scalar  # that would move it on, away from the other one [N]
    friction: Scalar  # [N]
    slope: Scalar  # deflection that it gives a newton [mm/N]


#: Two bodies, of which the spring holds back both.
_Pair: TypeAlias = tuple[_Body, _Body]


def _spring(c: Joined, known: Scalar, *bodies: _Body) -> Scalar:
    """The force of the spring [N], positive where the driving body pushes forwards.

    ``known`` is the deflection that does not depend on it.
    """
    free = known + sum(body.slope * _beyond(body.force, body.friction) for body in bodies)
    side = jnp.sign(free)
    one, other = (body._replace(force=side * body.force) for body in bodies)
    known, free = (side * deflection - c.half_gap for deflection in (known, free))
    crossing = side * _crossing(1.0 / c.stiffness, known, free, (one, other))
    return jnp.where(free <= 0.0, 0.0, crossing)  # what is no number shows in both bodies


def _crossing(ease: Scalar, known: Scalar, free: Scalar, bodies: _Pair) -> Scalar:
    """The positive F at which ``known + sum(slope beyond(force - F, friction)) = ease F``.

    The left side falls with F, from ``free`` at 0, on straight lines between the forces at which a
    body begins or ceases to stick. It is followed to the last of these that lies before F, and from
    there along its line.
    """
    last, above = 0.0 * free, free
    for body, other in (bodies, bodies[::-1]):
        for corner in (body.force - body.friction, body.force + body.friction):
            left = known + other.slope * _beyond(other.force - corner, other.friction)
            left = left - ease * corner
            further = (corner > last) & (left > 0.0)
            last, above = jnp.where(further, corner, last), jnp.where(further, left, above)
    fall = ease
    for body in bodies:
        moves = (last < body.force - body.friction) | (last >= body.force + body.friction)
        fall = fall + jnp.where(moves, body.slope, 0.0)
    return last + above / fall
