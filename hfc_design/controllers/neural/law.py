"""Neural control of an axis (Huang et al., section 3). Never imports JAX.

A network of two layers computes the command from the error and its change. It learns on line,
in every sample, by back-propagation with momentum (eq. 10-14). Hidden units are tanh, outputs are
linear; each unit has a threshold, the weight on an input of 1. The law is written for one axis in
scalars; ``xp`` as in ``core.numbers``.

Interpretation of the paper where it leaves a choice:

- The network of the paper has two outputs, the commands of two axes, and two inputs, the error and
  its change. Here each axis has a network of two inputs and one output. A single network from the
  errors of both axes to both commands has no damping, and on the simulated table leaves more than
  twice the error at a reversal.
- The right command is not known. As in the paper's self-organising controller, the error of an
  output is ``(1 - xi) e + xi ce``, with e and ce as the network reads them, and xi = 0.5.
- Only the name of lambda = 0.001 is legible, next to a momentum alpha = 0.005 (eq. 12). It is taken
  as the slope of the hidden units, ``tanh(lambda net)``: the equation of tanh is not legible, and
  with a slope of 1 the printed rate of 0.5 diverges off line.
- Thresholds are weights on a constant 1, and move like other weights (eq. 13).
- If a command is beyond its limit and learning would increase it further, nothing is learned.
"""

from collections.abc import Sequence
from operator import add, mul
from typing import NamedTuple, TypeAlias

from hfc_design.controllers.controller import AxisLaw, Signals, stood
from hfc_design.core.numbers import Scalar, Xp, total

#: Weights of a layer, a row for each unit: the weights on its inputs, then the threshold.
Layer: TypeAlias = Sequence[Sequence[Scalar]]


class Weights(NamedTuple):
    """Weights of both layers."""

    hidden: Layer  # (units, inputs + 1)
    output: Layer  # (outputs, units + 1)


class Passed(NamedTuple):
    """Inputs of a network, and the activations that follow from them."""

    inputs: Sequence[Scalar]
    hidden: Sequence[Scalar]  # activation of each hidden unit, -1 to 1
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

    ``errors`` has an error for each output; ``before`` are the previous steps.
    """
    deltas = [xp.once(rate * error) for error in errors]

    def behind(j: Scalar, unit: Scalar) -> Scalar:
        ahead = [delta * row[j] for delta, row in zip(deltas, weights.output, strict=True)]
        return xp.once(total(ahead) * slope * (1.0 - unit * unit))

    back = xp.stored(xp.along(behind, range(len(activations.hidden)), activations.hidden))

    def moved(deltas: Sequence[Scalar], values: Sequence[Scalar], layer: Layer) -> Layer:
        values, last = xp.table(values), len(values)  # index ``last``: the threshold

        def row(delta: Scalar, before: Sequence[Scalar]) -> Sequence[Scalar]:
            def step(k: Scalar, before: Scalar) -> Scalar:
                # Not where(), which would read values[last]; the input of the threshold is 1.
                return xp.when(k < last, lambda: delta * values[k], delta) + momentum * before

            return xp.along(step, range(last + 1), before)

        return xp.along(row, deltas, layer)

    hidden = moved(back, activations.inputs, before.hidden)
    return Weights(hidden, moved(deltas, activations.hidden, before.output))


def added(xp: Xp, weights: Weights, steps: Weights) -> Weights:
    """Return the weights moved by ``steps``."""
    return Weights(*(xp.each(add, *layers) for layers in zip(weights, steps, strict=True)))


class NeuralGains(NamedTuple):
    """Searched numbers of one individual; in a population, arrays over the individuals."""

    error_unit: Scalar  # error that the network reads as 1 [error]
    change_unit: Scalar  # change of the error in a sample that the network reads as 1 [error]
    command_unit: Scalar  # command of an output of 1 [command]
    rate: Scalar  # learning rate on line, eta [1]
    momentum: Scalar  # alpha, share of the previous step that is added [1]
    slope: Scalar  # lambda of the hidden units, tanh(lambda net) [1]
    xi: Scalar  # weight of the error's change in the error of the output; the error has 1 - xi [1]


class NeuralMemory(NamedTuple):
    """Memory of the controller."""

    error: Scalar  # error of the previous sample
    weights: Weights
    moved: Weights  # steps of the weights in the previous sample


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
    """Return the command of the network, the memory after learning from the error, and None."""
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
    # Makes the command infinite or nan if a new weight is not finite (``AxisLaw.tells``).
    command = command + 0.0 * (training_error * training_error * (e * e + ce * ce))
    return command, NeuralMemory(error, added(xp, memory.weights, moved), moved), None
