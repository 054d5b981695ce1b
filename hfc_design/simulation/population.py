"""A population of closed loops, one or a hundred thousand -> what a judge says, trajectories.

``closed_loop`` is written for one machine in scalars. Here, and only here, it becomes a
population: every leaf of the gains carries the individuals in its *trailing* axis, the scan over
the samples runs outermost, and its body is ``vmap`` of the scalar sample over rows that are
sliced from the leaves inside the body. The compiler then emits one vector loop a sample.

The public functions prepare numbers, the compiled ones below them spread the population over the
devices in chunks, and all of them end in ``_run``.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jax.sharding import Mesh, PartitionSpec

from hfc_design.controllers.gains.law import LAWS
from hfc_design.core import devices
from hfc_design.core.records import UserError
from hfc_design.files.machine import ALL_PLANTS
from hfc_design.motion.signals import AxisSamples, Samples
from hfc_design.objectives.judge import Judged
from hfc_design.objectives.registry import OBJECTIVES
from hfc_design.simulation.closed_loop import Carry, Loop, Recorded, positions, sample, start

devices.configure()

#: Individuals that step together on one CPU core: their state and tables stay in its cache.
CHUNK = 64
LANES = 16


def scores(
    loop: Loop, plants: Any, samples: Samples, gains: Any, dtype: Any = np.float32
) -> Judged:
    """Merit, objectives and failures of every individual, in float64 as numpy.

    ``plants`` is the parameter record of each axis, ``gains`` the controller's record with the
    individuals in the trailing axis of every leaf. The work is spread over all devices.
    """
    count = jax.tree.leaves(gains)[0].shape[-1]
    width = devices.count() * _chunk(count)
    padding = -count % width
    padded = jax.tree.map(
        lambda leaf: np.pad(leaf, [(0, 0)] * (leaf.ndim - 1) + [(0, padding)], mode="edge"), gains
    )
    with _own_code(loop):
        result = _scores(loop, _cast(plants, dtype), _cast(samples, dtype), _cast(padded, dtype))
    return _without_padding(result, count)


def trajectory(
    loop: Loop, plants: Any, samples: Samples, gains: Any
) -> tuple[Judged, tuple[Recorded, ...]]:
    """What the judge says, and the motion of every axis and individual, in float64 as numpy.

    The parameters in ``plants`` are numbers, or (individuals,) where each has its own machine.
    """
    arguments = (_cast(item, np.float64) for item in (plants, samples, gains))
    with _own_code(loop):
        return jax.tree.map(np.asarray, _trajectory(loop, *arguments))


def error_jacobian(
    loop: Loop, plants: Any, samples: Samples, gains: Any, dtype: Any = np.float32
) -> tuple[np.ndarray, np.ndarray]:
    """Tracking error (steps,) of one individual and its derivative (steps, parameters).

    The parameters are the floating leaves of ``gains`` (trailing axis 1) one after the other.
    Forward mode on a population of copies, one a parameter, is as fast as the population is.
    """
    arguments = (_cast(item, dtype) for item in (plants, samples, gains))
    with _own_code(loop):
        error, jacobian = _error_jacobian(loop, *arguments)
    parameters = sum(leaf.size for leaf in jax.tree.leaves(gains) if leaf.dtype.kind == "f")
    return np.asarray(error[:, 0], np.float64), np.asarray(jacobian[:, :parameters], np.float64)


@contextmanager
def _own_code(loop: Loop) -> Iterator[None]:
    """What goes wrong in a user's own plant, controller or objective becomes a line."""
    try:
        yield
    except jax.errors.JaxRuntimeError:
        raise  # no memory, for one
    except Exception as error:
        own = [f"plant {loop.plant.name!r}"] * (loop.plant.name not in ALL_PLANTS.built_in)
        own += [f"controller {loop.controller.kind!r}"] * (
            loop.controller.kind not in LAWS.built_in
        )
        names = {objective.name for objective in loop.judge.objectives}
        own += [f"fitness {name!r}" for name in names - OBJECTIVES.built_in]
        if not own:
            raise
        reason = (str(error).splitlines() or [""])[0]
        raise UserError(
            f"{' or '.join(own)} cannot be simulated: {type(error).__name__}: {reason}"
        ) from error


def _chunk(count: int) -> int:
    if jax.default_backend() != "cpu":
        return -(-count // devices.count())
    share = -(-count // (devices.count() * LANES)) * LANES
    return min(CHUNK, share)


def _without_padding(judged: Judged, count: int) -> Judged:
    merit, values, failed = (np.asarray(leaf)[:count] for leaf in judged)
    return Judged(merit.astype(np.float64), values.astype(np.float64), failed)


def _cast(tree: Any, dtype: Any) -> Any:
    def cast(leaf: Any) -> np.ndarray:
        array = np.asarray(leaf)
        return array if array.dtype.kind == "i" else array.astype(dtype)

    return jax.tree.map(cast, tree)


@partial(jax.jit, static_argnums=0, compiler_options=devices.compiler_options())
def _scores(loop: Loop, plants: Any, samples: Samples, gains: Any) -> Judged:
    def on_device(plants: Any, samples: Samples, gains: Any) -> Judged:
        count = jax.tree.leaves(gains)[0].shape[-1]
        chunk = min(count, CHUNK) if jax.default_backend() == "cpu" else count

        def chunked(leaf: jax.Array) -> jax.Array:
            return jnp.moveaxis(leaf.reshape(*leaf.shape[:-1], -1, chunk), -2, 0)

        def one_chunk(gains: Any) -> Judged:
            return _run(loop, plants, samples, gains, record=False)[0]

        judged = lax.map(one_chunk, jax.tree.map(chunked, gains))
        return jax.tree.map(lambda leaf: leaf.reshape(-1, *leaf.shape[2:]), judged)

    split = jax.tree.map(lambda leaf: PartitionSpec(*[None] * (leaf.ndim - 1), "population"), gains)
    spread = jax.shard_map(
        on_device,
        mesh=Mesh(jax.devices(), ("population",)),
        in_specs=(PartitionSpec(), PartitionSpec(), split),
        out_specs=PartitionSpec("population"),
        check_vma=False,
    )
    return spread(plants, samples, gains)


@partial(jax.jit, static_argnums=0, compiler_options=devices.compiler_options())
def _trajectory(
    loop: Loop, plants: Any, samples: Samples, gains: Any
) -> tuple[Judged, tuple[Recorded, ...]]:
    return _run(loop, plants, samples, gains, record=True)


@partial(jax.jit, static_argnums=0, compiler_options=devices.compiler_options())
def _error_jacobian(
    loop: Loop, plants: Any, samples: Samples, gains: Any
) -> tuple[jax.Array, jax.Array]:
    leaves, structure = jax.tree.flatten(gains)
    sizes = [leaf.size if jnp.issubdtype(leaf.dtype, jnp.floating) else 0 for leaf in leaves]
    starts = np.cumsum([0, *sizes])
    width = devices.count() * LANES

    def on_device(lanes: jax.Array) -> tuple[jax.Array, jax.Array]:
        copies = [jnp.broadcast_to(leaf, (*leaf.shape[:-1], lanes.size)) for leaf in leaves]
        moving = [k for k, size in enumerate(sizes) if size]
        directions = []
        for k in moving:
            own = starts[k] + np.arange(sizes[k])
            directions.append(
                (own[:, None] == lanes).astype(copies[k].dtype).reshape(copies[k].shape)
            )

        def errors(*changed: jax.Array) -> jax.Array:
            full = list(copies)
            for k, leaf in zip(moving, changed, strict=True):
                full[k] = leaf
            _, outputs = _run(
                loop, plants, samples, jax.tree.unflatten(structure, full), record=True
            )
            error: jax.Array = outputs[0].error
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


def _run(loop: Loop, plants: Any, samples: Samples, gains: Any, record: bool) -> tuple[Judged, Any]:
    """Scan over the samples; returns what the judge says and, if asked for, the trajectories."""
    zeros = jnp.zeros(jax.tree.leaves(gains)[0].shape[-1], samples.settled.dtype)
    fixed = tuple(loop.plant.coefficients(plant) for plant in plants)
    own_machine = 0 if jnp.ndim(jax.tree.leaves(plants)[0]) else None
    step = jax.vmap(partial(sample, loop), in_axes=(own_machine, None, 0, 0, None))

    def body(carry: Carry, row: Any) -> tuple[Carry, Any]:
        # Slicing here and not outside keeps each leaf one operand of the compiled loop.
        carry, outputs = step(fixed, samples.sample_time, jax.tree.map(_rows, gains), carry, row)
        return carry, outputs if record else None

    rows = samples._replace(axes=tuple(map(_by_row, samples.axes)), sample_time=None)
    carry, outputs = lax.scan(body, start(loop, len(fixed), zeros), rows)
    return loop.judge.judged(carry.sums, positions(loop, carry)), outputs


def _by_row(axis: AxisSamples) -> AxisSamples:
    """Loads and noise as tuples, so that the scan hands out scalars."""
    return axis._replace(loads=tuple(axis.loads), noise=tuple(axis.noise))


def _rows(leaf: jax.Array) -> Any:
    """A leaf (..., individuals) as nested tuples of its (individuals,) rows."""
    if leaf.ndim == 1:
        return leaf
    flat = leaf.reshape(-1, leaf.shape[-1])
    rows: list[Any] = [lax.index_in_dim(flat, k, keepdims=False) for k in range(flat.shape[0])]
    for size in leaf.shape[-2:0:-1]:
        rows = [tuple(rows[k : k + size]) for k in range(0, len(rows), size)]
    return tuple(rows)
