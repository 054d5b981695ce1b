"""Neural control of an axis (Huang et al., section 3). Never imports JAX.

A network commands the axis by its error and the change of that, and learns on line, sample by
sample. Written for one axis in scalars; ``xp`` as in ``core.numbers``.

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

from typing import NamedTuple

from hfc_design.controllers.controller import AxisLaw, Signals, stood
from hfc_design.controllers.neural.network import Weights, added, changes, passed
from hfc_design.core.numbers import Scalar, Xp, each


class NeuralGains(NamedTuple):
    """What is searched: one individual, or a population in the trailing axis."""

    error_unit: Scalar  # error of an input of 1 [error]
    change_unit: Scalar  # change in a sample of an input of 1 [error]
    command_unit: Scalar  # command of an output of 1 [command]
    rate: Scalar  # of learning on line, eta [1]
    momentum: Scalar  # alpha, share of the step before [1]
    slope: Scalar  # of the hidden units, lambda [1]
    xi: Scalar  # weight of the change in the error of the output [1]


class NeuralMemory(NamedTuple):
    """What the controller remembers."""

    error: Scalar  # e(k-1)
    weights: Weights
    moved: Weights  # by what in the sample before


def neural(start: Weights, sample_time: float, limit: float | None = None) -> AxisLaw:
    """The law that begins with the weights ``start``."""
    return AxisLaw(sample, initial_memory, sample_time, limit, start, prime=stood)


def initial_memory(law: AxisLaw, zero: Scalar) -> NeuralMemory:
    """Memory before the first sample: the axis stood on its reference."""
    start = (each(lambda weight: zero + weight, layer) for layer in law.structure)
    still = (each(lambda weight: zero, layer) for layer in law.structure)
    return NeuralMemory(zero, Weights(*start), Weights(*still))


def sample(
    xp: Xp, law: AxisLaw, gains: NeuralGains, memory: NeuralMemory, signals: Signals
) -> tuple[Scalar, NeuralMemory, None]:
    """The command of the network as it is, and what it learns from the error."""
    error = signals["error"]
    e = xp.once(xp.ratio(error, gains.error_unit))
    ce = xp.once(xp.ratio(error - memory.error, gains.change_unit))
    found = passed(xp, memory.weights, gains.slope, (e, ce))
    command = gains.command_unit * found.outputs[0]
    told = (1.0 - gains.xi) * e + gains.xi * ce
    if law.limit is not None:
        told = xp.where((abs(command) > law.limit) & (command * told > 0.0), 0.0 * told, told)
    rates = gains.rate, gains.momentum, gains.slope
    moved = changes(xp, memory.weights, memory.moved, found, (told,), *rates)
    return command, NeuralMemory(error, added(memory.weights, moved), moved), None
