"""Positioning stage: one mass on a screw behind an amplifier, with direction-dependent friction.

The electro-mechanical positioning system of A. Janot, M. Gautier and M. Brunot ("Data set and
reference models of EMPS", Nonlinear System Identification Benchmarks, 2019), cited as EMPS; its
values are the defaults. With the acceleration a, the voltage u and the velocity v::

    mass a = amplifier_gain u - viscous_friction v - coulomb_friction sign(v) - offset - load

The offset is a permanent force, of the amplifier or of a slope. In motion it has the same effect as
Coulomb friction that is larger forwards and smaller backwards by the offset. At rest the stage
stays where it is while the force minus the offset does not exceed the break-away force.
"""

from functools import partial
from typing import Annotated, NamedTuple

import jax.numpy as jnp

from plants.blocks import counted
from plants.drive import NOT_NEGATIVE, Drive, Loads, Scalar, only_positive, units_in
from plants.sliding import Slide, slid


class PositioningStageParameters(NamedTuple):
    """Physical parameters; the defaults are those of EMPS."""

    mass: Annotated[float, "kg"] = 95.11  # moving mass, as seen by the force
    viscous_friction: Annotated[float, "N s/m"] = 203.5  # the mean of both directions
    #: relative increase forwards, and decrease backwards
    viscous_asymmetry: Annotated[float, "1"] = 0.0
    coulomb_friction: Annotated[float, "N"] = 20.39  # the mean of both directions
    offset: Annotated[float, "N"] = -3.16  # constant force, positive pulls back
    stiction_rise: Annotated[float, "N"] = 0.0  # break-away force less the Coulomb friction
    amplifier_gain: Annotated[float, "N/V"] = 35.1507  # of amplifier, motor and screw
    #: 0: ideal, or that of the sensors; set one of them
    encoder_resolution: Annotated[float, "mm"] = 0.0
    highest_voltage: Annotated[float, "V"] = 10.0  # of either sign


class PositioningStageState(NamedTuple):
    """State of the stage; every field a scalar."""

    position: Scalar  # [mm]
    velocity: Scalar  # [mm/s]


class PositioningStageCoefficients(NamedTuple):
    """Quantities that a step needs, computed once; forces are given as the voltage for them."""

    gain: Scalar  # velocity over voltage [(mm/s)/V]
    time_constant: Scalar  # [s]
    coulomb: Scalar  # [V]
    slope: Scalar  # viscous friction forwards less that in the mean of both directions [V/(mm/s)]
    offset: Scalar  # [V]
    stiction_rise: Scalar  # [V]
    volt: Scalar  # force of a volt [N/V]
    encoder_resolution: Scalar  # [mm]
    highest_voltage: Scalar  # [V]


def coefficients(p: PositioningStageParameters) -> PositioningStageCoefficients:
    """Return the stage as ``tau dv/dt = K (u - offset - load - friction) - v``, in V, mm and s."""
    volt = p.amplifier_gain
    return PositioningStageCoefficients(
        gain=1e3 * volt / p.viscous_friction,
        time_constant=p.mass / p.viscous_friction,
        coulomb=p.coulomb_friction / volt,
        slope=1e-3 * p.viscous_asymmetry * p.viscous_friction / volt,
        offset=p.offset / volt,
        stiction_rise=p.stiction_rise / volt,
        volt=volt,
        encoder_resolution=p.encoder_resolution,
        highest_voltage=p.highest_voltage,
    )


def friction(c: PositioningStageCoefficients, direction: Scalar, speed: Scalar) -> Scalar:
    """Return friction at ``speed`` [mm/s] in ``direction``, less mean viscous friction [V]."""
    return c.coulomb + jnp.where(direction > 0, c.slope, -c.slope) * speed


def step(
    c: PositioningStageCoefficients,
    x: PositioningStageState,
    voltage: Scalar,
    loads: Loads,
    dt: Scalar,
) -> PositioningStageState:
    """Return the state ``dt`` [s] later under constant ``voltage`` [V] and ``loads`` [N].

    It is exact for constant loads and equal viscous friction in both directions, else of 2nd order.
    """
    start, middle, end = loads
    load = (start + 4.0 * middle + end) / 6.0 / c.volt
    slide = Slide(c.gain, c.time_constant, partial(friction, c), c.stiction_rise)
    return slid(slide, x, voltage - c.offset - load, dt)


def accepted(c: PositioningStageCoefficients, command: Scalar) -> Scalar:
    """Return the voltage that the amplifier accepts [V]."""
    return jnp.clip(command, -c.highest_voltage, c.highest_voltage)


def measured(c: PositioningStageCoefficients, x: PositioningStageState) -> PositioningStageState:
    """Return the state with the position that the encoder reads."""
    return x._replace(position=counted(x.position, c.encoder_resolution))


def top_speed(p: PositioningStageParameters) -> float:
    """Return the speed [mm/s] that the highest voltage holds in the slower direction.

    All friction is taken into account.
    """
    force = p.amplifier_gain * p.highest_voltage - p.coulomb_friction
    forwards = (force - p.offset) / (1.0 + p.viscous_asymmetry)
    backwards = (force + p.offset) / (1.0 - p.viscous_asymmetry)
    return 1e3 * max(min(forwards, backwards), 0.0) / p.viscous_friction


POSITIONING_STAGE = Drive(
    name="positioning-stage",
    parameters=PositioningStageParameters,
    exact=frozenset({"encoder_resolution", "highest_voltage"}),
    fault=only_positive(
        PositioningStageParameters,
        **dict.fromkeys(("coulomb_friction", "stiction_rise", "encoder_resolution"), NOT_NEGATIVE),
        viscous_asymmetry=(lambda value: -1 < value < 1, "between -1 and 1"),
        offset=(lambda value: True, "any number"),
    ),
    units=units_in("mm", "V", "N"),
    meanings={
        "command": "voltage to the amplifier, positive moves the stage forwards",
        "position": "of the stage, by the encoder of its motor",
    },
    coefficients=coefficients,
    initial_state=lambda zero: PositioningStageState(zero, zero),
    step=step,
    signals=lambda c, x: {"position": x.position, "velocity": x.velocity},
    position="position",
    velocity="velocity",
    encoders={"position": "velocity"},
    accepted=accepted,
    measured=measured,
    resolutions={"position": "encoder_resolution"},
    millimetres=lambda p: 1.0,
    top_speed=top_speed,
    linear=lambda p: (1e3 * p.amplifier_gain / p.viscous_friction, p.mass / p.viscous_friction),
)
