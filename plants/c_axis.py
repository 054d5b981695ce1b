"""The C-axis of a CNC turning centre (Lin & Lee 1999, cited as LL, eq. 1-2).

A vector-controlled induction motor turns the spindle through a flexible transmission against
LuGre friction and the load torque of the cut. The command is the quadrature stator voltage.
"""

from typing import Annotated, NamedTuple

import jax.numpy as jnp

from plants.blocks import LuGre, bristle, friction_torque, once, rk4_tr_bdf2
from plants.drive import NOT_NEGATIVE, Drive, Loads, Scalar, only_positive


class CAxisParameters(NamedTuple):
    """Physical parameters; the defaults are the machine of LL section 4.

    The paper does not print the number of poles of the motor. With the published Table I the
    linearised loop is stable only for 2 (eigenvalues -4.6 +/- 20.8j; +3.5 +/- 29.5j for 4). Table
    II also works with 4: under the cutting load its fitness is 95.6, and the axis never sticks.
    """

    poles: Annotated[float, "1"] = 2.0  # of the motor, P
    rotor_flux: Annotated[float, "Wb"] = 0.6  # of the motor, lambda_r
    stator_resistance: Annotated[float, "ohm"] = 1.12  # of a winding, R_s
    rotor_resistance: Annotated[float, "ohm"] = 1.05  # of a winding, R_r
    stator_inductance: Annotated[float, "H"] = 0.341  # of a winding, L_s
    rotor_inductance: Annotated[float, "H"] = 0.306  # of a winding, L_r
    mutual_inductance: Annotated[float, "H"] = 0.225  # between stator and rotor, L_m
    rotor_inertia: Annotated[float, "kg m2"] = 0.11  # of the motor, J_r
    rotor_damping: Annotated[float, "N m s/rad"] = 2.05  # of the motor, b_r
    spindle_inertia: Annotated[float, "kg m2"] = 5.102  # of spindle and workpiece, J_c
    gear_ratio: Annotated[float, "1"] = 1.0  # motor angle over spindle angle, N
    #: of the transmission, referred to the motor, k
    stiffness: Annotated[float, "N m/rad"] = 200.0
    bristle_stiffness: Annotated[float, "N m/rad"] = 17000.0  # of the LuGre friction, sigma_0
    bristle_damping: Annotated[float, "N m s/rad"] = 126.5  # of the LuGre friction, sigma_1
    viscous_friction: Annotated[float, "N m s/rad"] = 0.4  # of the spindle, sigma_2
    coulomb_torque: Annotated[float, "N m"] = 0.7  # of friction at speed, T_c
    static_torque: Annotated[float, "N m"] = 1.2  # of friction at rest, T_s
    #: speed at which the rise to T_s has fallen to 1/e, omega_s
    stribeck_velocity: Annotated[float, "rad/s"] = 0.003


class CAxisState(NamedTuple):
    """State x of LL eq. 2; every field a scalar."""

    current: Scalar  # i_qs [A]
    rotor_angle: Scalar  # theta_r [rad]
    rotor_velocity: Scalar  # omega_r [rad/s]
    spindle_angle: Scalar  # theta_c [rad]
    spindle_velocity: Scalar  # omega_c [rad/s]
    bristle_deflection: Scalar  # z [rad]


class CAxisCoefficients(NamedTuple):
    """Quantities that a step needs of the parameters, computed once (LL eq. 1c, 1d)."""

    current_decay: Scalar  # R_sigma / L_sigma [1/s]
    back_emf: Scalar  # L_s lambda_r / (L_sigma L_m) [A/rad]
    inverse_inductance: Scalar  # 1 / L_sigma [1/H]
    torque_constant: Scalar  # K_t = (P/2) L_m lambda_r / L_r [N m/A]
    inverse_rotor_inertia: Scalar
    inverse_spindle_inertia: Scalar
    rotor_damping: Scalar
    stiffness: Scalar
    gear_ratio: Scalar
    largest_decay: Scalar  # sigma_0 / T_c [1/rad]: of the bristles, over the angle of the spindle
    friction: LuGre


def coefficients(p: CAxisParameters) -> CAxisCoefficients:
    """Coefficients of LL eq. 2 with L_sigma = L_s - L_m^2/L_r, R_sigma = R_s + R_r L_s/L_r."""
    leakage = p.stator_inductance - p.mutual_inductance**2 / p.rotor_inductance
    resistance = p.stator_resistance + p.rotor_resistance * p.stator_inductance / p.rotor_inductance
    return CAxisCoefficients(
        current_decay=resistance / leakage,
        back_emf=p.stator_inductance * p.rotor_flux / (leakage * p.mutual_inductance),
        inverse_inductance=1.0 / leakage,
        torque_constant=0.5 * p.poles * p.mutual_inductance * p.rotor_flux / p.rotor_inductance,
        inverse_rotor_inertia=1.0 / p.rotor_inertia,
        inverse_spindle_inertia=1.0 / p.spindle_inertia,
        rotor_damping=p.rotor_damping,
        stiffness=p.stiffness,
        gear_ratio=p.gear_ratio,
        largest_decay=p.bristle_stiffness / p.coulomb_torque,
        friction=LuGre(
            p.bristle_stiffness,
            p.bristle_damping,
            p.viscous_friction,
            p.coulomb_torque,
            p.static_torque - p.coulomb_torque,
            1.0 / p.stribeck_velocity,
        ),
    )


def derivative(
    c: CAxisCoefficients, x: CAxisState, voltage: Scalar, load: Scalar, implicit: Scalar = 0.0
) -> CAxisState:
    """Return the rates of the state (LL eq. 2) for ``voltage`` [V] and load torque ``load`` [N m].

    The bristle deflection is that of ``x`` plus ``implicit`` [s] times the rate of the deflection.
    """
    spring = c.stiffness * (x.rotor_angle - c.gear_ratio * x.spindle_angle)
    bent, rate = bristle(c.friction, x.spindle_velocity, x.bristle_deflection, implicit)
    friction = friction_torque(c.friction, x.spindle_velocity, bent, rate)
    braking = friction + load
    current = (
        c.inverse_inductance * voltage - c.current_decay * x.current - c.back_emf * x.rotor_velocity
    )
    turning = c.torque_constant * x.current - spring - c.rotor_damping * x.rotor_velocity
    return CAxisState(
        current=once(current),
        rotor_angle=x.rotor_velocity,
        rotor_velocity=once(c.inverse_rotor_inertia * turning),
        spindle_angle=x.spindle_velocity,
        spindle_velocity=once(c.inverse_spindle_inertia * (c.gear_ratio * spring - braking)),
        bristle_deflection=rate,
    )


def step(
    c: CAxisCoefficients, x: CAxisState, voltage: Scalar, loads: Loads, dt: Scalar
) -> CAxisState:
    """Return the state ``dt`` [s] later under a constant voltage [V], see ``rk4_tr_bdf2``."""
    return rk4_tr_bdf2(
        lambda state, load, implicit: derivative(c, state, voltage, load, implicit),
        x,
        loads,
        dt,
        "bristle_deflection",
        lambda state: c.largest_decay * jnp.abs(state.spindle_velocity),
    )


def signals(c: CAxisCoefficients, x: CAxisState) -> dict[str, Scalar]:
    """Return the signals of the drive that a controller can read beside the tracking error."""
    return {
        "deflection": x.rotor_angle - c.gear_ratio * x.spindle_angle,  # delta [rad]
        "deflection_rate": x.rotor_velocity - c.gear_ratio * x.spindle_velocity,  # [rad/s]
        "spindle_velocity": x.spindle_velocity,  # omega_c [rad/s]
        "rotor_velocity": x.rotor_velocity,  # omega_r [rad/s]
        "current": x.current,  # i_qs [A]
    }


MAY_BE_ZERO = ("rotor_damping", "bristle_damping", "viscous_friction")
_sign_fault = only_positive(CAxisParameters, **dict.fromkeys(MAY_BE_ZERO, NOT_NEGATIVE))


def fault(changes: dict[str, float]) -> str | None:
    """Return what makes the nominal machine with ``changes`` impossible, or None."""
    if sign_fault := _sign_fault(changes):
        return sign_fault
    p = CAxisParameters(**changes)
    if p.stator_inductance * p.rotor_inductance <= p.mutual_inductance**2:
        return (
            f"parameters.mutual_inductance = {p.mutual_inductance}: its square must be "
            "less than stator_inductance * rotor_inductance"
        )
    if p.static_torque < p.coulomb_torque:
        return (
            f"parameters.static_torque = {p.static_torque}: must be at least "
            f"coulomb_torque = {p.coulomb_torque}"
        )
    return None


C_AXIS = Drive(
    name="c-axis",
    parameters=CAxisParameters,
    exact=frozenset({"poles", "gear_ratio"}),
    fault=fault,
    units={
        "error": "rad",
        "error_rate": "rad/s",
        "command": "V",
        "load": "N m",
        "deflection": "rad",
        "deflection_rate": "rad/s",
        "spindle_velocity": "rad/s",
        "rotor_velocity": "rad/s",
        "current": "A",
    },
    state_units={"rotor_angle": "rad", "bristle_deflection": "rad"},
    meanings={
        "command": "quadrature stator voltage, positive turns the rotor forwards",
        "deflection": "of the transmission: rotor angle less gear_ratio times spindle angle",
        "deflection_rate": "rotor velocity less gear_ratio times spindle velocity",
        "spindle_velocity": "of the spindle, whose angle follows the reference",
        "rotor_velocity": "of the motor before the transmission, forwards as the spindle",
        "current": "quadrature stator current, positive turns the rotor forwards",
    },
    coefficients=coefficients,
    initial_state=lambda zero: CAxisState(zero, zero, zero, zero, zero, zero),
    step=step,
    signals=signals,
    position="spindle_angle",
    velocity="spindle_velocity",
    encoders={"rotor_angle": "rotor_velocity", "spindle_angle": "spindle_velocity"},
)
