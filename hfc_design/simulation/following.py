"""Machines under any reference and a signal added to the command of one axis, as recorded."""

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from hfc_design.core import devices
from hfc_design.core.numbers import Floats
from hfc_design.simulation.closed_loop import Loop, next_state, start
from hfc_design.simulation.flattening import Code, joined
from hfc_design.simulation.frequency import Excited, Setup, row_at
from hfc_design.simulation.population import Machines, own_code_of
from hfc_design.simulation.stepping import nested

#: Machines that are simulated at once.
AT_ONCE = 125


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
    loop, axis, every, steps = setup.loop, setup.axis, setup.every, len(reference)
    rate = np.gradient(reference, every)
    moving = np.stack([reference, rate, np.gradient(rate, every), added], axis=1)
    code, numbers = loop._replace(controller=Excited(loop.controller, False)).apart
    shared = numbers, machines.nominal, setup.gains, setup.point.row, moving
    generator, parts = np.random.default_rng(seed), []
    encoders, size = len(loop.machine.drives[axis].encoders), machines.size
    width = -(-size // -(-size // AT_ONCE))  # chunks of one size share a program
    for begin in range(0, size, width):
        some = machines.take(np.minimum(np.arange(begin, begin + width), size - 1))
        shape = (1 if common else width, steps, encoders) if noise else (1, 1, 1)
        shaken = np.broadcast_to(noise * generator.standard_normal(shape), (width, *shape[1:]))
        with own_code_of(loop):
            parts.append(_motion(code, axis, bool(noise), shared, some.actual, shaken))
    command, place = (np.concatenate([np.asarray(x) for x in y]) for y in zip(*parts, strict=True))
    return command[:size].T, place[:size].T


@partial(jax.jit, static_argnums=(0, 1, 2), compiler_options=devices.compiler_options())
def _motion(code: Code, axis: int, noisy: bool, shared: Any, true: Any, noise: Any) -> Any:
    """Return commands and measured positions (machines, steps)."""
    numbers, nominal, gains, row, moving = shared
    loop: Loop = joined(code, numbers)
    law = jax.tree.map(lambda one: one[0], jax.tree.map(nested, gains))
    drive, only = loop.machine.drives[axis], np.eye(len(loop.limits))[axis]
    quiet = law, (0.0,) * len(only)

    def one(parameters: Any, noise: Any) -> Any:
        fixed = loop.coefficients(parameters)

        def sample(before: Any, now: Any) -> Any:
            (reference, rate, faster, added), shaken = now
            there = row_at(row, *(only * x for x in (reference, rate, faster)))
            if noisy:
                signals = there.axes[axis]
                values = (*shaken, *signals.noise[len(shaken) :])
                axes = [*there.axes[:axis], signals._replace(noise=values), *there.axes[axis + 1 :]]
                there = there._replace(axes=tuple(axes))
            excited = law, tuple(added * x for x in only)
            after = next_state(loop, nominal, fixed, row.sample_time, excited, before, there)
            seen = drive.measured(fixed[axis], before.states[axis])
            place = getattr(seen, drive.seen[0]) + (shaken[0] if noisy else 0.0)
            return after, (after.commands[axis], place)

        rows = moving, noise if noisy else jnp.zeros((len(moving), 1))
        return lax.scan(sample, start(loop, fixed, jnp.zeros(()), row.start, quiet), rows)[1]

    return jax.vmap(one)(true, noise)
