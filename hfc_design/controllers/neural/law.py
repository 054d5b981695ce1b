"""Neural control of a whole machine (Huang et al., section 3). Never imports JAX.

One network for all axes, with the tracking error of each for an input and the command of each for
an output. It learns on line, sample by sample, written for one machine in scalars.

How the paper is read where it leaves a choice:

- Two inputs, two outputs, one network: the errors and the commands of X and Y. A network an axis
  would have one output.
- No command is known that would have been right, so the tracking error of an axis stands for the
  error of its output: a table that lags needs more of it.
- Of lambda = 0.001 only its name is printed, beside a momentum alpha = 0.005 (eq. 12). It is read
  as the slope of the hidden units, tanh(lambda net): the equation of tanh is the one that is lost,
  and with a slope of 1 the printed rate of 0.5 diverges off line.
- Thresholds are weights of a 1, and move like them (eq. 13).
- Where a command is at its limit and its error asks for more, its output learns nothing.
"""

from typing import NamedTuple

from hfc_design.controllers.controller import Stepped, View, limited
from hfc_design.controllers.neural.network import Weights, added, changes, passed
from hfc_design.core.numbers import Scalar, Xp, each


class NeuralGains(NamedTuple):
    """What is searched: one individual, or a population in the trailing axis."""

    error_unit: Scalar  # of an input [unit of the error]
    command_unit: Scalar  # of an output [unit of the command]
    rate: Scalar  # eta
    momentum: Scalar  # alpha
    slope: Scalar  # lambda


class NeuralMemory(NamedTuple):
    """What the controller remembers."""

    weights: Weights
    moved: Weights  # by what in the sample before


class Neural(NamedTuple):
    """The controller of a machine."""

    kind: str
    start: Weights
    limits: tuple[float | None, ...]  # largest command of each axis

    def initial_memory(self, zero: Scalar) -> NeuralMemory:
        """Memory before the first sample: the network as the design has it, at rest."""
        start = (each(lambda weight: zero + weight, layer) for layer in self.start)
        still = (each(lambda weight: zero, layer) for layer in self.start)
        return NeuralMemory(Weights(*start), Weights(*still))

    def step(self, xp: Xp, gains: NeuralGains, memory: NeuralMemory, view: View) -> Stepped:
        """The commands of the network as it is, and what it learns from the errors."""
        errors = [xp.ratio(signals["error"], gains.error_unit) for signals in view.axes]
        found = passed(xp, memory.weights, gains.slope, errors)
        asked = [gains.command_unit * output for output in found.outputs]
        told = [_told(xp, *own) for own in zip(self.limits, asked, errors, strict=True)]
        rates = gains.rate, gains.momentum, gains.slope
        moved = changes(xp, memory.weights, memory.moved, found, told, *rates)
        pairs = zip(self.limits, asked, strict=True)
        commands = tuple(limited(xp, limit, command) for limit, command in pairs)
        return commands, NeuralMemory(added(memory.weights, moved), moved)


def _told(xp: Xp, limit: float | None, command: Scalar, error: Scalar) -> Scalar:
    """What an output is told: its error, or nothing where the command could follow no further."""
    if limit is None:
        return error
    return xp.where((abs(command) > limit) & (command * error > 0.0), 0.0 * error, error)
