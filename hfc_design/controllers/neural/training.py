"""A network off line: it is taught what another controller has commanded. Never imports JAX."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from hfc_design.controllers.kind import ControllerRecord
from hfc_design.controllers.neural.law import Weights, added, changes, passed
from hfc_design.controllers.neural.record import FASTEST, INPUTS, MOST, NeuralDesign, drawn
from hfc_design.core.arguments import positive, whole
from hfc_design.core.numbers import SCALARS, Floats, Json, each
from hfc_design.core.records import UserError, checked

#: Without units of its own a network counts errors in their root mean square, changes in twice
#: that, and commands in a tenth of theirs: about what goes well with the numbers of the paper.
CHANGE, COMMAND = 2.0, 0.1


class Lesson(NamedTuple):
    """How a network is taught."""

    hidden: int = 25  # units of a network that knows nothing
    seed: int = 0  # of its weights
    rate: float = 0.5  # eta off line
    passes: int = 1  # through all samples


class Trained(NamedTuple):
    """A network, and how far it is from what it was taught."""

    design: NeuralDesign
    before: float  # root mean square of its command less what is taught [unit of the command]
    after: float
    taught: float  # root mean square of what is taught


def begun(
    start: ControllerRecord | None, numbers: Json, lesson: Lesson, errors: Floats, commands: Floats
) -> NeuralDesign:
    """The network before its ``lesson``: that of ``start``, or one that knows nothing.

    ``numbers`` are keys of a ``NeuralDesign``.

    Raises:
        UserError: start is of another kind, or a number is not allowed.
    """
    if start is not None and not isinstance(start, NeuralDesign):
        raise UserError(f"--start: is of kind {start.kind}; has to be of kind neural")
    for key, low, high in (("hidden", 1, MOST), ("seed", 0, None), ("passes", 1, None)):
        whole(f"--{key}", getattr(lesson, key), low, high)
    positive("--training-rate", lesson.rate)
    if lesson.rate > FASTEST:
        raise UserError(f"--training-rate {lesson.rate:g}: has to be {FASTEST:g} at most")
    if start is not None:
        data = start.model_dump()
    else:
        error, command = (_usual(own) for own in (errors, commands))
        data = {"weights": drawn(lesson.hidden, lesson.seed).model_dump(), "error_unit": error}
        data |= {"change_unit": CHANGE * error, "command_unit": COMMAND * command}
    return checked(NeuralDesign, data | numbers, "--network", Path())


def _usual(values: Floats) -> float:
    """The root mean square in two digits; 1 of what is always 0."""
    found = float(np.sqrt(np.mean(values * values)))
    return float(f"{found:.2g}") or 1.0


def trained(start: NeuralDesign, errors: Floats, commands: Floats, lesson: Lesson) -> Trained:
    """The ``start`` after a ``lesson``: every sample moves the weights, those of the axes in turn.

    Args:
        start: the network, its units, its slope and its momentum.
        errors: (samples, axes) what the controller that it learns from has read.
        commands: (samples, axes) what that has commanded then.
        lesson: its rate and its passes.

    Raises:
        UserError: it diverges.
    """
    inputs = inputs_of(start, errors).reshape(-1, INPUTS)
    targets = (commands / start.command_unit).ravel()
    found = start.network()
    last = Weights(*(each(lambda weight: 0.0, layer) for layer in found))
    rates = lesson.rate, start.momentum, start.slope
    for _ in range(lesson.passes):
        for own, target in zip(inputs.tolist(), targets.tolist(), strict=True):
            answer = passed(SCALARS, found, start.slope, own)
            off = [target - answer.outputs[0]]
            last = changes(SCALARS, found, last, answer, off, *rates)
            found = added(found, last)
    design = start.with_weights(found)
    before, after = (_distance(one, inputs, targets) for one in (start, design))
    if not np.isfinite(after):
        told = f"--training-rate {lesson.rate:g}: the network diverges"
        raise UserError(f"{told}; take a lower one, larger units or a smaller slope")
    taught = float(np.sqrt(np.mean(commands * commands)))
    return Trained(design, before, after, taught)


def inputs_of(design: NeuralDesign, errors: Floats) -> Floats:
    """(samples, ..., 2) what the network reads of errors (samples, ...)."""
    change = np.diff(errors, axis=0, prepend=0.0 * errors[:1])
    return np.stack([errors / design.error_unit, change / design.change_unit], axis=-1)


def command(design: NeuralDesign, inputs: Floats) -> Floats:
    """(...) what the network commands for inputs (..., 2)."""
    hidden, output = map(np.array, (design.weights.hidden, design.weights.output))
    with np.errstate(all="ignore"):
        active = np.tanh(design.slope * (inputs @ hidden[:, :-1].T + hidden[:, -1]))
        return np.asarray(design.command_unit * (active @ output[:-1] + output[-1]))


def _distance(design: NeuralDesign, inputs: Floats, targets: Floats) -> float:
    with np.errstate(all="ignore"):
        off = command(design, inputs) - design.command_unit * targets
        return float(np.sqrt(np.mean(off * off)))
