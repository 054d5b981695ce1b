"""A population of closed loops, one or a hundred thousand -> what a judge says, trajectories.

``closed_loop`` is written for one machine in scalars. Here, and only here, it becomes a
population: every leaf of the gains carries the individuals in its *trailing* axis, the scan over
the samples runs outermost, and its body is ``vmap`` of the scalar sample over rows that are
sliced from the leaves inside the body. The compiler then emits one vector loop a sample.

The public functions prepare numbers, the compiled ones below them spread the population over the
devices in chunks, and all of them end in ``_run``.
"""

from collections.abc import Sequence
from contextlib import AbstractContextManager
from functools import partial
from typing import Any, NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jax.sharding import Mesh, PartitionSpec
from jax.typing import ArrayLike, DTypeLike
from jaxtyping import Array, PyTree

from hfc_design.core import devices
from hfc_design.core.numbers import Floats, Gains, Integers, Parameters, State
from hfc_design.core.plugins import own_code
from hfc_design.motion.samples import Samples
from hfc_design.objectives.judge import Individuals, Judged
from hfc_design.simulation.closed_loop import (
    Loop,
    Moving,
    Recorded,
    Watch,
    moved,
    positions,
    start,
    watched,
    watching,
)

#: Individuals that step together on one CPU core: their state and tables stay in its cache.
CHUNK = 64
LANES = 16

#: A number of one individual, or the rows of a table as tuples of tuples.
Rows: TypeAlias = Individuals | tuple["Rows", ...]
Carry: TypeAlias = tuple[Moving, Watch]  # the machines with their copies, what is seen of them
Motions: TypeAlias = tuple[Recorded, ...]  # of every axis, leaves (steps, individuals)


class Machines(NamedTuple):
    """Machines of the same kind with parameters of their own."""

    told: tuple[Parameters, ...]  # what the control believes: the record of each axis, numbers
    true: tuple[Parameters, ...]  # the record of each axis, leaves (machines,)

    @property
    def size(self) -> int:
        """How many."""
        return _count(self.true)

    def take(self, chosen: int | Integers) -> "Machines":
        """The machines that an index array chooses, or the one of an index."""
        return Machines(self.told, jax.tree.map(lambda leaf: leaf[chosen], self.true))


class Inputs(NamedTuple):
    """What goes into a compiled loop."""

    told: tuple[Parameters, ...]
    true: tuple[Parameters, ...]  # numbers, or leaves (individuals,)
    samples: Samples  # of all motions one after the other, each with a start of its own
    gains: Gains  # leaves (..., individuals)
    bounds: Integers | None = None  # (motions, 2) columns of each motion; None: there is but one


def one_machine(parameters: tuple[Parameters, ...]) -> Machines:
    """The machine of the record of each axis, which the control knows."""
    true = jax.tree.map(lambda number: np.array([number], np.float64), parameters)
    return Machines(parameters, true)


def scores(
    loop: Loop,
    machines: Machines,
    motions: Sequence[Samples],
    gains: Gains,
    dtype: DTypeLike = np.float32,
) -> Judged:
    """What the judge says of every individual on every machine in every motion, as numpy.

    Merit and failures are (individuals, machines, motions), values have the objectives in one
    axis more, all in float64. One program serves any number of motions of any length. ``gains``
    is the controller's record with the individuals in the trailing axis of every leaf. The work
    is spread over all devices.
    """
    count, each = _count(gains), machines.size
    lanes = count * each
    whole = lanes + -lanes % (jax.device_count() * _chunk(lanes))
    lane = np.minimum(np.arange(whole), lanes - 1)  # the last one fills up the last chunk
    if whole > count:
        gains = jax.tree.map(lambda leaf: np.take(leaf, lane // each, axis=-1), gains)
    true = machines.take(lane % each if each > 1 else 0).true
    samples, bounds = _joined(motions)
    with _own_code(loop), jax.enable_x64(True):
        inputs = _cast(Inputs(machines.told, true, samples, gains, bounds), dtype)
        found = np.asarray(_scores(loop, each > 1, inputs), np.float64)
    found = found[..., :lanes].reshape(len(found), len(motions), count, each)
    merit, failed, *values = np.moveaxis(found, 1, -1)
    return Judged(merit, np.stack(values, axis=-1), failed > 0.0)


def trajectory(
    loop: Loop, machines: Machines, samples: Samples, gains: Gains
) -> tuple[Judged, Motions]:
    """What the judge says, and the motion of every axis and individual, in float64 as numpy.

    All on the only one of ``machines``, or each on a machine of its own.
    """
    own = machines.size > 1
    inputs = Inputs(*(machines if own else machines.take(0)), samples, gains)
    with _own_code(loop), jax.enable_x64(True):
        return jax.tree.map(np.asarray, _trajectory(loop, own, _cast(inputs, np.float64)))


def error_jacobian(
    loop: Loop, machines: Machines, samples: Samples, gains: Gains, dtype: DTypeLike = np.float32
) -> tuple[Floats, Floats]:
    """Tracking error (steps,) of one individual on one machine, and its derivative.

    The derivative is (steps, parameters); the parameters are the floating leaves of ``gains``
    (trailing axis 1) one after the other. Forward mode on a population of copies, one a
    parameter, is as fast as the population is.
    """
    with _own_code(loop), jax.enable_x64(True):
        inputs = _cast(Inputs(*machines.take(0), samples, gains), dtype)
        error, jacobian = _error_jacobian(loop, inputs)
    parameters = sum(leaf.size for leaf in jax.tree.leaves(gains) if leaf.dtype.kind == "f")
    return np.asarray(error[:, 0], np.float64), np.asarray(jacobian[:, :parameters], np.float64)


def _own_code(loop: Loop) -> AbstractContextManager[None]:
    """What goes wrong in a user's own plant, controller or objective becomes a line."""
    parts = [("plant", drive.name) for drive in loop.machine.drives]
    parts += [("plant", loop.machine.name), ("controller", loop.controller.kind)]
    parts += [("fitness", objective.name) for objective in loop.judge.objectives]
    no_memory = jax.errors.JaxRuntimeError  # for one
    return own_code(" cannot be simulated", *parts, passing=(no_memory,))


def _chunk(count: int) -> int:
    if jax.default_backend() != "cpu":
        return -(-count // jax.device_count())
    share = -(-count // (jax.device_count() * LANES)) * LANES
    return min(CHUNK, share)


def _count(tree: PyTree) -> int:
    """How many individuals or machines there are, by the trailing axis of every leaf."""
    count: int = jax.tree.leaves(tree)[0].shape[-1]
    return count


def _joined(motions: Sequence[Samples]) -> tuple[Samples, Integers | None]:
    """Several motions one after the other, and the columns of each."""
    first = motions[0]
    if len(motions) == 1:
        return first, None
    columns = [own._replace(sample_time=None, start=(), beside=()) for own in motions]
    whole = jax.tree.map(lambda *parts: np.concatenate(parts, axis=-1), *columns)
    starts = [(own.start, own.beside) for own in motions]
    start, beside = jax.tree.map(lambda *each: np.array(each), *starts)
    ends = np.cumsum([0, *(len(own.time) for own in motions)])
    bounds = np.stack([ends[:-1], ends[1:]], axis=1)
    one = {"sample_time": first.sample_time, "start": start, "beside": beside}
    return whole._replace(**one), bounds


def _cast(inputs: Inputs, dtype: DTypeLike) -> Inputs:
    """Floating numbers in a precision."""

    def cast(leaf: ArrayLike) -> Floats | Integers:
        array = np.asarray(leaf)
        return array if array.dtype.kind == "i" else array.astype(dtype)

    return jax.tree.map(cast, inputs)


@partial(jax.jit, static_argnums=(0, 1), compiler_options=devices.compiler_options())
def _scores(loop: Loop, own_machine: bool, inputs: Inputs) -> Array:
    """(2 + objectives, motions, lanes): merits, 1 where one failed, values, in one array.

    One array comes back faster than several.
    """

    def on_device(inputs: Inputs) -> Array:
        count = _count(inputs.gains)
        chunk = min(count, CHUNK) if jax.default_backend() == "cpu" else count

        def chunked(leaf: Array) -> Array:
            return jnp.moveaxis(leaf.reshape(*leaf.shape[:-1], -1, chunk), -2, 0)

        def one_chunk(own: PyTree) -> Array:
            gains, true = own if own_machine else (own, inputs.true)
            return _each_motion(loop, own_machine, inputs._replace(true=true, gains=gains))

        lanes = (inputs.gains, inputs.true) if own_machine else inputs.gains
        judged = lax.map(one_chunk, jax.tree.map(chunked, lanes))  # (chunks, motions, ..., lanes)
        return jnp.moveaxis(judged, (2, 1, 0), (0, 1, 2)).reshape(*judged.shape[2:0:-1], -1)

    def last(leaf: Array) -> PartitionSpec:
        return PartitionSpec(*[None] * (leaf.ndim - 1), "population")

    whole: Any = PartitionSpec()
    machines = jax.tree.map(last, inputs.true) if own_machine else whole
    spread = jax.shard_map(
        on_device,
        mesh=Mesh(jax.devices(), ("population",)),
        in_specs=(Inputs(whole, machines, whole, jax.tree.map(last, inputs.gains), whole),),
        out_specs=PartitionSpec(None, None, "population"),
        check_vma=False,
    )
    return spread(inputs)


@partial(jax.jit, static_argnums=(0, 1), compiler_options=devices.compiler_options())
def _trajectory(loop: Loop, own_machine: bool, inputs: Inputs) -> tuple[Judged, Motions]:
    return _run(loop, own_machine, inputs, record=True)


@partial(jax.jit, static_argnums=0, compiler_options=devices.compiler_options())
def _error_jacobian(loop: Loop, inputs: Inputs) -> tuple[Array, Array]:
    leaves, structure = jax.tree.flatten(inputs.gains)
    sizes = [leaf.size if jnp.issubdtype(leaf.dtype, jnp.floating) else 0 for leaf in leaves]
    starts = np.cumsum([0, *sizes])
    width = jax.device_count() * LANES

    def on_device(lanes: Array) -> tuple[Array, Array]:
        copies = [jnp.broadcast_to(leaf, (*leaf.shape[:-1], lanes.size)) for leaf in leaves]
        moving = [k for k, size in enumerate(sizes) if size]
        directions = []
        for k in moving:
            hit = starts[k] + np.arange(sizes[k])[:, None] == lanes
            directions.append(hit.astype(copies[k].dtype).reshape(copies[k].shape))

        def errors(*changed: Array) -> Array:
            full = list(copies)
            for k, leaf in zip(moving, changed, strict=True):
                full[k] = leaf
            gains = jax.tree.unflatten(structure, full)
            error: Array = _run(loop, False, inputs._replace(gains=gains), True)[1][0].error
            return error

        return jax.jvp(errors, [copies[k] for k in moving], directions)

    spread = jax.shard_map(
        on_device,
        mesh=Mesh(jax.devices(), ("parameters",)),
        in_specs=PartitionSpec("parameters"),
        out_specs=PartitionSpec(None, "parameters"),
        check_vma=False,
    )
    return spread(jnp.arange(-(-int(starts[-1]) // width) * width))


def _each_motion(loop: Loop, own_machine: bool, inputs: Inputs) -> Array:
    """(motions, 2 + objectives, individuals) what the judge says of every motion."""

    def told(judged: Judged) -> Array:
        return jnp.stack([judged.merit, judged.failed, *judged.values.T])

    if inputs.bounds is None:
        return told(_run(loop, own_machine, inputs, record=False)[0])[None]
    body, rows, started = _stepping(loop, own_machine, inputs, record=False)

    def one(motion: tuple[Array, tuple[State, ...], tuple[State, ...]]) -> Array:
        bounds, *starts = motion

        def at(k: Array, carry: Carry) -> Carry:
            return body(carry, jax.tree.map(lambda leaf: leaf[k], rows))[0]

        carry = lax.fori_loop(bounds[0], bounds[1], at, started(*starts))
        return told(_judged(loop, carry))

    samples = inputs.samples
    each: Array = lax.map(one, (inputs.bounds, samples.start, samples.beside))
    return each


def _run(loop: Loop, own_machine: bool, inputs: Inputs, record: bool) -> tuple[Judged, Any]:
    """Scan over the samples; returns what the judge says and, if asked for, the trajectories."""
    body, rows, started = _stepping(loop, own_machine, inputs, record)
    samples = inputs.samples
    carry, outputs = lax.scan(body, started(samples.start, samples.beside), rows)
    return _judged(loop, carry), outputs


def _judged(loop: Loop, carry: Carry) -> Judged:
    """What the judge says in the end; the copies come last in the states."""
    machines, watch = carry
    places = [place[: watch.means[0].shape[0]] for place in positions(loop, machines.states)]
    return loop.judge.judged(watch.sums, places)


def _stepping(loop: Loop, own_machine: bool, inputs: Inputs, record: bool) -> tuple[Any, Any, Any]:
    """(carry, row) -> (carry, recorded); the rows of all samples; start -> the first carry.

    Copies of the machines, where the loop has them, are individuals like the others behind them:
    the program is no larger for them.
    """
    told, true, samples, gains, _ = inputs
    count = _count(gains)
    zeros = jnp.zeros(count, samples.settled.dtype)
    fixed = loop.machine.coefficients(true)
    doubled = loop.doubled and bool(samples.beside)
    own = 0 if own_machine else None
    step = jax.vmap(partial(moved, loop), in_axes=(None, own, None, 0, 0, None))
    look = jax.vmap(partial(watched, loop), in_axes=(own, None, 0, 0, 0, None, 0))
    both = _both if doubled else lambda tree, _: tree
    every, all_fixed = both(gains, gains), both(fixed, fixed) if own_machine else fixed

    def first(tree: PyTree) -> PyTree:
        return jax.tree.map(lambda leaf: leaf[:count], tree) if doubled else tree

    def body(carry: Carry, row: Samples) -> tuple[Carry, Any]:
        before, watch = carry
        # Slicing here and not outside keeps each leaf one operand of the compiled loop.
        numbers = jax.tree.map(_rows, every)
        after = step(told, all_fixed, samples.sample_time, numbers, before, row)
        copy = jax.tree.map(lambda leaf: leaf[count:], before.states) if doubled else ()
        seen = (first(before), first(after.commands), watch, row, copy)
        watch, outputs = look(fixed, samples.sample_time, *seen)
        return (after, watch), outputs if record else None

    def started(here: tuple[State, ...], off: tuple[State, ...]) -> Carry:
        machine = start(loop, zeros, here)
        if not doubled:
            return machine, watching(loop, zeros, machine)
        copy = start(loop, zeros, off)
        return _both(machine, copy), watching(loop, zeros, machine, copy)

    # Loads and noise as tuples, so that the loop hands out scalars.
    axes = (x._replace(loads=tuple(x.loads), noise=tuple(x.noise)) for x in samples.axes)
    rows = samples._replace(axes=tuple(axes), sample_time=None, start=(), beside=())
    return body, rows, started


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
