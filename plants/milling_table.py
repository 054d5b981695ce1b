"""One axis of a manual milling table that was given a servo-motor: backlash and stick-slip.

The machine of Huang et al. (the self-organising and neural controllers of a retrofitted table),
which prints no parameters. Motor with screw and table are two masses, joined by a stiff spring
behind the backlash; the command is the voltage of the servo amplifier. Lengths are of the table:
what turns is counted by the lead of the screw.
"""

from math import pi
from typing import NamedTuple

import jax.numpy as jnp

from plants.blocks import bell, once
from plants.drive import NOT_NEGATIVE, Drive, Loads, Scalar, only_positive


class MillingTableParameters(NamedTuple):
    """Physical parameters of an axis."""

    motor_inertia: float = 1.0e-3  # of motor, coupling and screw [kg m2]
    motor_damping: float = 5.0e-2  # of all that grows with speed, back-EMF included [N m s/rad]
    motor_friction: float = 0.1  # Coulomb friction of motor and bearings [N m]
    torque_gain: float = 0.15  # of amplifier and motor at rest [N m/V]
    lead: float = 5.0  # of the screw [mm/rev]
    table_mass: float = 150.0  # [kg]
    stiffness: float = 5.0e4  # of screw, nut and bearings [N/mm]
    damping: float = 20.0  # of the same [N s/mm]
    backlash: float = 0.4  # of the nut, from flank to flank [mm]
    coulomb_friction: float = 300.0  # of the slides [N]
    stiction_rise: float = 150.0  # break-away force less the Coulomb friction [N]
    stribeck_velocity: float = 1.0  # [mm/s]
    viscous_friction: float = 5.0  # of the slides [N s/mm]
    scale_resolution: float = 0.005  # of the optical scale at the table [mm]
    motor_resolution: float = 0.00125  # of the encoder at the motor, in motion of the table [mm]
    highest_voltage: float = 10.0  # of either sign [V]


class MillingTableState(NamedTuple):
    """Where the axis is; every field a scalar."""

    position: Scalar  # of the table [mm]
    velocity: Scalar  # [mm/s]
    motor_position: Scalar  # of the nut, were there no backlash [mm]
    motor_velocity: Scalar  # [mm/s]


class MillingTableCoefficients(NamedTuple):
    """What a step needs of the parameters, everything in N, mm and s."""

    motor_mass: Scalar  # [N s2/mm]
    motor_damping: Scalar  # [N s/mm]
    motor_friction: Scalar  # [N]
    force_gain: Scalar  # [N/V]
    table_mass: Scalar  # [N s2/mm]
    stiffness: Scalar  # [N/mm]
    damping_time: Scalar  # damping over stiffness [s]
    half_backlash: Scalar  # [mm]
    coulomb: Scalar  # [N]
    stiction_rise: Scalar  # [N]
    inverse_stribeck_velocity: Scalar  # [s/mm]
    viscous: Scalar  # [N s/mm]
    scale_resolution: Scalar  # [mm]
    motor_resolution: Scalar  # [mm]
    highest_voltage: Scalar  # [V]


#: Integration steps in a step of whatever length: the spring swings with some 100 Hz.
INNER = 8


def coefficients(p: MillingTableParameters) -> MillingTableCoefficients:
    """Forces and masses as the table sees them through the screw."""
    turn = 2.0 * pi / p.lead  # [rad/mm]
    return MillingTableCoefficients(
        motor_mass=1e3 * p.motor_inertia * turn * turn,
        motor_damping=1e3 * p.motor_damping * turn * turn,
        motor_friction=1e3 * p.motor_friction * turn,
        force_gain=1e3 * p.torque_gain * turn,
        table_mass=1e-3 * p.table_mass,
        stiffness=p.stiffness,
        damping_time=p.damping / p.stiffness,
        half_backlash=0.5 * p.backlash,
        coulomb=p.coulomb_friction,
        stiction_rise=p.stiction_rise,
        inverse_stribeck_velocity=1.0 / p.stribeck_velocity,
        viscous=p.viscous_friction,
        scale_resolution=p.scale_resolution,
        motor_resolution=p.motor_resolution,
        highest_voltage=p.highest_voltage,
    )


def sliding_friction(c: MillingTableCoefficients, velocity: Scalar) -> Scalar:
    """Magnitude of the slides' friction [N] without its viscous part; at rest: of break-away."""
    return c.coulomb + c.stiction_rise * bell(1.0, velocity * c.inverse_stribeck_velocity)


def step(
    c: MillingTableCoefficients, x: MillingTableState, voltage: Scalar, loads: Loads, dt: Scalar
) -> MillingTableState:
    """The state ``dt`` [s] later under a constant ``voltage`` [V] and ``loads`` [N].

    The spring acts as ``k dead_zone(d + c/k dd/dt)`` with the deflection d: it is continuous where
    the flanks meet, never pulls, and what it takes beyond its own energy is lost. Friction is
    Coulomb's with Stribeck's rise: at rest the slides bear any force up to their break-away level.
    """
    start, middle, end = loads
    acting = _acting(c, c.force_gain * voltage, (start + 4.0 * middle + end) / 6.0, dt / INNER)
    # The way within the step, not the position: a float32 would lose the deflection in that.
    moved = _Moved(x.motor_position - x.position, x.motor_velocity, x.velocity, 0.0 * x.position)
    for _ in range(INNER):
        moved = _inner_step(c, acting, moved)
    position = x.position + moved.way
    return MillingTableState(
        position, moved.velocity, position + moved.deflection, moved.motor_velocity
    )


class _Moved(NamedTuple):
    """The axis within a step."""

    deflection: Scalar  # of the motor's position from that of the table [mm]
    motor_velocity: Scalar  # [mm/s]
    velocity: Scalar  # [mm/s]
    way: Scalar  # of the table since the step began [mm]


class _Acting(NamedTuple):
    """What all inner steps of a step share."""

    push: Scalar  # of the motor [N]
    load: Scalar  # on the table [N]
    dt: Scalar  # [s]
    reach: Scalar  # dt / 2 and the time of the damping [s]
    motor_kept: Scalar  # M / dt - b / 2 of the motor [N s/mm]
    motor_ease: Scalar  # velocity over force, 1 / (M / dt + b / 2) [mm/(N s)]
    table_kept: Scalar  # the same of the table
    table_ease: Scalar


def _acting(c: MillingTableCoefficients, push: Scalar, load: Scalar, dt: Scalar) -> _Acting:
    motor, table = c.motor_mass / dt, c.table_mass / dt
    return _Acting(
        push,
        load,
        dt,
        0.5 * dt + c.damping_time,
        motor - 0.5 * c.motor_damping,
        1.0 / (motor + 0.5 * c.motor_damping),
        table - 0.5 * c.viscous,
        1.0 / (table + 0.5 * c.viscous),
    )


def _beyond(force: Scalar, friction: Scalar) -> Scalar:
    """What a force moves against Coulomb friction; 0 where that holds it."""
    return force - jnp.clip(force, -friction, friction)


def _inner_step(c: MillingTableCoefficients, a: _Acting, x: _Moved) -> _Moved:
    """The implicit midpoint rule, friction by the velocity at the end, solved exactly.

    With the spring's force F the velocities at the end are ``ease * beyond(force -/+ F)``, so that
    the midpoint deflection falls with F, by pieces on straight lines, while the spring's rises:
    they meet once. The step is stable for every ``dt`` and brings no energy in.
    """
    motor_friction = c.motor_friction
    friction = sliding_friction(c, x.velocity)
    motor = a.motor_kept * x.motor_velocity + a.push
    table = a.table_kept * x.velocity - a.load
    half = 0.5 * a.reach
    before = x.deflection + half * (x.motor_velocity - x.velocity)
    motor_slope, table_slope = half * a.motor_ease, half * a.table_ease

    # d + reach * its midpoint rate, were there no spring
    free = before + motor_slope * _beyond(motor, motor_friction)
    free = free - table_slope * _beyond(table, friction)
    side = jnp.sign(free)
    force = side * _spring(
        c,
        side * before - c.half_backlash,
        side * free - c.half_backlash,
        (side * motor, motor_friction, motor_slope),
        (-side * table, friction, table_slope),
    )
    motor_after = a.motor_ease * _beyond(motor - force, motor_friction)
    table_after = a.table_ease * _beyond(table + force, friction)
    motor_way = 0.5 * a.dt * (x.motor_velocity + motor_after)
    way = 0.5 * a.dt * (x.velocity + table_after)
    return _Moved(
        once(x.deflection + (motor_way - way)), once(motor_after), once(table_after), x.way + way
    )


#: A body that the spring slows down: its force, its friction, deflection a unit of force less.
Body = tuple[Scalar, Scalar, Scalar]


def _spring(
    c: MillingTableCoefficients, before: Scalar, free: Scalar, one: Body, other: Body
) -> Scalar:
    """The force F [N] of the spring, not negative: k times the deflection beyond the gap.

    Solves ``before + sum(slope * beyond(force - F, friction)) = F / k`` over both bodies; the left
    side falls from ``free`` at F = 0. Its corners are where a body begins or ceases to stick; from
    the last corner with the left side larger a straight line leads to F.
    """
    ease = 1.0 / c.stiffness
    lowest, above = 0.0 * free, free
    for (force, friction, _), (its, held, slope) in ((one, other), (other, one)):
        for corner in (force - friction, force + friction):
            left = before + slope * _beyond(its - corner, held) - ease * corner
            further = (corner > lowest) & (left > 0.0)
            lowest, above = jnp.where(further, corner, lowest), jnp.where(further, left, above)
    steep = ease
    for force, friction, slope in (one, other):
        moves = (lowest < force - friction) | (lowest >= force + friction)
        steep = steep + jnp.where(moves, slope, 0.0)
    return jnp.where(free > 0.0, lowest + above / steep, 0.0)


def accepted(c: MillingTableCoefficients, command: Scalar) -> Scalar:
    """The voltage that the amplifier takes [V]."""
    return jnp.clip(command, -c.highest_voltage, c.highest_voltage)


def _counted(position: Scalar, resolution: Scalar) -> Scalar:
    """The nearest count of an encoder [mm]; a resolution of 0 is ideal."""
    ideal = resolution == 0.0
    step = jnp.where(ideal, 1.0, resolution)
    return jnp.where(ideal, position, step * jnp.round(position / step))


def measured(c: MillingTableCoefficients, x: MillingTableState) -> MillingTableState:
    """The state as the scale and the motor's encoder count it."""
    return x._replace(
        position=_counted(x.position, c.scale_resolution),
        motor_position=_counted(x.motor_position, c.motor_resolution),
    )


def top_speed(p: MillingTableParameters) -> float:
    """Speed [mm/s] that the highest voltage holds against all friction."""
    c = coefficients(p)
    left = c.force_gain * c.highest_voltage - c.motor_friction - c.coulomb
    return max(float(left / (c.motor_damping + c.viscous)), 0.0)


MAY_BE_ZERO = ("motor_friction", "damping", "backlash", "coulomb_friction", "stiction_rise")
MAY_BE_ZERO += ("viscous_friction", "scale_resolution", "motor_resolution")

MILLING_TABLE = Drive(
    name="milling-table",
    parameters=MillingTableParameters,
    exact=frozenset({"lead", "scale_resolution", "motor_resolution", "highest_voltage"}),
    fault=only_positive(MillingTableParameters, **dict.fromkeys(MAY_BE_ZERO, NOT_NEGATIVE)),
    units={
        "error": "mm",
        "error_rate": "mm/s",
        "command": "V",
        "load": "N",
        "position": "mm",
        "velocity": "mm/s",
        "motor_position": "mm",
        "motor_velocity": "mm/s",
    },
    parameter_units={
        "motor_inertia": "kg m2",
        "motor_damping": "N m s/rad",
        "motor_friction": "N m",
        "torque_gain": "N m/V",
        "lead": "mm/rev",
        "table_mass": "kg",
        "stiffness": "N/mm",
        "damping": "N s/mm",
        "backlash": "mm",
        "coulomb_friction": "N",
        "stiction_rise": "N",
        "stribeck_velocity": "mm/s",
        "viscous_friction": "N s/mm",
        "scale_resolution": "mm",
        "motor_resolution": "mm",
        "highest_voltage": "V",
    },
    meanings={
        "command": "voltage to the servo amplifier, positive moves the table forwards",
        "position": "of the table, as its optical scale counts",
        "motor_position": "by the encoder at the motor: where the table would be without backlash",
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
    millimetres=lambda p: 1.0,
    top_speed=top_speed,
)
