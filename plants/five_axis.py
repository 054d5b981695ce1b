"""Five-axis machines: servo drives X, Y, Z in mm and A (or B), C in deg, alone or coupled.

After the machine of Lin & Gai (2009, cited as LG09), of which Table 1 prints the settings of the
control and nothing of the mechanics: masses and friction here are those of a machine of its size.
In the paper the largest error, 15 mm at 30 m/min on X (10 deg at 20,000 deg/min on A), is the speed
divided by the gain 33.33. The unit of the gain is thus 1/s, and the command is a speed, the largest
at 8 V: the amplifiers close a proportional velocity loop, in which friction reduces the speed.
"""

from collections import namedtuple
from math import degrees
from typing import Any, NamedTuple

import jax.numpy as jnp

from plants.blocks import bell, once
from plants.drive import NOT_NEGATIVE, Drive, Loads, Scalar, only_positive, units_in
from plants.machine import Each, coupled, side_by_side
from plants.sliding import Slide, slid

#: Parameter -> unit for a linear axis, unit for a rotary axis, meaning.
UNITS = {
    "inertia": ("kg", "kg m2", "of all moving parts, including motor and screw or gear"),
    "viscous_friction": ("N s/m", "N m s/rad", "of guides or bearings"),
    "coulomb_friction": ("N", "N m", "of guides or bearings"),
    "stiction_rise": ("N", "N m", "break-away level less the Coulomb friction"),
    "stribeck_velocity": ("mm/s", "deg/s", "speed at which stiction has fallen to 1/e"),
    "amplifier_gain": ("N s/m", "N m s/rad", "force or torque over the error of the velocity"),
    "peak_force": ("N", "N m", "of the motor: a force, or a torque"),
    "unbalance": ("kg", "kg m", "mass off balance, or mass times its arm; felt where coupled"),
    "velocity_per_volt": ("(mm/s)/V", "(deg/s)/V", "commanded velocity of a volt"),
    "highest_voltage": ("V", "V", "of the command, of either sign"),
    "travel_per_turn": ("mm", "deg", "of the motor"),
    "counts_per_turn": ("1", "1", "of the encoder of the motor"),
}
#: Settings that are exact.
EXACT = frozenset({"velocity_per_volt", "highest_voltage", "travel_per_turn", "counts_per_turn"})
MAY_BE_ZERO = ("viscous_friction", "coulomb_friction", "stiction_rise", "unbalance")
#: Values of LG09, Table 1: command of the largest speed [V], counts of an encoder per turn.
VOLTS, COUNTS = 8.0, 16384.0
GRAVITY = 9.81  # [m/s2]


class ServoState(NamedTuple):
    """State of an axis; every field a scalar."""

    position: Scalar  # [mm or deg]
    velocity: Scalar  # [mm/s or deg/s]


class ServoCoefficients(NamedTuple):
    """Quantities that a step needs of the parameters; forces stand for torques too."""

    gain: Scalar  # velocity over force [(mm/s)/N or (deg/s)/(N m)]
    time_constant: Scalar  # of the loop of the velocity [s]
    stiffness: Scalar  # force of the amplifier over velocity [N/(mm/s) or N m/(deg/s)]
    viscous: Scalar  # viscous friction over velocity [N/(mm/s) or N m/(deg/s)]
    coulomb: Scalar  # [N or N m]
    stiction_rise: Scalar  # [N or N m]
    inverse_stribeck_velocity: Scalar
    peak_force: Scalar  # [N or N m]
    inertia: Scalar  # force over acceleration [N/(mm/s2) or N m/(deg/s2)]
    unbalance: Scalar  # [kg or kg m]
    velocity_per_volt: Scalar
    highest_voltage: Scalar  # [V]
    count: Scalar  # step of the encoder [mm or deg]


def _coefficients(per_unit: float, p: Any) -> ServoCoefficients:
    """Return the coefficients; ``per_unit``: number of mm in a m, or of deg in a rad."""
    whole = p.amplifier_gain + p.viscous_friction
    return ServoCoefficients(
        gain=per_unit / whole,
        time_constant=p.inertia / whole,
        stiffness=p.amplifier_gain / per_unit,
        viscous=p.viscous_friction / per_unit,
        coulomb=p.coulomb_friction,
        stiction_rise=p.stiction_rise,
        inverse_stribeck_velocity=1.0 / p.stribeck_velocity,
        peak_force=p.peak_force,
        inertia=p.inertia / per_unit,
        unbalance=p.unbalance,
        velocity_per_volt=p.velocity_per_volt,
        highest_voltage=p.highest_voltage,
        count=p.travel_per_turn / p.counts_per_turn,
    )


def sliding_friction(c: ServoCoefficients, speed: Scalar) -> Scalar:
    """Return the friction [N or N m] without its viscous part; at rest the break-away level."""
    relative = jnp.asarray(speed * c.inverse_stribeck_velocity)
    return c.coulomb + c.stiction_rise * bell(1.0, relative)


def step(
    c: ServoCoefficients, x: ServoState, volts: Scalar, loads: Loads, dt: Scalar
) -> ServoState:
    """Return the state ``dt`` [s] later under a constant command [V] and ``loads`` [N or N m].

    Solves J dv/dt = f - load - friction, dp/dt = v with the amplifier's force f = k (w - v) for the
    commanded velocity w: see ``slid``. The limit of f applies to its mean over the step.
    """
    start, middle, end = loads
    share = dt / c.time_constant
    most = c.peak_force / c.stiffness * share / -jnp.expm1(-share)
    commanded = x.velocity + jnp.clip(c.velocity_per_volt * volts - x.velocity, -most, most)
    drive = c.stiffness * commanded - (start + 4.0 * middle + end) / 6.0
    slide = Slide(c.gain, c.time_constant, lambda _, speed: sliding_friction(c, speed))
    return slid(slide, x, drive, dt)


def acceleration(c: ServoCoefficients, x: ServoState, volts: Scalar) -> Scalar:
    """Return the acceleration of an axis without a load [mm/s2 or deg/s2]."""
    force = c.stiffness * (c.velocity_per_volt * volts - x.velocity)
    force = jnp.clip(force, -c.peak_force, c.peak_force)
    rests, level = x.velocity == 0, sliding_friction(c, jnp.abs(x.velocity))
    direction = jnp.sign(jnp.where(rests, force, x.velocity))
    free = (force - direction * level - c.viscous * x.velocity) / c.inertia
    return jnp.where(rests & (jnp.abs(force) <= level), 0.0, free)


def _top_speed(c: ServoCoefficients) -> float:
    """Return the speed [of the position, per s] that the highest voltage holds against friction."""
    speed = c.gain * (c.stiffness * c.velocity_per_volt * c.highest_voltage - c.coulomb)
    if c.viscous > 0:
        speed = min(speed, (c.peak_force - c.coulomb) / c.viscous)
    return max(speed, 0.0) if c.peak_force > c.coulomb else 0.0


def per_unit_of(rotary: bool) -> float:
    """Return the units of the position per rad, or per m."""
    return degrees(1.0) if rotary else 1e3


def servo(name: str, rotary: bool = False, **nominal: float) -> Drive:
    """Return a servo axis with ``nominal`` values of its parameters (keys of ``UNITS``)."""
    values = {"highest_voltage": VOLTS, "counts_per_turn": COUNTS, **nominal}
    record: Any = namedtuple  # a class of its own, for its own defaults
    defaults = [values[key] for key in UNITS]
    parameters = record(f"Servo{name.upper()}Parameters", UNITS, defaults=defaults)
    for key, (*_, meaning) in UNITS.items():
        getattr(parameters, key).__doc__ = meaning
    per_unit = per_unit_of(rotary)
    unit, load = ("deg", "N m") if rotary else ("mm", "N")

    def coefficients(p: Any) -> ServoCoefficients:
        return _coefficients(per_unit, p)

    def linear(p: Any) -> tuple[float, float]:
        c = coefficients(p)
        return c.gain * c.stiffness * c.velocity_per_volt, c.time_constant

    scale: dict[str, Any] = {"degrees" if rotary else "millimetres": lambda p: 1.0}
    return Drive(
        name=f"servo-{name}",
        parameters=parameters,
        exact=EXACT,
        fault=only_positive(parameters, **dict.fromkeys(MAY_BE_ZERO, NOT_NEGATIVE)),
        units=units_in(unit, "V", load),
        parameter_units={key: units[rotary] for key, units in UNITS.items()},
        meanings={
            "command": "commanded velocity of the servo amplifier",
            "position": "of the slide or table, as the encoder of its motor counts",
        },
        coefficients=coefficients,
        initial_state=lambda zero: ServoState(zero, zero),
        step=step,
        signals=lambda c, x: {"position": x.position, "velocity": x.velocity},
        position="position",
        velocity="velocity",
        encoders={"position": "velocity"},
        accepted=lambda c, volts: jnp.clip(volts, -c.highest_voltage, c.highest_voltage),
        measured=lambda c, x: x._replace(position=c.count * jnp.round(x.position / c.count)),
        top_speed=lambda p: _top_speed(coefficients(p)),
        linear=linear,
        **scale,
    )


def _linear(name: str, mass: float, m_min: float, **nominal: float) -> Drive:
    """Return a slide with a ``mass`` [kg] that the highest voltage moves at ``m_min`` [m/min]."""
    nominal = {"stribeck_velocity": 2.0, "unbalance": 0.0, "travel_per_turn": 10.0, **nominal}
    return servo(name, False, inertia=mass, velocity_per_volt=1e3 * m_min / 60.0 / VOLTS, **nominal)


def _rotary(name: str, inertia: float, deg_min: float, **nominal: float) -> Drive:
    """Return a table with ``inertia`` [kg m2], worm gear 60:1, top speed ``deg_min`` [deg/min]."""
    nominal = {"stribeck_velocity": 0.5, "travel_per_turn": 6.0, **nominal}
    return servo(name, True, inertia=inertia, velocity_per_volt=deg_min / 60.0 / VOLTS, **nominal)


def _braked(viscous: float, coulomb: float, rise: float, gain: float, peak: float) -> Any:
    keys = ("viscous_friction", "coulomb_friction", "stiction_rise", "amplifier_gain", "peak_force")
    return dict(zip(keys, (viscous, coulomb, rise, gain, peak), strict=True))


_DRIVES = {
    "x": _linear("x", 700.0, 30.0, **_braked(800.0, 150.0, 60.0, 1.2e5, 4000.0)),
    "y": _linear("y", 500.0, 40.0, **_braked(700.0, 120.0, 50.0, 1.0e5, 3500.0)),
    "z": _linear("z", 350.0, 40.0, unbalance=30.0, **_braked(600.0, 100.0, 40.0, 7e4, 3000.0)),
    "a": _rotary("a", 12.0, 20e3, unbalance=3.0, **_braked(20.0, 15.0, 6.0, 2400.0, 300.0)),
    "b": _rotary("b", 12.0, 25e3, unbalance=3.0, **_braked(20.0, 15.0, 6.0, 2400.0, 300.0)),
    "c": _rotary("c", 4.0, 30e3, unbalance=0.4, **_braked(5.0, 6.0, 2.5, 800.0, 120.0)),
}


def forces(fixed: Each, states: Each, commands: Each) -> Each:
    """Return gravity and inertia forces between the axes, on X, Y, Z [N], A and C [N m].

    They are added to the loads. X and Y carry the cradle A, which turns about X, and the table C on
    it; Z is vertical. The centre of mass of the cradle lies below its axis where A is 0; that of
    the clamped load lies off the axis of C, towards X where C is 0. Z bears the part of its mass
    that has no counterweight. Neglected are the effect of the tables' acceleration on the slides,
    which is some thousandths of their mass, and the effect of the loads on the slides'
    acceleration.
    """
    (x, y, z, a, c), metre = fixed, 1e-3
    each = enumerate((x, y))
    pulled = [
        once(metre * acceleration(coefficients, states[k], commands[k])) for k, coefficients in each
    ]
    tilt, angle = (jnp.deg2rad(states[k].position) for k in (3, 4))
    # acceleration in the direction that Y has in the tilted table [m/s2]
    across = once(jnp.cos(tilt) * pulled[1] + jnp.sin(tilt) * GRAVITY)
    return (
        0.0 * pulled[0],
        0.0 * pulled[1],
        z.unbalance * GRAVITY + 0.0 * tilt,
        a.unbalance * across,
        once(c.unbalance * (jnp.cos(angle) * across - jnp.sin(angle) * pulled[0])),
    )


FIVE_AXIS = side_by_side("five-axis", **{axis: _DRIVES[axis] for axis in "xyzac"})
FIVE_AXIS_B = side_by_side("five-axis-b", **{axis: _DRIVES[axis] for axis in "xyzbc"})
FIVE_AXIS_COUPLED = coupled(FIVE_AXIS, forces, "five-axis-coupled")
