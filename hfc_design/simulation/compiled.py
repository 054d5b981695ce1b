"""The compiled programs: a population spread over all devices, on each of them in chunks.

One for scores, one for motions, one for derivatives. All of them end in ``stepping``.
"""

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jax.sharding import Mesh, PartitionSpec
from jaxtyping import Array, PyTree

from hfc_design.core import devices
from hfc_design.core.numbers import Integers
from hfc_design.objectives.judge import Judged
from hfc_design.simulation import rejecting
from hfc_design.simulation.closed_loop import Loop
from hfc_design.simulation.stepping import Inputs, Motions, each_motion, one_motion, trailing

#: Individuals that step together on one CPU core: their state and tables stay in its cache.
CHUNK = 64
LANES = 16


def filled(lanes: int) -> int:
    """So many individuals that the chunks of all devices are full, ``lanes`` at least."""
    return lanes + -lanes % (jax.device_count() * _chunk(lanes))


def _chunk(count: int) -> int:
    if jax.default_backend() != "cpu":
        return -(-count // jax.device_count())
    share = -(-count // (jax.device_count() * LANES)) * LANES
    return min(CHUNK, share)


@partial(jax.jit, static_argnums=(0, 1), compiler_options=devices.compiler_options())
def scores(loop: Loop, own_machine: bool, inputs: Inputs) -> Array:
    """(2 + objectives, motions, lanes): merits, 1 where one failed, values, in one array.

    One array comes back faster than several.
    """

    def on_device(inputs: Inputs) -> Array:
        count = trailing(inputs.gains)
        chunk = min(count, CHUNK) if jax.default_backend() == "cpu" else count

        def chunked(leaf: Array) -> Array:
            return jnp.moveaxis(leaf.reshape(*leaf.shape[:-1], -1, chunk), -2, 0)

        def one_chunk(own: PyTree) -> Array:
            gains, true = own if own_machine else (own, inputs.true)
            return each_motion(loop, own_machine, inputs._replace(true=true, gains=gains))

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
        in_specs=(Inputs(whole, machines, whole, jax.tree.map(last, inputs.gains), whole, whole),),
        out_specs=PartitionSpec(None, None, "population"),
        check_vma=False,
    )
    return spread(inputs)


@partial(jax.jit, static_argnums=0, compiler_options=devices.compiler_options())
def scores_needed(loop: Loop, inputs: Inputs) -> Array:
    """(3 + objectives, lanes): as ``rejecting.each`` gives them, each of what it needs."""

    def on_device(inputs: Inputs) -> Array:
        count = trailing(inputs.gains)
        # Of few individuals large chunks would be full of those that are lost.
        chunk = CHUNK if count >= 4 * CHUNK else LANES
        return rejecting.each(loop, inputs, chunk if jax.default_backend() == "cpu" else count)

    def last(leaf: Array) -> PartitionSpec:
        return PartitionSpec(*[None] * (leaf.ndim - 1), "population")

    whole: Any = PartitionSpec()
    lanes: Any = (jax.tree.map(last, inputs.gains), whole, PartitionSpec("population"))
    spread = jax.shard_map(
        on_device,
        mesh=Mesh(jax.devices(), ("population",)),
        in_specs=(Inputs(whole, whole, whole, *lanes),),
        out_specs=PartitionSpec(None, "population"),
        check_vma=False,
    )
    return spread(inputs)


@partial(jax.jit, static_argnums=(0, 1, 2), compiler_options=devices.compiler_options())
def trajectory(
    loop: Loop, own_machine: bool, recorded: int, inputs: Inputs
) -> tuple[Judged, Motions]:
    """What the judge says, and the motion of every axis, leaves (steps, ``recorded``)."""
    return one_motion(loop, own_machine, inputs, recorded)


def filled_up(chosen: Integers) -> Integers:
    """Numbers of parameters, -1 behind them, so that the chunks of all devices are full."""
    width = jax.device_count() * LANES
    return np.append(chosen, np.full(-len(chosen) % width, -1)).astype(np.int32)


@partial(jax.jit, static_argnums=(0, 1), compiler_options=devices.compiler_options())
def jacobians(
    loop: Loop, quantities: tuple[str, ...], inputs: Inputs, chosen: Array
) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Some ``quantities`` of ``Recorded`` (steps, lanes) of copies of an individual, and slopes.

    Each lane has their derivatives by one of the numbers in ``gains``, ``chosen`` ones; those by -1
    are 0.
    """
    leaves, structure = jax.tree.flatten(inputs.gains)
    sizes = [leaf.size if jnp.issubdtype(leaf.dtype, jnp.floating) else 0 for leaf in leaves]
    starts = np.cumsum([0, *sizes])

    def on_device(lanes: Array) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
        copies = [jnp.broadcast_to(leaf, (*leaf.shape[:-1], lanes.size)) for leaf in leaves]
        moving = [k for k, size in enumerate(sizes) if size]
        directions = []
        for k in moving:
            hit = starts[k] + np.arange(sizes[k])[:, None] == lanes
            directions.append(hit.astype(copies[k].dtype).reshape(copies[k].shape))

        def recorded(*changed: Array) -> tuple[Array, ...]:
            full = list(copies)
            for k, leaf in zip(moving, changed, strict=True):
                full[k] = leaf
            gains = jax.tree.unflatten(structure, full)
            (motion,) = one_motion(loop, False, inputs._replace(gains=gains), lanes.size)[1]
            return tuple(getattr(motion, name) for name in quantities)

        return jax.jvp(recorded, [copies[k] for k in moving], directions)

    spread = jax.shard_map(
        on_device,
        mesh=Mesh(jax.devices(), ("parameters",)),
        in_specs=PartitionSpec("parameters"),
        out_specs=PartitionSpec(None, "parameters"),
        check_vma=False,
    )
    return spread(chosen)
