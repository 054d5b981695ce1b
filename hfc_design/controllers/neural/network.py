"""A network of two layers that learns by back-propagation with momentum (Huang et al., eq. 10-14).

Hidden units are tanh, outputs linear; each has a threshold, which is a weight of 1. Written in
scalars; ``xp`` as in ``core.numbers``. Never imports JAX.
"""

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

from hfc_design.core.numbers import Scalar, Xp, dot, each

#: Weights of the units of a layer, a row each: of what comes in, last the threshold.
Layer: TypeAlias = Sequence[Sequence[Scalar]]


class Weights(NamedTuple):
    """Both layers."""

    hidden: Layer  # (units, inputs + 1)
    output: Layer  # (outputs, units + 1)


class Passed(NamedTuple):
    """What a network makes of its inputs."""

    inputs: Sequence[Scalar]
    hidden: Sequence[Scalar]  # of each hidden unit, -1 to 1
    outputs: Sequence[Scalar]


def passed(xp: Xp, weights: Weights, slope: Scalar, inputs: Sequence[Scalar]) -> Passed:
    """Forwards (eq. 10 and 11): ``tanh(slope * net)`` in the hidden layer."""
    hidden = [xp.once(xp.tanh(slope * net)) for net in _nets(weights.hidden, inputs)]
    return Passed(inputs, hidden, _nets(weights.output, hidden))


def _nets(layer: Layer, values: Sequence[Scalar]) -> list[Scalar]:
    """(units,) weighted sum of what comes in, and the threshold."""
    return [dot(weights[:-1], values) + weights[-1] for weights in layer]


def changes(
    xp: Xp,
    weights: Weights,
    before: Weights,
    found: Passed,
    errors: Sequence[Scalar],
    rate: Scalar,
    momentum: Scalar,
    slope: Scalar,
) -> Weights:
    """By what the weights move (eq. 12 to 14): down the squares of the output ``errors``.

    ``before`` is what they moved by before.
    """
    deltas = [xp.once(rate * error) for error in errors]
    columns = [*zip(*weights.output, strict=True)][:-1]
    back = []
    for unit, column in zip(found.hidden, columns, strict=True):
        back.append(xp.once(dot(deltas, column) * slope * (1.0 - unit * unit)))

    def moved(deltas: Sequence[Scalar], values: Sequence[Scalar], layer: Layer) -> Layer:
        steps = [[*(delta * value for value in values), delta] for delta in deltas]
        return each(lambda step, last: step + momentum * last, steps, layer)

    hidden = moved(back, found.inputs, before.hidden)
    return Weights(hidden, moved(deltas, found.hidden, before.output))


def added(weights: Weights, steps: Weights) -> Weights:
    """Weights that have moved."""
    return Weights(
        *(
            each(lambda weight, step: weight + step, *layers)
            for layers in zip(weights, steps, strict=True)
        )
    )
