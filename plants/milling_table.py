"""One axis of a manual milling table retrofitted with a servo-motor: backlash and stick-slip.

The machine of Huang & Shy (the self-organising and neural controllers of a retrofitted table),
which prints no parameters. Motor with screw and table are two masses, joined by a stiff spring
behind the backlash; the command is the voltage of the servo amplifier. Lengths are of the table:
rotation is counted by the lead of the screw.

The friction of both masses holds them fully at rest. Each step is solved exactly for the piecewise
linear spring and friction, so that it is stable for any length and finds sticking without a
threshold. Energy can grow only in a step in which a body stops or reverses, or flanks touch or
part: by a percent if the step is short compared with a period of the spring, for which ``motion``
takes several steps.
"""

from math import pi
from typing import Annotated, NamedTuple, TypeAlias

import jax.numpy as jnp
from jax import lax

from plants.blocks import bell, counted, once
from plants.drive import NOT_NEGATIVE, Drive, Loads, Scalar, only_positive, units_in


class Joined(NamedTuple):
    """Driving body and driven body; any consistent units, here N, mm and s."""

    driving_mass: Scalar  # [N s2/mm]
    driving_damping: Scalar  # [N s/mm]
    driving_friction: Scalar  # Coulomb friction of the driving body [N]
    driven_mass: Scalar  # [N s2/mm]
    viscous: Scalar  # friction of the driven body [N s/mm]
    coulomb: Scalar  # of the driven body [N]
    stiction_rise: Scalar  # break-away force less the Coulomb friction [N]
    inverse_stribeck_velocity: Scalar  # [s/mm]
    stiffness: Scalar  # of the spring between the bodies [N/mm]
    damping_time: Scalar  # damping over stiffness of the spring [s]
    half_gap: Scalar  # half of the backlash [mm]


class Motion(NamedTuple):
    """Motion of the two bodies since the start of a simulation step."""

    deflection: Scalar  # of the driving body from the driven one, 0 in the middle of the gap [mm]
    driving_velocity: Scalar  # [mm/s]
    velocity: Scalar  # of the driven body [mm/s]
    way: Scalar  # travel of the driven body since that start [mm]
    before: Scalar  # velocity of the driven body one integration step ago [mm/s]


def motion(
    c: Joined, start: Motion, push: Scalar, load: Scalar, time: Scalar, steps: int
) -> Motion:
    """Return the bodies ``time`` [s] later under constant ``push`` and ``load`` forces [N].

    The spring acts as ``k dead_zone(d + c/k dd/dt)`` on its deflection d: continuous where the
    flanks meet, never pulling, always losing energy. The driven body has Coulomb friction with
    Stribeck's rise: at rest it withstands any force up to the break-away level.
    """
    forces = _forces(c, push, load, time / steps)
    moved: Motion = lax.fori_loop(0, steps, lambda _, x: _step(c, forces, x), start)
    return moved


def sliding_friction(c: Joined, velocity: Scalar) -> Scalar:
    """Return the magnitude of the driven body's friction [N] without its viscous part."""
    return c.coulomb + c.stiction_rise * bell(1.0, velocity * c.inverse_stribeck_velocity)


class _Forces(NamedTuple):
    """Constants of all steps; the velocity of a body after a step is ``ease`` times a force."""

    push: Scalar  # [N]
    load: Scalar  # [N]
    dt: Scalar  # [s]
    range: Scalar  # time from the start of a step to the moment of the spring's force [s]
    driving_kept: Scalar  # force for a velocity that persists, M / dt - b / 2 [N s/mm]
    driving_ease: Scalar  # velocity for a force, 1 / (M / dt + b / 2) [mm/(N s)]
    driven_kept: Scalar  # the same of the driven body
    driven_ease: Scalar  # the same of the driven body


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
    """Return the motion after a step of the implicit midpoint rule, with friction at its end.

    Friction acts against the velocity at the end. The step is of second order except where a body
    comes to rest. The place on the friction curve is extrapolated from the known velocities.
    """
    middle = jnp.where(x.velocity == 0.0, 0.0, 1.5 * x.velocity - 0.5 * x.before)
    friction = once(sliding_friction(c, middle))
    push = f.driving_kept * x.driving_velocity + f.push
    pull = f.driven_kept * x.velocity - f.load
    half = 0.5 * f.range
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
    """Return what Coulomb friction leaves of a force; 0 where friction holds the body."""
    return force - jnp.clip(force, -friction, friction)


class _Body(NamedTuple):
    """What the force of the spring depends on, of one body."""

    force: Scalar  # on the body without the spring, positive away from the other body [N]
    friction: Scalar  # [N]
    slope: Scalar  # deflection for a unit of the force [mm/N]


#: Two bodies, both held back by the spring.
_Pair: TypeAlias = tuple[_Body, _Body]


def _spring(c: Joined, known: Scalar, *bodies: _Body) -> Scalar:
    """Return the force of the spring [N], positive where the driving body pushes forwards.

    ``known`` is the part of the deflection that does not depend on the force.
    """
    free = known + sum(body.slope * _beyond(body.force, body.friction) for body in bodies)
    side = jnp.sign(free)
    one, other = (body._replace(force=side * body.force) for body in bodies)
    known, free = (side * deflection - c.half_gap for deflection in (known, free))
    crossing = side * _crossing(1.0 / c.stiffness, known, free, (one, other))
    return jnp.where(free <= 0.0, 0.0, crossing)  # a nan passes on to both bodies


def _crossing(ease: Scalar, known: Scalar, free: Scalar, bodies: _Pair) -> Scalar:
    """Return the positive F at which ``known + sum(slope beyond(force - F, friction)) = ease F``.

    The left side is ``free`` at F = 0 and falls along straight lines, with bends at the forces at
    which a body begins or ceases to stick. The solution is on the line behind the last bend at
    which the left side is still the larger one.
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


class MillingTableParameters(NamedTuple):
    """Physical parameters of an axis."""

    motor_inertia: Annotated[float, "kg m2"] = 8.0e-4  # of motor, coupling and screw
    #: of all that grows with speed, back-EMF included
    motor_damping: Annotated[float, "N m s/rad"] = 0.06
    motor_friction: Annotated[float, "N m"] = 0.05  # Coulomb friction of motor and bearings
    torque_gain: Annotated[float, "N m/V"] = 0.14  # of amplifier and motor at rest
    lead: Annotated[float, "mm/rev"] = 5.0  # of the screw
    table_mass: Annotated[float, "kg"] = 100.0  # of table and load
    stiffness: Annotated[float, "N/mm"] = 5.0e4  # of screw, nut and bearings
    damping: Annotated[float, "N s/mm"] = 20.0  # of screw, nut and bearings
    backlash: Annotated[float, "mm"] = 0.4  # of the nut, from flank to flank
    coulomb_friction: Annotated[float, "N"] = 300.0  # of the slides
    stiction_rise: Annotated[float, "N"] = 100.0  # break-away force less the Coulomb friction
    stribeck_velocity: Annotated[float, "mm/s"] = 1.0  # speed at which stiction has fallen to 1/e
    viscous_friction: Annotated[float, "N s/mm"] = 5.0  # of the slides
    scale_resolution: Annotated[float, "mm"] = 0.005  # of the optical scale at the table
    #: of the encoder at the motor, as travel of the table
    motor_resolution: Annotated[float, "mm"] = 0.00125
    highest_voltage: Annotated[float, "V"] = 10.0  # of either sign


class MillingTableState(NamedTuple):
    """State of the axis; every field a scalar."""

    position: Scalar  # of the table [mm]
    velocity: Scalar  # [mm/s]
    motor_position: Scalar  # of the nut, were there no backlash [mm]
    motor_velocity: Scalar  # [mm/s]


class MillingTableCoefficients(NamedTuple):
    """Quantities that a step needs of the parameters, all in N, mm and s."""

    axis: Joined
    force_gain: Scalar  # [N/V]
    scale_resolution: Scalar  # [mm]
    motor_resolution: Scalar  # [mm]
    highest_voltage: Scalar  # [V]


#: Integration steps in a step. One of 5 ms / 16 is short beside a period of the spring (~10 ms).
INNER = 16


def coefficients(p: MillingTableParameters) -> MillingTableCoefficients:
    """Return the coefficients; forces and masses of the motor are those seen at the table."""
    turn = 2.0 * pi / p.lead  # [rad/mm]
    axis = Joined(
        driving_mass=1e3 * p.motor_inertia * turn * turn,
        driving_damping=1e3 * p.motor_damping * turn * turn,
        driving_friction=1e3 * p.motor_friction * turn,
        driven_mass=1e-3 * p.table_mass,
        viscous=p.viscous_friction,
        coulomb=p.coulomb_friction,
        stiction_rise=p.stiction_rise,
        inverse_stribeck_velocity=1.0 / p.stribeck_velocity,
        stiffness=p.stiffness,
        damping_time=p.damping / p.stiffness,
        half_gap=0.5 * p.backlash,
    )
    force_gain = 1e3 * p.torque_gain * turn
    counts = p.scale_resolution, p.motor_resolution
    return MillingTableCoefficients(axis, force_gain, *counts, p.highest_voltage)


def step(
    c: MillingTableCoefficients, x: MillingTableState, voltage: Scalar, loads: Loads, dt: Scalar
) -> MillingTableState:
    """Return the state ``dt`` [s] later under a constant ``voltage`` [V] and ``loads`` [N]."""
    begin, middle, end = loads
    load = (begin + 4.0 * middle + end) / 6.0
    # The travel within the step, not the position, in which float32 would lose the deflection.
    deflection, still = x.motor_position - x.position, 0.0 * x.position
    start = Motion(deflection, x.motor_velocity, x.velocity, still, x.velocity)
    moved = motion(c.axis, start, c.force_gain * voltage, load, dt, INNER)
    position = x.position + moved.way
    motor = position + moved.deflection, moved.driving_velocity
    return MillingTableState(position, moved.velocity, *motor)


def accepted(c: MillingTableCoefficients, command: Scalar) -> Scalar:
    """Return the voltage that the amplifier accepts [V]."""
    return jnp.clip(command, -c.highest_voltage, c.highest_voltage)


def measured(c: MillingTableCoefficients, x: MillingTableState) -> MillingTableState:
    """Return the state with the positions that the scale and the motor's encoder read."""
    return x._replace(
        position=counted(x.position, c.scale_resolution),
        motor_position=counted(x.motor_position, c.motor_resolution),
    )


def top_speed(p: MillingTableParameters) -> float:
    """Return the speed [mm/s] that the highest voltage holds against all friction."""
    c = coefficients(p)
    left = c.force_gain * c.highest_voltage - c.axis.driving_friction - c.axis.coulomb
    return max(float(left / (c.axis.driving_damping + c.axis.viscous)), 0.0)


MAY_BE_ZERO = (
    *("motor_friction", "damping", "backlash", "coulomb_friction", "stiction_rise"),
    *("viscous_friction", "scale_resolution", "motor_resolution"),
)
MILLING_TABLE = Drive(
    name="milling-table",
    parameters=MillingTableParameters,
    exact=frozenset({"lead", "scale_resolution", "motor_resolution", "highest_voltage"}),
    fault=only_positive(MillingTableParameters, **dict.fromkeys(MAY_BE_ZERO, NOT_NEGATIVE)),
    units=units_in("mm", "V", "N") | {"motor_position": "mm", "motor_velocity": "mm/s"},
    meanings={
        "command": "voltage to the servo amplifier, positive moves the table forwards",
        "position": "of the table, as its optical scale counts",
        "motor_position": "from the encoder at the motor: position of the table without backlash",
    },
    coefficients=coefficients,
    initial_state=lambda zero: MillingTableState(zero, zero, zero, zero),
    step=step,
    signals=lambda c, x: x._asdict(),
    position="position",
    velocity="velocity",
    encoders={"position": "velocity", "motor_position": "motor_velocity"},
    accepted=accepted,
    measured=measured,
    resolutions={"position": "scale_resolution", "motor_position": "motor_resolution"},
    millimetres=lambda p: 1.0,
    top_speed=top_speed,
)
