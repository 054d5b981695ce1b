"""LuGre dynamic friction (Canudas de Wit et al. 1995; Lin & Lee 1999, eq. 1e-1g)."""

from typing import NamedTuple

import jax.numpy as jnp

from plants.drive import Scalar
from plants.scalar import decay, ratio


class LuGre(NamedTuple):
    """Friction between two bodies as the bending of bristles."""

    bristle_stiffness: Scalar  # sigma_0 [N m/rad]
    bristle_damping: Scalar  # sigma_1 [N m s/rad]
    viscous: Scalar  # sigma_2 [N m s/rad]
    coulomb: Scalar  # T_c [N m]
    stribeck_rise: Scalar  # T_s - T_c [N m]
    inverse_stribeck_velocity: Scalar  # 1 / omega_s [s/rad]


def bristle_rate(friction: LuGre, velocity: Scalar, deflection: Scalar) -> Scalar:
    """Rate dz/dt [rad/s] of the bristle deflection z [rad] (eq. 1f, 1g).

    The equation is stiff in proportion to ``|velocity| / g``: a drive that runs away makes a
    fixed step diverge, which is a result to be scored and not an error.
    """
    relative = velocity * friction.inverse_stribeck_velocity
    steady_torque = friction.coulomb + friction.stribeck_rise * decay(-(relative * relative))
    bent = jnp.abs(velocity) * (friction.bristle_stiffness * deflection)
    return velocity - ratio(bent, steady_torque)


def friction_torque(friction: LuGre, velocity: Scalar, deflection: Scalar, rate: Scalar) -> Scalar:
    """Friction torque [N m] (eq. 1e); ``rate`` is ``bristle_rate`` of the same state."""
    return (
        friction.bristle_stiffness * deflection
        + friction.bristle_damping * rate
        + friction.viscous * velocity
    )
