"""LuGre dynamic friction (Canudas de Wit et al. 1995; Lin & Lee 1999, eq. 1e-1g)."""

from typing import Any, NamedTuple

import jax.numpy as jnp

from plants.scalar import decay, ratio


class LuGre(NamedTuple):
    """Friction between two bodies as the bending of bristles."""

    bristle_stiffness: Any  # sigma_0 [N m/rad]
    bristle_damping: Any  # sigma_1 [N m s/rad]
    viscous: Any  # sigma_2 [N m s/rad]
    coulomb: Any  # T_c [N m]
    stribeck_rise: Any  # T_s - T_c [N m]
    inverse_stribeck_velocity: Any  # 1 / omega_s [s/rad]


def bristle_rate(friction: LuGre, velocity: Any, deflection: Any) -> Any:
    """Rate dz/dt [rad/s] of the bristle deflection z [rad] (eq. 1f, 1g).

    The equation is stiff in proportion to ``|velocity| / g``: a drive that runs away makes a
    fixed step diverge, which is a result to be scored and not an error.
    """
    relative = velocity * friction.inverse_stribeck_velocity
    steady_torque = friction.coulomb + friction.stribeck_rise * decay(-(relative * relative))
    bent = jnp.abs(velocity) * (friction.bristle_stiffness * deflection)
    return velocity - ratio(bent, steady_torque)


def friction_torque(friction: LuGre, velocity: Any, deflection: Any, rate: Any) -> Any:
    """Friction torque [N m] (eq. 1e); ``rate`` is ``bristle_rate`` of the same state."""
    return (
        friction.bristle_stiffness * deflection
        + friction.bristle_damping * rate
        + friction.viscous * velocity
    )
