"""Derivatives of a motion's merit with respect to every sample: weights of errors in a polish."""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array, Float

from hfc_design.core.numbers import Scalar
from hfc_design.motion.samples import Samples
from hfc_design.objectives.objective import Moment, Sums
from hfc_design.simulation.closed_loop import Loop
from hfc_design.simulation.flattening import Code, joined, separate

Steps = Float[Array | np.ndarray, " steps"]


class Traces(NamedTuple):
    """A motion of a machine of one axis as objectives see it, in the units of its drive."""

    error: Steps
    error_rate: Steps
    command: Steps
    command_change: Steps  # since the sample before; before the first one the command was 0


#: Fields of ``Traces`` that a simulation records.
RECORDED = "error", "error_rate", "command"


def motion_slopes(loop: Loop, samples: Samples, traces: Traces) -> tuple[float, Traces]:
    """Return the merit of a motion and its derivative by every number of ``traces``, in float64.

    The derivative of a quantity that jumps, such as a share of time, is 0.
    """
    with jax.enable_x64(True):
        samples, traces = jax.tree.map(partial(np.asarray, dtype=np.float64), (samples, traces))
        code, numbers = separate(loop.judge.wordless)
        merit, slopes = _slopes(code, numbers, samples, traces)
    return float(merit), jax.tree.map(np.asarray, slopes)


@partial(jax.jit, static_argnums=0)
def _slopes(
    code: Code, numbers: tuple[Scalar, ...], samples: Samples, traces: Traces
) -> tuple[Array, Traces]:
    judge = joined(code, numbers)

    def merit(traces: Traces) -> Array:
        moments = _moments(samples, traces)
        zero = jnp.zeros((), traces.error.dtype)

        def add(sums: tuple[Sums, ...], moment: Moment) -> tuple[tuple[Sums, ...], None]:
            pairs = zip(judge.objectives, sums, strict=True)
            return tuple(one.update(totals, (moment,), None) for one, totals in pairs), None

        sums, _ = lax.scan(add, tuple(one.initial(zero) for one in judge.objectives), moments)
        merit: Array = judge.merit(judge.values(sums))
        return merit

    return jax.value_and_grad(merit)(traces)


def _moments(samples: Samples, traces: Traces) -> Moment:
    """Return the inputs of the objectives, (steps,) each, without limits and copies of machines."""
    (axis,) = samples.axes
    every = jnp.ones_like(traces.error)
    position = axis.reference - traces.error
    velocity = axis.reference_rate - traces.error_rate
    return Moment(
        error=traces.error,
        error_rate=traces.error_rate,
        deviation=position - axis.target,
        command=traces.command,
        reference_rate=axis.reference_rate,
        settled=samples.settled,
        command_change=traces.command_change,
        limited=every < 0.0,
        sliding=axis.sliding,
        beyond=jnp.maximum((position - axis.end) * axis.heading, 0.0),
        late=samples.late,
        time=samples.time,
        sample_time=samples.sample_time * every,
        velocity=velocity,
        apart=0.0 * every,
        apart_rate=0.0 * every,
    )
