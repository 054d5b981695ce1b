"""The compiled programs: a population is spread over all devices and simulated in chunks on each.

For each ``Code`` of a loop there are programs for scores (also with early stopping), recorded
motions and derivatives. All call ``stepping``. A *lane* is one individual on one machine.
"""

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jax.sharding import Mesh, PartitionSpec
from jaxtyping import Array

from hfc_design.core import devices
from hfc_design.core.numbers import Integers, Memory
from hfc_design.objectives.judge import Judged
from hfc_design.simulation import early_stopping, stepping
from hfc_design.simulation.flattening import Code, Packed, joined
from hfc_design.simulation.stepping import Forms, Inputs, Motions

#: Largest chunk of lanes on a CPU core, whose data fit its cache; chunks are multiples of LANES.
CHUNK = 64
LANES = 16
#: Samples are padded to a multiple of at least this number; the padding is not simulated.
FEWEST_STEPS = 256
#: Least size of an array of recorded samples, all individuals together: a few MB.
RECORDED = 2**14


def filled(lanes: int) -> int:
    """Return the smallest number of at least ``lanes`` that fills the chunks of all devices."""
    return lanes + -lanes % (jax.device_count() * together(lanes))


def together(count: int) -> int:
    """Return the size of a chunk: how many of ``count`` lanes a device simulates together."""
    if jax.default_backend() != "cpu":
        return -(-count // jax.device_count())
    share = -(-count // (jax.device_count() * LANES)) * LANES
    return min(CHUNK, share)


def filled_up_steps(steps: int, recorded: int = 0) -> int:
    """Return the padded number of samples, so that motions of similar length share a program.

    From 1,024 samples on at most a quarter is added; more if few lanes are ``recorded``.
    """
    part = max(FEWEST_STEPS, 2 ** (steps.bit_length() - 3))
    least = RECORDED // recorded if recorded else 0
    return max(steps + -steps % part, least)


def finely(count: int) -> int:
    """Return the size of a chunk for early stopping; small for few lanes, to save whole chunks."""
    few = count < 4 * CHUNK * jax.device_count() and jax.default_backend() == "cpu"
    return LANES if few else together(count)


#: How numbers reach the devices: shared ones whole, those of each lane in chunks.
WHOLE, CHUNKS = PartitionSpec(), PartitionSpec("population")


@partial(jax.jit, static_argnums=(0, 1, 2), compiler_options=devices.compiler_options())
def scores(code: Code, own_machine: bool, forms: Forms, whole: Packed, lanes: Packed) -> Array:
    """Return merits, failures (1: failed) and values in one array, (2 + values, motions, lanes).

    There are few input arrays and one output array, because each array takes time.
    ``Inputs.packed`` makes the inputs.
    """

    def on_device(whole: Packed, lanes: Packed) -> Array:
        def one_chunk(chunk: Packed) -> Array:
            inputs = stepping.from_packed(forms, whole, chunk)
            return stepping.each_motion(joined(code, inputs.numbers), own_machine, inputs)

        judged = lax.map(one_chunk, lanes)  # (chunks, motions, ..., lanes)
        return jnp.moveaxis(judged, (2, 1, 0), (0, 1, 2)).reshape(*judged.shape[2:0:-1], -1)

    return spread(on_device, PartitionSpec(None, None, "population"))(whole, lanes)


@partial(jax.jit, static_argnums=(0, 1), compiler_options=devices.compiler_options())
def scores_needed(code: Code, forms: Forms, whole: Packed, lanes: Packed) -> Array:
    """Return the results of ``early_stopping.each`` on all devices, (3 + values, lanes)."""

    def on_device(whole: Packed, lanes: Packed) -> Array:
        def side_by_side(leaf: Array) -> Array:
            return jnp.moveaxis(leaf, 0, 1).reshape(leaf.shape[1], len(leaf) * leaf.shape[2])

        every = stepping.from_packed(forms, whole, jax.tree.map(side_by_side, lanes))
        return early_stopping.each(joined(code, every.numbers), every, stepping.trailing(lanes))

    return spread(on_device, PartitionSpec(None, "population"))(whole, lanes)


def spread(on_device: Any, out: PartitionSpec, specs: Any = (WHOLE, CHUNKS)) -> Any:
    """Return a function that runs ``on_device`` on every device, each with its share of lanes."""
    mesh = Mesh(jax.devices(), ("population",))
    return jax.shard_map(on_device, mesh=mesh, in_specs=specs, out_specs=out, check_vma=False)


@partial(jax.jit, static_argnums=(0, 1, 2), compiler_options=devices.compiler_options())
def trajectories(
    code: Code, own_machine: bool, recorded: int, inputs: Inputs
) -> tuple[Judged, Motions, Memory]:
    """Return judge's results, recordings, last memories; see ``stepping.recorded_motions``."""
    return stepping.recorded_motions(joined(code, inputs.numbers), own_machine, recorded, inputs)


def filled_up(chosen: Integers) -> Integers:
    """Return the indices of parameters, padded with -1 until the chunks of all devices are full."""
    width = jax.device_count() * LANES
    return np.append(chosen, np.full(-len(chosen) % width, -1)).astype(np.int32)


@partial(jax.jit, static_argnums=(0, 1), compiler_options=devices.compiler_options())
def jacobians(
    code: Code, quantities: tuple[str, ...], inputs: Inputs, chosen: Array
) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Return ``quantities`` of ``Recorded`` for copies of an individual, and their derivatives.

    All are (steps, lanes). A lane has the derivatives by one number in ``gains``, whose index is in
    ``chosen``; for the index -1 they are 0.
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
            loop, changed_inputs = joined(code, inputs.numbers), inputs._replace(gains=gains)
            (motion,) = stepping.one_motion(loop, False, changed_inputs, lanes.size)[1]
            return tuple(getattr(motion, name) for name in quantities)

        return jax.jvp(recorded, [copies[k] for k in moving], directions)

    return spread(on_device, PartitionSpec(None, "population"), (CHUNKS,))(chosen)
