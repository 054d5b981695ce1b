"""Neural control of an axis (Huang et al., section 3). Never imports JAX.

A network of two layers commands the axis by the error and its change, and learns on line,
sample by sample, by back-propagation with momentum (eq. 10-14). Hidden units are tanh, outputs
linear; each has a threshold, which is a weight of 1. Written for one axis in scalars; ``xp`` as in
``core.numbers``.

Interpretation of the paper where it leaves a choice:

- Its two outputs are the commands of two axes, and its two inputs are those of the controller that
  it learns from, the error and its change: each axis has a network of two inputs and one output.
  One network from the errors of both axes to both commands has no damping, and on the simulated
  table leaves more than twice the error at a reversal.
- The right command is not known. As in the paper's self-organising controller the
  error of an output is ``(1 - xi) e + xi ce``, both as the network reads them, with xi = 0.5.
- Only the name of lambda = 0.001 is legible, next to a momentum alpha = 0.005 (eq. 12). It is read
  as the slope of the hidden units, ``tanh(lambda net)``: the equation of tanh is the lost one, and
  with a slope of 1 the printed rate of 0.5 diverges off line.
- Thresholds are weights on a constant 1, and move like other weights (eq. 13).
- If a command is at its limit and its error asks for more, the network does not learn.
"""

from collections.abc import Sequence
from operator import add, mul
from typing import NamedTuple, TypeAlias

from hfc_design.controllers.controller import AxisLaw, Signals, stood
from hfc_design.core.numbers import Scalar, Xp, total

#: Weights of a layer, a row for each unit: on its inputs, then the threshold.
Layer: TypeAlias = Sequence[Sequence[Scalar]]


class Weights(NamedTuple):
    """Weights of both layers."""

    hidden: Layer  # (units, inputs + 1)
    output: Layer  # (outputs, units + 1)


class Passed(NamedTuple):
    """Inputs of a network and their activations."""

    inputs: Sequence[Scalar]
    hidden: Sequence[Scalar]  # of each hidden unit, -1 to 1
    outputs: Sequence[Scalar]


def passed(xp: Xp, weights: Weights, slope: Scalar, inputs: Sequence[Scalar]) -> Passed:
    """Forward pass (eq. 10 and 11): ``tanh(slope * net)`` in the hidden layer."""

    def net(row: Sequence[Scalar], values: Sequence[Scalar]) -> Scalar:
        return xp.total(xp.along(mul, row[:-1], values)) + row[-1]

    def unit(row: Sequence[Scalar]) -> Scalar:
        return xp.once(xp.tanh(slope * net(row, inputs)))

    hidden = xp.stored(xp.along(unit, weights.hidden))
    return Passed(inputs, hidden, [net(row, hidden) for row in weights.output])


def changes(
    xp: Xp,
    weights: Weights,
    before: Weights,
    activations: Passed,
    errors: Sequence[Scalar],
    rate: Scalar,
    momentum: Scalar,
    slope: Scalar,
) -> Weights:
    """Steps of the weights (eq. 12 to 14): descent on the squares of the output ``errors``.

    ``before`` are the previous steps.
    """
    deltas = [xp.once(rate * error) for error in errors]

    def behind(j: Scalar, unit: Scalar) -> Scalar:
        ahead = [delta * row[j] for delta, row in zip(deltas, weights.output, strict=True)]
        return xp.once(total(ahead) * slope * (1.0 - unit * unit))

    back = xp.stored(xp.along(behind, range(len(activations.hidden)), activations.hidden))

    def moved(deltas: Sequence[Scalar], values: Sequence[Scalar], layer: Layer) -> Layer:
        values, last = xp.table(values), len(values)  # then the threshold, a weight of 1

        def row(delta: Scalar, before: Sequence[Scalar]) -> Sequence[Scalar]:
            def step(k: Scalar, before: Scalar) -> Scalar:
                # Not where(): there is no value of the threshold.
                return xp.when(k < last, lambda: delta * values[k], delta) + momentum * before

            return xp.along(step, range(last + 1), before)

        return xp.along(row, deltas, layer)

    hidden = moved(back, activations.inputs, before.hidden)
    return Weights(hidden, moved(deltas, activations.hidden, before.output))


def added(xp: Xp, weights: Weights, steps: Weights) -> Weights:
    """Return the weights moved by ``steps``."""
    return Weights(*(xp.each(add, *layers) for layers in zip(weights, steps, strict=True)))


class NeuralGains(NamedTuple):
    """Searched numbers: one individual, or a population in the trailing axis."""

    error_unit: Scalar  # error of an input of 1 [error]
    change_unit: Scalar  # change in a sample of an input of 1 [error]
    command_unit: Scalar  # command of an output of 1 [command]
    rate: Scalar  # learning rate on line, eta [1]
    momentum: Scalar  # alpha, share of the previous step [1]
    slope: Scalar  # of the hidden units, lambda [1]
    xi: Scalar  # weight of the change in the error of the output [1]


class NeuralMemory(NamedTuple):
    """Memory of the controller."""

    error: Scalar  # e(k-1)
    weights: Weights
    moved: Weights  # by what in the sample before


def neural(start: Weights, sample_time: float, limit: float | None = None) -> AxisLaw:
    """Return the law with the initial weights ``start``."""
    return AxisLaw(sample, initial_memory, sample_time, limit, start, tells=True, prime=stood)


def initial_memory(law: AxisLaw, zero: Scalar) -> NeuralMemory:
    """Return the memory before the first sample: the axis at rest on its reference."""
    start = ([[zero + weight for weight in row] for row in layer] for layer in law.structure)
    still = ([[zero] * len(row) for row in layer] for layer in law.structure)
    return NeuralMemory(zero, Weights(*start), Weights(*still))


def sample(
    xp: Xp, law: AxisLaw, gains: NeuralGains, memory: NeuralMemory, signals: Signals
) -> tuple[Scalar, NeuralMemory, None]:
    """Return the network's command, and the memory after learning from the error."""
    error = signals["error"]
    e = xp.once(xp.ratio(error, gains.error_unit))
    ce = xp.once(xp.ratio(error - memory.error, gains.change_unit))
    activations = passed(xp, memory.weights, gains.slope, (e, ce))
    command = gains.command_unit * activations.outputs[0]
    training_error = (1.0 - gains.xi) * e + gains.xi * ce
    if law.limit is not None:
        training_error = xp.where(
            (abs(command) > law.limit) & (command * training_error > 0.0),
            0.0 * training_error,
            training_error,
        )
    rates = gains.rate, gains.momentum, gains.slope
    moved = changes(xp, memory.weights, memory.moved, activations, (training_error,), *rates)
    # Not finite where a weight would not be any more.
    command = command + 0.0 * (training_error * training_error * (e * e + ce * ce))
    return command, NeuralMemory(error, added(xp, memory.weights, moved), moved), None
