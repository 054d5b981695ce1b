"""The exponential of a number that is not positive, fast in float32.

Six of ten operations of a control step are exponentials of memberships and of the Stribeck
curve. Their arguments are never positive, so the library's range checks are of no use here, and
without them the step runs about 1.4 times as fast.
"""

import jax
import jax.numpy as jnp
from jax import lax

LOG2_E = 1.4426950408889634
#: Below this exponent of two a float32 is no longer a normal number.
SMALLEST_EXPONENT = -126.0
#: 1.5 * 2**23: adding it to a small float32 leaves the nearest integer in the low bits.
TO_INTEGER = 12582912.0
#: Degree-5 polynomial of 2**r, |r| <= 1/2, constant term first, exact at 0: error 6.8e-8.
EXP2 = (1.0, 0.693146596, 0.24022166, 0.0555104738, 0.00967495193, 0.00132029823)


def decay(x: jax.Array) -> jax.Array:
    """``exp(x)`` for ``x <= 0``, elementwise.

    In float64 the library's exponential. In float32 the relative error is below 6e-7 for
    x >= -10 and grows with the rounding of ``x * log2(e)`` to 4e-6 at x = -87; where the result
    would no longer be a normal number it is 0. A nan stays one only in float64: the float32 loop
    shows a diverged individual by its state.
    """
    return _decay32(x) if x.dtype == jnp.float32 else jnp.exp(x)


@jax.custom_jvp
def _decay32(x: jax.Array) -> jax.Array:
    exponent = x * jnp.float32(LOG2_E)
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
    value = lax.bitcast_convert_type(bits + scale, jnp.float32)
    return jnp.where(exponent > SMALLEST_EXPONENT, value, jnp.float32(0.0))


@_decay32.defjvp
def _decay32_jvp(
    primals: tuple[jax.Array], tangents: tuple[jax.Array]
) -> tuple[jax.Array, jax.Array]:
    value = _decay32(*primals)
    return value, value * tangents[0]


@jax.custom_jvp
def ratio(numerator: jax.Array, denominator: jax.Array) -> jax.Array:
    """``numerator / denominator``, with a derivative that also ends in one division.

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
