"""Vectorisation: the loop of one machine, written in scalars, is run for a whole population.

``closed_loop`` computes a sample of one machine in scalars. Only here it is applied to many *lanes*
(one individual on one machine each). Every leaf of the gains has the lanes in its *trailing* axis.
The outermost loop is a scan over the samples; its body slices rows from the leaves and applies
``vmap`` of the scalar sample to them. The compiler turns this into one vector loop a sample.
"""

from functools import partial
from typing import Any, NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jax.typing import ArrayLike, DTypeLike
from jaxtyping import Array, PyTree

from hfc_design.core.numbers import Floats, Gains, Integers, Memory, Parameters, Scalar, State
from hfc_design.motion.samples import Samples
from hfc_design.objectives.judge import Individuals, Judged
from hfc_design.simulation import closed_loop
from hfc_design.simulation.closed_loop import Loop, LoopState, Monitor, Recorded
from hfc_design.simulation.flattening import Form, Packed, packed, unpacked

#: A number as an array (individuals,), or the rows of a table as nested tuples of such arrays.
Rows: TypeAlias = Individuals | tuple["Rows", ...]
Carry: TypeAlias = tuple[LoopState, Monitor]  # states, with those of copies; sums for the judge
Forms: TypeAlias = tuple[Form, Form]  # of inputs that all lanes share, and of each lane's own
Motions: TypeAlias = tuple[Recorded, ...]  # one for each axis, leaves (steps, individuals)


class Inputs(NamedTuple):
    """Inputs of a compiled loop."""

    numbers: tuple[Scalar, ...]  # floats of the loop, see ``Loop.apart``
    nominal: tuple[Parameters, ...]  # that the control assumes
    actual: tuple[Parameters, ...]  # true ones: numbers, or leaves (individuals,)
    samples: Samples  # of all motions one after the other, each with a start of its own
    gains: Gains  # leaves (..., individuals)
    #: (motions, 2) begin and end column of each motion; None: there is a single motion.
    bounds: Integers | None = None
    #: (individuals,) merit that each must be able to reach; None: no early stopping. Only for one
    #: motion of one machine; ``bounds`` are then those of its segments, (segments + 1,).
    needed: Individuals | None = None

    def cast(self, dtype: DTypeLike) -> "Inputs":
        """Return the inputs as arrays, with floating-point numbers in the precision ``dtype``."""

        def converted(leaf: ArrayLike) -> Floats | Integers:
            array = np.asarray(leaf)
            return array if array.dtype.kind == "i" else array.astype(dtype)

        return jax.tree.map(converted, self)

    def packed(
        self,
        own_machine: bool,
        dtype: DTypeLike,
        chunk: int,
        before: tuple[Forms, Packed] | None = None,
    ) -> tuple[Forms, Packed, Packed]:
        """Return the inputs in few arrays: their forms, the shared ones, those of each lane.

        ``before`` has the first two results of a call for other lanes, with the same shared inputs.
        """
        shared, per_lane = (None, self.actual) if own_machine else (self.actual, None)
        if before is None:
            whole = packed((self.numbers, self.nominal, shared, self.samples, self.bounds), dtype)
        else:
            whole = before[0][0], before[1]
        lanes, lane_numbers = packed((per_lane, self.gains, self.needed), dtype, chunk)
        return (whole[0], lanes), whole[1], lane_numbers


def from_packed(forms: Forms, whole: Packed, lanes: Packed) -> Inputs:
    """Return the inputs from packed ones: ``whole`` (numbers,) and ``lanes`` (numbers, lanes)."""
    numbers, nominal, shared, samples, bounds = unpacked(forms[0], whole)
    per_lane, gains, needed = unpacked(forms[1], lanes)
    true = shared if per_lane is None else per_lane
    return Inputs(numbers, nominal, true, samples, gains, bounds, needed)


def trailing(tree: PyTree) -> int:
    """Return the number of individuals or machines: the length of each leaf's trailing axis."""
    count: int = jax.tree.leaves(tree)[0].shape[-1]
    return count


def each_motion(loop: Loop, own_machine: bool, inputs: Inputs) -> Array:
    """Return merit, failure and values from the judge, (motions, 2 + values, individuals)."""

    def as_rows(scores: Judged) -> Array:
        return jnp.stack([scores.merit, scores.failed, *scores.values.T])

    if inputs.bounds is None:
        return as_rows(one_motion(loop, own_machine, inputs)[0])[None]
    body, rows, started = stepping(loop, own_machine, inputs)

    def one(motion: tuple[Array, tuple[State, ...], tuple[State, ...]]) -> Array:
        bounds, *starts = motion

        def at(k: Array, carry: Carry) -> Carry:
            return body(carry, row_of(rows, k))[0]

        carry = lax.fori_loop(bounds[0], bounds[1], at, started(*starts))
        return as_rows(judged(loop, carry))

    samples = inputs.samples
    each: Array = lax.map(one, (inputs.bounds, samples.start, samples.copy_start))
    return each


def one_motion(
    loop: Loop, own_machine: bool, inputs: Inputs, recorded: int = 0
) -> tuple[Judged, Any]:
    """Return the judge's results of one motion, and recordings of the first ``recorded`` lanes."""
    body, rows, started = stepping(loop, own_machine, inputs, recorded)
    samples = inputs.samples
    carry, outputs = lax.scan(body, started(samples.start, samples.copy_start), rows)
    return judged(loop, carry), outputs


def recorded_motions(
    loop: Loop, own_machine: bool, recorded: int, inputs: Inputs
) -> tuple[Judged, Motions, Memory]:
    """Return the judge's results, recordings, and final controller memories for several motions.

    Leaves of the results are (motions, individuals, ...), those of the recordings (steps of all
    motions, ``recorded``), those of the memories (motions, ..., ``recorded``): only the first
    ``recorded`` individuals have recordings and memories.
    """
    body, rows, started = stepping(loop, own_machine, inputs, recorded)
    body = jax.jit(body, inline=True)  # traced once, for the shapes and for the loop

    def row(k: ArrayLike) -> Any:
        return row_of(rows, k)

    def one(recording: Motions, motion: Any) -> tuple[Motions, tuple[Judged, Memory]]:
        bounds, *starts = motion

        def at(k: Array, now: tuple[Carry, Motions]) -> tuple[Carry, Motions]:
            carry, outputs = body(now[0], row(k))
            put = partial(lax.dynamic_update_index_in_dim, index=k, axis=0)
            return carry, jax.tree.map(put, now[1], outputs)

        carry, recording = lax.fori_loop(bounds[0], bounds[1], at, (started(*starts), recording))
        # Final memories of the controllers of the recorded individuals.
        memory = jax.tree.map(lambda leaf: leaf[..., :recorded], carry[0].memory)
        return recording, (judged(loop, carry), memory)

    samples = inputs.samples
    first = started(*jax.tree.map(lambda leaf: leaf[0], (samples.start, samples.copy_start)))
    _, outputs = jax.eval_shape(body, first, row(0))
    steps = len(samples.settled)
    recording = jax.tree.map(lambda one: jnp.zeros((steps, *one.shape), one.dtype), outputs)
    recording, ends = lax.scan(one, recording, (inputs.bounds, samples.start, samples.copy_start))
    scores, memory = ends
    return scores, recording, memory


def judged(loop: Loop, carry: Carry) -> Judged:
    """Return the final results of the judge, without the copies, which come last in the states."""
    machines, watch = carry
    count = watch.means[0].shape[0]
    places = [place[:count] for place in closed_loop.positions(loop, machines.states)]
    return loop.judge.judged(watch.sums, places)


def stepping(
    loop: Loop, own_machine: bool, inputs: Inputs, recorded: int = 0
) -> tuple[Any, Any, Any]:
    """Return the body of the scan, the rows of all samples, and a function for the first carry.

    ``body(carry, row)`` returns the next carry and a recording. Copies of the machines, if the loop
    has them, are further individuals behind all others, so that they do not enlarge the program.
    """
    _, nominal, true, samples, gains, *_ = inputs
    count = trailing(gains)
    zeros = jnp.zeros(count, samples.settled.dtype)
    fixed = loop.coefficients(true)
    doubled = loop.doubled and bool(samples.copy_start)
    machine_axis = 0 if own_machine else None
    step = jax.vmap(
        partial(closed_loop.next_state, loop), in_axes=(None, machine_axis, None, 0, 0, None)
    )
    look = jax.vmap(
        partial(closed_loop.monitored, loop), in_axes=(machine_axis, None, 0, 0, 0, None, 0)
    )
    start = jax.vmap(partial(closed_loop.start, loop), in_axes=(machine_axis, 0, None, 0))
    both = _both if doubled else lambda tree, _: tree
    every, all_fixed = both(gains, gains), both(fixed, fixed) if own_machine else fixed

    def first(tree: PyTree) -> PyTree:
        return jax.tree.map(lambda leaf: leaf[:count], tree) if doubled else tree

    def body(carry: Carry, row: Samples) -> tuple[Carry, Any]:
        before, watch = carry
        # Slicing here and not outside keeps each leaf one operand of the compiled loop.
        numbers = jax.tree.map(nested, every)
        after = step(nominal, all_fixed, samples.sample_time, numbers, before, row)
        copy = jax.tree.map(lambda leaf: leaf[count:], before.states) if doubled else ()
        seen = (first(before), first(after.commands), watch, row, copy)
        watch, outputs = look(fixed, samples.sample_time, *seen)
        record = jax.tree.map(lambda leaf: leaf[:recorded], outputs)
        return (after, watch), record if recorded else None

    def started(here: tuple[State, ...], off: tuple[State, ...]) -> Carry:
        numbers = jax.tree.map(nested, gains)
        machine = start(fixed, zeros, here, numbers)
        if not doubled:
            return machine, closed_loop.first_monitor(loop, zeros, machine)
        copy = start(fixed, zeros, off, numbers)
        return _both(machine, copy), closed_loop.first_monitor(loop, zeros, machine, copy)

    # Loads and noise as tuples, so that the scan passes them to the body as scalars.
    axes = (x._replace(loads=tuple(x.loads), noise=tuple(x.noise)) for x in samples.axes)
    rows = samples._replace(axes=tuple(axes), sample_time=None, start=(), copy_start=())
    return body, rows, started


def row_of(rows: PyTree, k: ArrayLike) -> PyTree:
    """Return the row of sample ``k``."""
    pick = partial(lax.dynamic_index_in_dim, index=k, keepdims=False, allow_negative_indices=False)
    return jax.tree.map(pick, rows)


def _both(one: PyTree, other: PyTree) -> PyTree:
    """Return every leaf of ``one`` followed by that of ``other``, along the trailing axis."""
    return jax.tree.map(lambda *leaves: jnp.concatenate(leaves, axis=-1), one, other)


def nested(leaf: Array) -> Rows:
    """Return a leaf (..., individuals) as nested tuples of its rows (individuals,)."""
    if leaf.ndim == 1:
        return leaf
    flat = leaf.reshape(-1, leaf.shape[-1])
    rows: list[Rows] = [lax.index_in_dim(flat, k, keepdims=False) for k in range(flat.shape[0])]
    for size in leaf.shape[-2:0:-1]:
        rows = [tuple(rows[k : k + size]) for k in range(0, len(rows), size)]
    return tuple(rows)
