"""Test whether a loop settles: how much of a disturbed start still oscillates at the end."""

from functools import reduce

import jax.numpy as jnp

from hfc_design.core.numbers import Scalar
from hfc_design.motion.samples import PathFrame
from hfc_design.objectives.metric import Moments, Reduction
from hfc_design.objectives.objective import Sums

#: Largest factor by which growth within the last quarter multiplies the result.
MOST_GROWTH = 10.0
#: Control samples in which a fast oscillation moves about as far as its amplitude.
SWING = 10.0


def unsettled() -> Reduction:
    """Reduce to the final oscillation of a loop relative to a copy with a disturbed start.
    A loop that settles forgets its start: loop and copy end in the same motion, whatever vibration
    a load forces on them. Loops that oscillate by themselves oscillate in different phases. Because
    friction may hold the two at different positions, the metric uses variances within each half of
    the last quarter: of the distance between them, and of its rate times ``SWING`` samples (this is
    an amplitude for an oscillation of that frequency; a faster one counts more). If both variances
    grow from the first half to the second, the smaller growth multiplies the result. (In a steady
    oscillation that is slower than a half, one variance falls whenever the other one grows.)
    """

    def update(sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
        time = SWING * moments[0].sample_time
        # Axes count unequally, as encoders do, so that opposite oscillations do not cancel.
        apart = reduce(jnp.add, [x.apart / (1 + k) for k, x in enumerate(moments)])
        rate = reduce(jnp.add, [time * x.apart_rate / (1 + k) for k, x in enumerate(moments)])
        halves = []
        for half, (count, *each) in enumerate(sums, 1):
            here = jnp.where(moments[0].late == half, 1.0, 0.0)
            more = (apart, apart * apart, rate, rate * rate)
            halves.append((count + here, *(a + here * b for a, b in zip(each, more, strict=True))))
        return tuple(halves)

    def variances(sums: Sums) -> tuple[Scalar, Scalar]:
        """Return the variances of the distance and of the rate in a half."""
        count, *each = sums
        mean, square, mean_rate, square_rate = (one / jnp.maximum(count, 1.0) for one in each)
        estimates = square - mean * mean, square_rate - mean_rate * mean_rate
        return jnp.maximum(estimates[0], 0.0), jnp.maximum(estimates[1], 0.0)

    def growth(before: Scalar, after: Scalar) -> Scalar:
        least = after / MOST_GROWTH**2 + jnp.finfo(jnp.float32).tiny
        return after / jnp.maximum(before, least)

    def value(sums: Sums) -> Scalar:
        before, after = map(variances, sums)
        grown = jnp.minimum(*map(growth, before, after))
        return jnp.sqrt((after[0] + after[1]) * jnp.maximum(grown, 1.0))

    def empty(zero: Scalar) -> Sums:
        return (zero,) * 5, (zero,) * 5

    return Reduction(empty, update, value)
