"""Vectorisation: the scalar loop of one machine becomes that of a population.

``closed_loop`` is written for one machine in scalars. Here, and only here, it becomes a
population: every leaf of the gains carries the individuals in its *trailing* axis, the scan over
the samples runs outermost, and its body is ``vmap`` of the scalar sample over rows that are
sliced from the leaves inside the body. The compiler then emits one vector loop a sample.
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

#: A number of one individual, or the rows of a table as tuples of tuples.
Rows: TypeAlias = Individuals | tuple["Rows", ...]
Carry: TypeAlias = tuple[LoopState, Monitor]  # the machines with their copies, what is seen of them
Forms: TypeAlias = tuple[Form, Form]  # of what all lanes share, and of what each has
Motions: TypeAlias = tuple[Recorded, ...]  # of every axis, leaves (steps, individuals)


class Inputs(NamedTuple):
    """Inputs of a compiled loop."""

    numbers: tuple[Scalar, ...]  # of the loop, see ``Loop.apart``
    nominal: tuple[Parameters, ...]
    actual: tuple[Parameters, ...]  # numbers, or leaves (individuals,)
    samples: Samples  # of all motions one after the other, each with a start of its own
    gains: Gains  # leaves (..., individuals)
    bounds: Integers | None = (
        None  # (motions, 2) columns of each motion; None: all, of the only one
    )
    #: (individuals,) merit that each needs; only for one motion of one machine. ``bounds`` are then
    #: those of the motion's segments, (segments + 1,).
    needed: Individuals | None = None

    def cast(self, dtype: DTypeLike) -> "Inputs":
        """The inputs as arrays, floating numbers in a precision."""

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
        """Inputs shared by all lanes and those of each lane, in few arrays: see ``from_packed``.

        The shared ones are those in ``before``, if these were packed for other lanes.
        """
        shared, per_lane = (None, self.actual) if own_machine else (self.actual, None)
        if before is None:
            whole = packed((self.numbers, self.nominal, shared, self.samples, self.bounds), dtype)
        else:
            whole = before[0][0], before[1]
        lanes, lane_numbers = packed((per_lane, self.gains, self.needed), dtype, chunk)
        return (whole[0], lanes), whole[1], lane_numbers


def from_packed(forms: Forms, whole: Packed, lanes: Packed) -> Inputs:
    """Return the inputs of the lanes with these numbers (numbers, lanes)."""
    numbers, nominal, shared, samples, bounds = unpacked(forms[0], whole)
    per_lane, gains, needed = unpacked(forms[1], lanes)
    true = shared if per_lane is None else per_lane
    return Inputs(numbers, nominal, true, samples, gains, bounds, needed)


def trailing(tree: PyTree) -> int:
    """Number of individuals or machines, from the trailing axis of every leaf."""
    count: int = jax.tree.leaves(tree)[0].shape[-1]
    return count


def each_motion(loop: Loop, own_machine: bool, inputs: Inputs) -> Array:
    """(motions, 2 + objectives, individuals) results of the judge for every motion."""

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
    """Scan over the samples: result of the judge, and motions of the first individuals."""
    body, rows, started = stepping(loop, own_machine, inputs, recorded)
    samples = inputs.samples
    carry, outputs = lax.scan(body, started(samples.start, samples.copy_start), rows)
    return judged(loop, carry), outputs


def recorded_motions(
    loop: Loop, own_machine: bool, recorded: int, inputs: Inputs
) -> tuple[Judged, Motions, Memory]:
    """Results of the judge for every motion, and the motions of the first individuals.

    Leaves of the judge's results have the motions in front, as have those of the final controller
    memories, (motions, ``recorded``); those of the motions are (steps of all motions,
    ``recorded``).
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
        # What the controllers of the first individuals remember.
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
    """Final result of the judge; the copies come last in the states."""
    machines, watch = carry
    places = [
        place[: watch.means[0].shape[0]] for place in closed_loop.positions(loop, machines.states)
    ]
    return loop.judge.judged(watch.sums, places)


def stepping(
    loop: Loop, own_machine: bool, inputs: Inputs, recorded: int = 0
) -> tuple[Any, Any, Any]:
    """(carry, row) -> (carry, recorded); the rows of all samples; start -> the first carry.

    Copies of the machines, if the loop has them, are further individuals behind the others: they do
    not enlarge the program.
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
        numbers = jax.tree.map(_rows, every)
        after = step(nominal, all_fixed, samples.sample_time, numbers, before, row)
        copy = jax.tree.map(lambda leaf: leaf[count:], before.states) if doubled else ()
        seen = (first(before), first(after.commands), watch, row, copy)
        watch, outputs = look(fixed, samples.sample_time, *seen)
        record = jax.tree.map(lambda leaf: leaf[:recorded], outputs)
        return (after, watch), record if recorded else None

    def started(here: tuple[State, ...], off: tuple[State, ...]) -> Carry:
        numbers = jax.tree.map(_rows, gains)
        machine = start(fixed, zeros, here, numbers)
        if not doubled:
            return machine, closed_loop.first_monitor(loop, zeros, machine)
        copy = start(fixed, zeros, off, numbers)
        return _both(machine, copy), closed_loop.first_monitor(loop, zeros, machine, copy)

    # Loads and noise as tuples, so that the loop hands out scalars.
    axes = (x._replace(loads=tuple(x.loads), noise=tuple(x.noise)) for x in samples.axes)
    rows = samples._replace(axes=tuple(axes), sample_time=None, start=(), copy_start=())
    return body, rows, started


def row_of(rows: PyTree, k: ArrayLike) -> PyTree:
    """The row of one sample."""
    pick = partial(lax.dynamic_index_in_dim, index=k, keepdims=False, allow_negative_indices=False)
    return jax.tree.map(pick, rows)


def _both(one: PyTree, other: PyTree) -> PyTree:
    """Individuals and then others, along the trailing axis."""
    return jax.tree.map(lambda *leaves: jnp.concatenate(leaves, axis=-1), one, other)


def _rows(leaf: Array) -> Rows:
    """A leaf (..., individuals) as nested tuples of its (individuals,) rows."""
    if leaf.ndim == 1:
        return leaf
    flat = leaf.reshape(-1, leaf.shape[-1])
    rows: list[Rows] = [lax.index_in_dim(flat, k, keepdims=False) for k in range(flat.shape[0])]
    for size in leaf.shape[-2:0:-1]:
        rows = [tuple(rows[k : k + size]) for k in range(0, len(rows), size)]
    return tuple(rows)
