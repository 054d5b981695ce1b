"""Simulation of a population that stops individuals that can no longer reach the needed merit.

The motion is cut into segments. After each, the best merit that an individual can still reach is
known from its sums. Individuals that cannot reach the needed merit (*lost* ones) are moved behind
the others, and the next segment simulates only the chunks that contain others. This is one compiled
program; individuals that are not lost have exactly the results as without early stopping.
"""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array, PyTree

from hfc_design.core.numbers import Integers
from hfc_design.objectives.objective import Remaining
from hfc_design.simulation.closed_loop import Loop
from hfc_design.simulation.stepping import Inputs, judged, stepping, trailing

#: Ends of the segments, as shares of the motion: close at first, as most are lost early.
SHARES = (0.01, 0.02, 0.035, 0.055, 0.08, 0.11, 0.15, 0.2, 0.27, 0.36, 0.48, 0.64, 0.82, 1.0)


def bounds(steps: int) -> Integers:
    """Return the boundaries (segments + 1,) of the segments of a motion with ``steps`` samples."""
    ends = np.maximum(np.round(np.array(SHARES) * steps).astype(int), 1)
    return np.append(0, ends)


def each(loop: Loop, inputs: Inputs, chunk: int) -> Array:
    """Return merit, failure (1: failed), simulated samples, and values, (3 + values, individuals).

    The merit of a lost individual is the best that it could still have reached, which is less than
    it needs. ``chunk`` individuals are simulated together; their number is a multiple of ``chunk``.
    """
    samples, count = inputs.samples, trailing(inputs.gains)
    needed = jnp.asarray(inputs.needed)
    _, rows, started = stepping(loop, False, inputs)
    ends = jnp.asarray(inputs.bounds)
    steps = ends[-1]
    counted = jnp.concatenate([jnp.zeros(1, samples.settled.dtype), jnp.cumsum(samples.settled)])

    def segment(k: Array, state: Any) -> Any:
        carry, order, alive, lost, best, simulated = state
        begin, end = ends[k], ends[k + 1]

        def step(number: Array, chunk_state: tuple[PyTree, Array]) -> tuple[PyTree, Array]:
            carry, simulated = chunk_state
            lanes = lax.dynamic_slice(order, (number * chunk,), (chunk,))
            gains = _taken(inputs.gains, lanes)
            body, _, _ = stepping(loop, False, inputs._replace(gains=gains))

            def at(k: Array, carry: PyTree) -> PyTree:
                return body(carry, jax.tree.map(lambda leaf: leaf[k], rows))[0]

            after = lax.fori_loop(begin, end, at, _taken(carry, lanes))
            put = jax.tree.map(lambda leaf, values: leaf.at[..., lanes].set(values), carry, after)
            return put, simulated.at[lanes].add((end - begin).astype(jnp.int32))

        chunks = (alive + chunk - 1) // chunk
        carry, simulated = lax.fori_loop(0, chunks, step, (carry, simulated))
        left = Remaining(steps - end, counted[steps] - counted[end])
        upper_bound = loop.judge.best(carry[1].sums, left)
        # An individual whose bound is not a number is lost too, and has failed.
        now = ~lost & (end < steps) & ~(upper_bound >= needed)
        best = jnp.where(now, upper_bound, best)
        lost = lost | now
        order = jnp.argsort(lost, stable=True).astype(order.dtype)
        return carry, order, jnp.sum(~lost, dtype=alive.dtype), lost, best, simulated

    here, copy_start = jax.tree.map(lambda leaf: leaf[0], (samples.start, samples.copy_start))
    start = (
        started(here, copy_start),
        jnp.arange(count, dtype=jnp.int32),
        jnp.int32(count),
        jnp.zeros(count, bool),
        jnp.full(count, jnp.inf, samples.settled.dtype),
        jnp.zeros(count, jnp.int32),
    )
    carry, _, _, lost, best, simulated = lax.fori_loop(0, len(SHARES), segment, start)
    scores = judged(loop, carry)
    merit = jnp.where(lost, best, scores.merit)
    failed = jnp.where(lost, ~jnp.isfinite(best), scores.failed)
    return jnp.stack([merit, failed, simulated.astype(merit.dtype), *scores.values.T])


def _taken(tree: PyTree, lanes: Array) -> PyTree:
    return jax.tree.map(lambda leaf: leaf[..., lanes], tree)
