"""Machines under any reference, with signals added to their commands, as recorded."""

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from hfc_design.core import devices
from hfc_design.core.numbers import Floats, Integers
from hfc_design.motion.samples import Samples
from hfc_design.simulation.closed_loop import Loop, LoopState, next_state, positions, start
from hfc_design.simulation.flattening import Code, joined
from hfc_design.simulation.frequency import Excited, Setup, row_at
from hfc_design.simulation.population import Machines, own_code_of
from hfc_design.simulation.stepping import nested

#: Machines that are simulated at once.
AT_ONCE = 125


class Moved(NamedTuple):
    """Signals of axes at the start of each sample, (machines, axes, steps)."""

    command: Floats
    seen: Floats  # the position that is fed back, without noise and steps of the encoder
    place: Floats  # the true position


def moved(
    setup: Setup,
    machines: Machines,
    rows: Samples,
    added: Floats,
    noise: Sequence[Floats | None],
    axes: tuple[int, ...],
) -> Moved:
    """Return the signals of machines that make a motion.

    Args:
        setup: the loop, and the gains of its controller.
        machines: ``standing`` if the loop has effects around its drives.
        rows: samples of the motion, every leaf with a leading axis (steps,).
        added: (axes, steps) signals added to the commands; or (machines, axes, steps).
        noise: for each axis (machines or 1, encoders, steps), instead of that in ``rows``; or None.
        axes: indices of those whose signals are returned.
    """
    loop, size = setup.loop, machines.size
    code, numbers = loop._replace(controller=Excited(loop.controller, False)).apart
    lasting = setup.point.row.sample_time, setup.point.row.start
    shared = numbers, machines.nominal, setup.gains, lasting, columns(rows, added.shape[-1])
    each = added, [*noise]
    width = -(-size // -(-size // AT_ONCE))  # chunks of one size share a program
    parts = []
    for begin in range(0, size, width):
        chosen = np.minimum(np.arange(begin, begin + width), size - 1)

        def lanes(leaf: Floats, chosen: Integers = chosen) -> Floats:
            separate = leaf.ndim == 3 and len(leaf) == size
            leaf = leaf[chosen] if separate else leaf
            return np.moveaxis(np.broadcast_to(leaf, (width, *leaf.shape[-2:])), -1, 1)

        with own_code_of(loop):
            parts.append(
                _motion(code, axes, shared, machines.take(chosen).actual, jax.tree.map(lanes, each))
            )
    joint = (np.concatenate([np.asarray(x) for x in y]) for y in zip(*parts, strict=True))
    return Moved(*(np.moveaxis(x[:size], 1, -1) for x in joint))


def followed(
    setup: Setup,
    machines: Machines,
    reference: Floats,
    added: Floats,
    noise: float = 0.0,
    seed: int = 0,
    common: bool = False,
) -> tuple[Floats, Floats]:
    """Return commands and measured positions (steps, machines) of an axis; the others rest.

    Args:
        setup: the loop, at rest.
        machines: ``standing`` if the loop has effects around its drives.
        reference: (steps,) less that of the place of rest.
        added: (steps,) signal added to the command.
        noise: standard deviation of the encoders' noise, of other values on each machine.
        seed: seed of the noise.
        common: whether all machines have the same noise.
    """
    axis, every, steps = setup.axis, setup.every, len(reference)
    rate = np.gradient(reference, every)
    only, drive = np.eye(len(setup.loop.limits))[:, [axis]], setup.loop.machine.drives[axis]
    rows = row_at(setup.point.row, *(only * x for x in (reference, rate, np.gradient(rate, every))))
    shaken: list[Floats | None] = [None] * len(setup.loop.limits)
    shape = (1 if common else machines.size, steps, len(drive.encoders))
    values = np.moveaxis(noise * np.random.default_rng(seed).standard_normal(shape), -1, 1)
    shaken[axis] = values if noise else None
    signals = moved(setup, machines, rows, only * added, shaken, (axis,))
    command, seen, _ = (x[:, 0].T for x in signals)
    return command, seen + values[:, 0].T


def columns(rows: Samples, steps: int) -> Samples:
    """Return the samples with every leaf (steps,), as a scan needs them."""
    axes = (x._replace(loads=tuple(x.loads), noise=tuple(x.noise)) for x in rows.axes)
    rows = rows._replace(axes=tuple(axes), sample_time=None, start=(), copy_start=())
    return jax.tree.map(lambda leaf: np.broadcast_to(np.asarray(leaf, float), steps), rows)


@partial(jax.jit, static_argnums=(0, 1), compiler_options=devices.compiler_options())
def _motion(code: Code, axes: tuple[int, ...], shared: Any, true: Any, lanes: Any) -> Any:
    """Return the fields of ``Moved``, (machines, steps, axes) each."""
    numbers, nominal, gains, (every, begin), rows = shared
    loop: Loop = joined(code, numbers)
    law = jax.tree.map(lambda one: one[0], jax.tree.map(nested, gains))
    every_axis = range(len(loop.limits))

    def one(parameters: Any, given: Any) -> Any:
        fixed = loop.coefficients(parameters)

        def sample(before: LoopState, now: Any) -> tuple[LoopState, Any]:
            row, (added, noise) = now
            shaken = [
                x if values is None else x._replace(noise=(*values, *x.noise[len(values) :]))
                for x, values in zip(row.axes, noise, strict=True)
            ]
            row = row._replace(axes=tuple(shaken))
            excited = law, tuple(added[k] for k in every_axis)
            after = next_state(loop, nominal, fixed, every, excited, before, row)
            drives, all_places = loop.machine.drives, positions(loop, before.states)
            states = (drives[k].measured(fixed[k], before.states[k]) for k in axes)
            pairs = zip(axes, states, strict=True)
            seen = jnp.stack([getattr(state, drives[k].seen[0]) for k, state in pairs])
            each = (jnp.stack([x[k] for k in axes]) for x in (after.commands, all_places))
            command, place = each
            return after, (command, seen, place)

        quiet = law, (0.0,) * len(every_axis)
        return lax.scan(sample, start(loop, fixed, jnp.zeros(()), begin, quiet), (rows, given))[1]

    return jax.vmap(one)(true, lanes)
