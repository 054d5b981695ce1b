"""Neural control of an axis (Huang et al., section 3). Never imports JAX.

A network of two layers commands the axis by its error and the change of that, and learns on line,
sample by sample, by back-propagation with momentum (eq. 10-14). Hidden units are tanh, outputs
linear; each has a threshold, which is a weight of 1. Written for one axis in scalars; ``xp`` as in
``core.numbers``.

How the paper is read where it leaves a choice:

- Its two outputs are the commands of two axes, and its two inputs are those of the controller that
  it learns from, the error and its change: so each axis has a network of two inputs and one output.
  One network from the errors of both axes to both commands has no damping, and on the simulated
  table leaves more than twice the error at a reversal.
- No command is known that would have been right. As in the paper's self-organising controller the
  error of an output is ``(1 - xi) e + xi ce``, both as the network reads them, with xi = 0.5.
- Of lambda = 0.001 only its name is left, beside a momentum alpha = 0.005 (eq. 12). It is read as
  the slope of the hidden units, ``tanh(lambda net)``: the equation of tanh is the one that is lost,
  and with a slope of 1 the printed rate of 0.5 diverges off line.
- Thresholds are weights of a 1, and move like them (eq. 13).
- Where a command is at its limit and its error asks for more, it learns nothing.
"""

from collections.abc import Sequence
from operator import add, mul
from typing import NamedTuple, TypeAlias

from hfc_design.controllers.controller import AxisLaw, Signals, stood
from hfc_design.core.numbers import Scalar, Xp, total

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
    """By what the weights move (eq. 12 to 14): down the squares of the output ``errors``.

    ``before`` is what they moved by before.
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
    """Weights that have moved."""
    return Weights(*(xp.each(add, *layers) for layers in zip(weights, steps, strict=True)))


class NeuralGains(NamedTuple):
    """What is searched: one individual, or a population in the trailing axis."""

    error_unit: Scalar  # error of an input of 1 [error]
    change_unit: Scalar  # change in a sample of an input of 1 [error]
    command_unit: Scalar  # command of an output of 1 [command]
    rate: Scalar  # learning rate on line, eta [1]
    momentum: Scalar  # alpha, share of the previous step [1]
    slope: Scalar  # of the hidden units, lambda [1]
    xi: Scalar  # weight of the change in the error of the output [1]


class NeuralMemory(NamedTuple):
    """What the controller remembers."""

    error: Scalar  # e(k-1)
    weights: Weights
    moved: Weights  # by what in the sample before


def neural(start: Weights, sample_time: float, limit: float | None = None) -> AxisLaw:
    """The law that begins with the weights ``start``."""
    return AxisLaw(sample, initial_memory, sample_time, limit, start, tells=True, prime=stood)


def initial_memory(law: AxisLaw, zero: Scalar) -> NeuralMemory:
    """Memory before the first sample: the axis stood on its reference."""
    start = ([[zero + weight for weight in row] for row in layer] for layer in law.structure)
    still = ([[zero] * len(row) for row in layer] for layer in law.structure)
    return NeuralMemory(zero, Weights(*start), Weights(*still))


def sample(
    xp: Xp, law: AxisLaw, gains: NeuralGains, memory: NeuralMemory, signals: Signals
) -> tuple[Scalar, NeuralMemory, None]:
    """The command of the network as it is, and what it learns from the error."""
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
