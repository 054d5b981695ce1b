"""One axis of a manual milling table that was given a servo-motor: backlash and stick-slip.

The machine of Huang & Shy (the self-organising and neural controllers of a retrofitted table),
which prints no parameters. Motor with screw and table are two masses, joined by a stiff spring
behind the backlash; the command is the voltage of the servo amplifier. Lengths are of the table:
what turns is counted by the lead of the screw.
"""

from math import pi
from typing import NamedTuple

import jax.numpy as jnp

from plants.backlash import Joined, Motion, motion
from plants.drive import NOT_NEGATIVE, Drive, Loads, Scalar, only_positive


class MillingTableParameters(NamedTuple):
    """Physical parameters of an axis."""

    motor_inertia: float = 8.0e-4  # of motor, coupling and screw [kg m2]
    motor_damping: float = 0.06  # of all that grows with speed, back-EMF included [N m s/rad]
    motor_friction: float = 0.05  # Coulomb friction of motor and bearings [N m]
    torque_gain: float = 0.14  # of amplifier and motor at rest [N m/V]
    lead: float = 5.0  # of the screw [mm/rev]
    table_mass: float = 100.0  # of table and load [kg]
    stiffness: float = 5.0e4  # of screw, nut and bearings [N/mm]
    damping: float = 20.0  # of the same [N s/mm]
    backlash: float = 0.4  # of the nut, from flank to flank [mm]
    coulomb_friction: float = 300.0  # of the slides [N]
    stiction_rise: float = 100.0  # break-away force less the Coulomb friction [N]
    stribeck_velocity: float = 1.0  # speed at which stiction has fallen to 1/e [mm/s]
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

    axis: Joined
    force_gain: Scalar  # [N/V]
    scale_resolution: Scalar  # [mm]
    motor_resolution: Scalar  # [mm]
    highest_voltage: Scalar  # [V]


#: Integration steps in a step: with 5 ms one is short beside a swing of the spring, some 10 ms.
INNER = 16


def coefficients(p: MillingTableParameters) -> MillingTableCoefficients:
    """Forces and masses as the table meets them through the screw."""
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
    """The state ``dt`` [s] later under a constant ``voltage`` [V] and ``loads`` [N]."""
    begin, middle, end = loads
    load = (begin + 4.0 * middle + end) / 6.0
    # The way within the step, not the position: a float32 would lose the deflection in that.
    deflection, still = x.motor_position - x.position, 0.0 * x.position
    start = Motion(deflection, x.motor_velocity, x.velocity, still, x.velocity)
    moved = motion(c.axis, start, c.force_gain * voltage, load, dt, INNER)
    position = x.position + moved.way
    motor = position + moved.deflection, moved.driving_velocity
    return MillingTableState(position, moved.velocity, *motor)


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
    resolutions={"position": "scale_resolution", "motor_position": "motor_resolution"},
    millimetres=lambda p: 1.0,
    top_speed=top_speed,
)
