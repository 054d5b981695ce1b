"""Building blocks of drives: a fast bell and a fast division, an integrator, friction.

Six of ten operations of a control step are exponentials of memberships and of the Stribeck
curve. Their arguments are never positive, so the library's range checks are of no use here, and
without them the step runs about 1.4 times as fast.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple, TypeVar

import jax
import jax.numpy as jnp
from jax import lax

from plants.drive import Loads, Scalar

State = TypeVar("State", bound=tuple[Scalar, ...])

LOG2_E = 1.4426950408889634
#: 2 to this exponent is 0 where the bits of a float32 are put together as below.
LOWEST_EXPONENT = -127.0
#: 1.5 * 2**23: adding it to a small float32 leaves the nearest integer in the low bits.
TO_INTEGER = 12582912.0
#: Degree-5 polynomial of 2**r, |r| <= 1/2, constant term first, exact at 0: error 6.8e-8.
EXP2 = (1.0, 0.693146596, 0.24022166, 0.0555104738, 0.00967495193, 0.00132029823)


def bell(rate: float, distance: jax.Array) -> jax.Array:
    """Return ``exp(-rate * distance**2)``, elementwise, for a positive ``rate``.

    In float64 the library's exponential is used. In float32 the relative error is below 1.1e-6 down
    to exp(-10) and grows with the rounding of the exponent to 8e-6 at exp(-87); results below the
    normal numbers are 0 or that small. A nan is kept only in float64: the float32 loop shows a
    diverged individual by its state.
    """
    if distance.dtype == jnp.float32:
        return _bell32(rate, distance)
    return jnp.exp((-rate * distance) * distance)


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def _bell32(rate: float, distance: jax.Array) -> jax.Array:
    exponent = (jnp.float32(-rate * LOG2_E) * distance) * distance
    # One instruction, unlike a selection of the result. Lower exponents, and a nan, end in 0.
    exponent = jnp.where(exponent > LOWEST_EXPONENT, exponent, LOWEST_EXPONENT)
    # The barrier keeps the compiler from simplifying (x + c) - c to x.
    shift = lax.optimization_barrier(jnp.float32(TO_INTEGER))
    shifted = exponent + shift
    remainder = exponent - (shifted - shift)
    power = jnp.float32(EXP2[-1])
    for coefficient in EXP2[-2::-1]:
        power = power * remainder + jnp.float32(coefficient)
    # Adding the integer to the exponent bits multiplies by 2**integer.
    bits = lax.bitcast_convert_type(power, jnp.int32)
    scale = lax.bitcast_convert_type(shifted, jnp.int32) << 23
    return lax.bitcast_convert_type(bits + scale, jnp.float32)


@_bell32.defjvp
def _bell32_jvp(
    rate: float, primals: tuple[jax.Array], tangents: tuple[jax.Array]
) -> tuple[jax.Array, jax.Array]:
    (distance,), (change,) = primals, tangents
    value = _bell32(rate, distance)
    return value, value * (-2.0 * rate * distance) * change


@jax.custom_jvp
def ratio(numerator: jax.Array, denominator: jax.Array) -> jax.Array:
    """Return ``numerator / denominator``, with a derivative that also ends in one division.

    The compiler computes a division once and repeats cheap operations in everything that uses
    them, so a division is where the pieces of a step are cut apart. Without this the derivative
    of a control step compiles to code that is thirty times as slow.
    """
    return numerator / denominator


@ratio.defjvp
def _ratio_jvp(
    primals: tuple[jax.Array, jax.Array], tangents: tuple[jax.Array, jax.Array]
) -> tuple[jax.Array, jax.Array]:
    numerator, denominator = primals
    change, denominator_change = tangents
    value = ratio(numerator, denominator)
    return value, (change - value * denominator_change) / denominator


@jax.custom_jvp
def once(x: jax.Array) -> jax.Array:
    """Return a finite ``x`` that is computed once: XLA repeats cheap operations for each use.

    XLA does not repeat a division, and may not drop the one here, because 0 x need not be 0. With
    ``once`` an adaptive step runs eight times as fast and compiles in half the time.
    """
    return x / (1.0 + 0.0 * x)


@once.defjvp
def _once_jvp(primals: tuple[jax.Array], tangents: tuple[jax.Array]) -> tuple[jax.Array, jax.Array]:
    return once(*primals), once(*tangents)


def smaller(x: Scalar, bound: Scalar) -> jax.Array:
    """Return ``min(x, bound)`` in one instruction; a nan in ``x`` stays nan, as in Python."""
    return jnp.where(bound < x, bound, x)


def larger(x: Scalar, bound: Scalar) -> jax.Array:
    """Return ``max(x, bound)`` in one instruction; a nan in ``x`` stays nan, as in Python."""
    return jnp.where(bound > x, bound, x)


def counted(position: Scalar, resolution: Scalar) -> jax.Array:
    """Return a position in whole counts of an encoder; for a resolution of 0 the exact position."""
    ideal = resolution == 0.0
    step = jnp.where(ideal, 1.0, resolution)
    return jnp.where(ideal, position, step * jnp.round(position / step))


def pick(values: Mapping[int, jax.Array], index: jax.Array) -> jax.Array:
    """Return ``values[index]`` for a traced index: a chain of selections, not a gather."""
    (_, result), *others = values.items()
    for k, value in others:
        result = jnp.where(index == k, value, result)
    return result


def rk4(
    derivative: Callable[[State, Scalar], State], state: State, loads: Loads, dt: Scalar
) -> State:
    """Return the state after one classical fourth-order Runge-Kutta step of length ``dt`` [s].

    ``derivative(state, load)`` returns the rates in a record of the same type; ``loads`` are
    the load at the start, the middle and the end of the step. The state is a NamedTuple of
    scalars, so that the compiler sees one flat expression.
    """

    def moved(rates: State, time: Scalar) -> State:
        return type(state)(*(x + time * rate for x, rate in zip(state, rates, strict=True)))

    start, middle, end = loads
    k1 = derivative(state, start)
    k2 = derivative(moved(k1, 0.5 * dt), middle)
    k3 = derivative(moved(k2, 0.5 * dt), middle)
    k4 = derivative(moved(k3, dt), end)
    total = (a + 2.0 * b + 2.0 * c + d for a, b, c, d in zip(k1, k2, k3, k4, strict=True))
    return moved(type(state)(*total), dt / 6.0)


#: Largest decay in a step for which the explicit method is used; it is stable to 2.785.
STIFF = 1.5


def rk4_tr_bdf2(
    derivative: Callable[[State, Scalar, Scalar], State],
    state: State,
    loads: Loads,
    dt: Scalar,
    field: str,
    decay_rate: Callable[[State], Scalar],
) -> State:
    """Return the state after one step of ``rk4``, implicit in one ``field`` where that decays fast.

    ``derivative(state, load, implicit)`` returns the rates of the state in which ``field`` is that
    of ``state`` plus ``implicit`` [s] times the rate of ``field``; a division solves that.
    ``decay_rate(state)`` [1/s] is how fast the field decays, or an upper bound of that. Where it
    decays fast, at the start or at the speed that the step approaches, the field is integrated by
    the trapezoidal rule to the middle of the step and by the second backward difference to the end
    (TR-BDF2, Bank et al. 1985; L-stable), with the stages of the other fields. Elsewhere the whole
    step is that of ``rk4``.
    """

    def moved(rates: State, time: Scalar) -> State:
        return type(state)(*(x + time * rate for x, rate in zip(state, rates, strict=True)))

    def with_field(stage: Any, value: Scalar) -> State:
        explicit = getattr(stage, field)
        new_stage: State = stage._replace(**{field: jnp.where(stiff, value, explicit)})
        return new_stage

    start, middle, end = loads
    k1 = derivative(state, start, 0.0)
    stiff = dt * larger(decay_rate(state), decay_rate(moved(k1, dt))) > STIFF
    before, first = getattr(state, field), getattr(k1, field)
    quarter = once(jnp.where(stiff, dt / 4.0, 0.0))
    stiff, third = quarter > 0.0, 4.0 / 3.0 * quarter
    k2 = derivative(with_field(moved(k1, 0.5 * dt), before + 0.25 * dt * first), middle, quarter)
    k3 = derivative(with_field(moved(k2, 0.5 * dt), before + 0.25 * dt * first), middle, quarter)
    both = first + getattr(k3, field)
    k4 = derivative(with_field(moved(k3, dt), before + dt / 3.0 * both), end, third)
    total = (a + 2.0 * b + 2.0 * c + d for a, b, c, d in zip(k1, k2, k3, k4, strict=True))
    new = moved(type(state)(*total), dt / 6.0)
    return with_field(new, before + dt / 3.0 * (both + getattr(k4, field)))


class LuGre(NamedTuple):
    """Dynamic friction between two bodies as the bending of bristles.

    Canudas de Wit et al. 1995; Lin & Lee 1999, eq. 1e-1g.
    """

    bristle_stiffness: Scalar  # sigma_0 [N m/rad]
    bristle_damping: Scalar  # sigma_1 [N m s/rad]
    viscous: Scalar  # sigma_2 [N m s/rad]
    coulomb: Scalar  # T_c [N m]
    stribeck_rise: Scalar  # T_s - T_c [N m]
    inverse_stribeck_velocity: Scalar  # 1 / omega_s [s/rad]


def bristle(
    friction: LuGre, velocity: Scalar, known: Scalar, implicit: Scalar = 0.0
) -> tuple[Scalar, Scalar]:
    """Return the bristle deflection, known + implicit dz/dt [rad], and dz/dt [rad/s] (eq. 1f, 1g).

    The equation is stiff in proportion to ``|velocity| / g``: with ``rk4`` a drive that runs away
    makes a fixed step diverge; ``rk4_tr_bdf2`` follows it.
    """
    stiffness = jnp.abs(velocity) * friction.bristle_stiffness
    explicit = known + implicit * velocity
    relaxed = ratio(stiffness * explicit, steady_torque(friction, velocity) + implicit * stiffness)
    # Not known + implicit * rate: the compiler makes code of that which is a third slower.
    return explicit - implicit * relaxed, velocity - relaxed


def steady_torque(friction: LuGre, velocity: Scalar) -> Scalar:
    """Return the magnitude of the steady sliding torque, without viscous part [N m]: sigma_0 g."""
    relative = velocity * friction.inverse_stribeck_velocity
    return friction.coulomb + friction.stribeck_rise * bell(1.0, relative)


def friction_torque(friction: LuGre, velocity: Scalar, deflection: Scalar, rate: Scalar) -> Scalar:
    """Return the friction torque [N m] (eq. 1e); ``deflection`` and ``rate``: see ``bristle``."""
    return (
        friction.bristle_stiffness * deflection
        + friction.bristle_damping * rate
        + friction.viscous * velocity
    )
