"""A network off line: what another controller has commanded, taught by back-propagation.

Never imports JAX.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hfc_design.controllers.neural.network import Weights, added, changes, passed
from hfc_design.controllers.neural.record import NeuralDesign
from hfc_design.core.numbers import SCALARS, Floats, each
from hfc_design.core.records import UserError


class Trained(NamedTuple):
    """A network, and how far it is from what it was taught."""

    design: NeuralDesign
    before: float  # root mean square of its outputs less what is taught [unit of the command]
    after: float


def trained(
    start: NeuralDesign,
    errors: Floats,
    commands: Floats,
    rate: float = 0.5,
    passes: int = 1,
) -> Trained:
    """The ``start`` after so many passes through samples, each of which moves its weights.

    Args:
        start: network, units of its inputs and outputs, slope and momentum.
        errors: (samples, axes) what the controller that it learns from has read.
        commands: (samples, axes) what that has commanded then.
        rate: of learning off line, eta.
        passes: through all samples, in their order.

    Raises:
        UserError: it diverges, or the samples are of another number of axes.
    """
    axes = len(start.weights.output)
    if errors.shape != commands.shape or errors.shape[1:] != (axes,):
        shapes = f"{errors.shape} and {commands.shape}"
        raise UserError(f"errors and commands are {shapes}; the network has {axes} axes")
    inputs, targets = errors / start.error_unit, commands / start.command_unit
    found, last = start.network(), Weights(*(each(_zero, layer) for layer in start.network()))
    samples = [*zip(inputs.tolist(), targets.tolist(), strict=True)]
    for _ in range(passes):
        for own, wanted in samples:
            told = passed(SCALARS, found, start.slope, own)
            off = [a - b for a, b in zip(wanted, told.outputs, strict=True)]
            last = changes(SCALARS, found, last, told, off, rate, start.momentum, start.slope)
            found = added(found, last)
    design = start.with_weights(found)
    before, after = (_distance(one, inputs, targets) for one in (start, design))
    if not np.isfinite(after):
        raise UserError(f"rate = {rate}: training diverges; take a lower one, or larger units")
    return Trained(design, before, after)


def _zero(weight: float) -> float:
    return 0.0 * weight


def outputs(design: NeuralDesign, inputs: Floats) -> Floats:
    """(samples, axes) what the network makes of inputs (samples, axes), both in its units."""
    hidden, output = map(np.array, (design.weights.hidden, design.weights.output))
    with np.errstate(all="ignore"):
        active = np.tanh(design.slope * (inputs @ hidden[:, :-1].T + hidden[:, -1]))
        return np.asarray(active @ output[:, :-1].T + output[:, -1])


def _distance(design: NeuralDesign, inputs: Floats, targets: Floats) -> float:
    with np.errstate(all="ignore"):
        off = outputs(design, inputs) - targets
        return float(design.command_unit * np.sqrt(np.mean(off * off)))


def samples_of(told: Sequence[Floats]) -> Floats:
    """(samples, axes) of a series for each axis."""
    return np.stack([np.asarray(own, np.float64) for own in told], axis=1)
