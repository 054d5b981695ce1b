"""Records of the neural controller in design files and scenarios. Never imports JAX."""

from operator import not_
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field, field_validator, model_validator

from hfc_design.controllers.controller import AxisLaw
from hfc_design.controllers.gains import FEEDS, GainsSettings
from hfc_design.controllers.kind import (
    CHANGES,
    ControllerRecord,
    Target,
    controller_named,
    input_ranges,
    later,
    sampled_otherwise,
)
from hfc_design.controllers.neural.law import (
    NeuralGains,
    NeuralMemory,
    Weights,
    added,
    changes,
    neural,
    passed,
)
from hfc_design.core.arguments import check_positive, check_whole
from hfc_design.core.numbers import SCALARS, Floats, Json, each
from hfc_design.core.records import Finite, Positive, Record, UserError, checked, either, option

INPUTS = 2  # error and its change
#: Largest number of hidden units: their loop is unrolled, so that more take minutes to compile.
MOST = 100
#: Largest learning rate: a rate such as 1e12 is a typing error and would spoil all weights.
FASTEST = 1e6
Hidden = Annotated[tuple[Finite, ...], Field(min_length=INPUTS + 1, max_length=INPUTS + 1)]
Rate = Annotated[float, Field(ge=0, le=FASTEST, allow_inf_nan=False)]


class WeightsRecord(Record):
    """Weights of both layers; the threshold of a unit follows the weights on its inputs."""

    #: weights of each hidden unit: on the error, on its change, the threshold [1]
    hidden: Annotated[tuple[Hidden, ...], Field(min_length=1, max_length=MOST)]
    output: tuple[Finite, ...]  # weights on the hidden units, then the threshold [1]

    @model_validator(mode="after")
    def _fit(self) -> "WeightsRecord":
        units, count = len(self.hidden), len(self.output)
        if count != units + 1:
            needed = f"{units + 1} numbers, one per hidden unit and a threshold"
            raise ValueError(f"output: must have {needed} (got {count})")
        return self


class NeuralDesign(ControllerRecord):
    """Design of kind ``neural``; see ``NeuralGains``."""

    kind: Literal["neural"] = "neural"
    summary = "a network trained off line on another controller, then on line (Huang et al.)"
    settings = later(".record", "NeuralSettings")
    genome = later(".", "NeuralGenome")
    pictures = later(".section", "pictures")
    sections = later(".section", "sections")
    weights: WeightsRecord  # initial weights of the network
    error_unit: Positive  # error that the network reads as 1 [error]
    change_unit: Positive  # change of the error in a sample that the network reads as 1 [error]
    command_unit: Positive  # command of an output of 1 [command]
    rate: Rate = 1e-4  # learning rate on line, eta [1]; 0: no learning
    momentum: Annotated[float, Field(ge=0, lt=1)] = 0.005  # alpha, share of the previous step [1]
    slope: Positive = 1e-3  # lambda of the hidden units, tanh(lambda net) [1]
    #: weight of the error's change in the error of the output; the error itself has 1 - xi [1]
    xi: Annotated[float, Field(ge=0, le=1)] = 0.5

    def law_gains(self) -> NeuralGains:
        """Return the numbers of this design besides the weights."""
        return NeuralGains(*(getattr(self, name) for name in NeuralGains._fields))

    def law(self, limit: float | None) -> AxisLaw:
        """Return the law of one axis."""
        return neural(self.network(), self.sample_time_s, limit)

    def reads(self) -> list[str]:
        """Return the signals that the controller reads; it computes the change of the error."""
        return ["error"]

    def connecting(self) -> list[str]:
        """Return a note that the controller computes the change of the error itself."""
        return [CHANGES]

    def input_range(self, limit: float | None) -> dict[str, float]:
        """Return inputs that command ``limit`` if weights have one sign and no unit saturates."""
        hidden = list(zip(self.weights.hidden, self.weights.output, strict=False))
        first = self.command_unit * self.slope
        error, change = (first * sum(abs(row[k] * out) for row, out in hidden) for k in (0, 1))
        gains = {"error": error / self.error_unit, "error_change": change / self.change_unit}
        return input_ranges(gains, limit)

    def network(self) -> Weights:
        """Return the initial weights as the law reads them."""
        return Weights(self.weights.hidden, (self.weights.output,))

    def adapted(self, memory: NeuralMemory) -> "NeuralDesign | None":
        """Return the design with the learned weights; None if its learning rate is 0."""
        return self.with_weights(memory.weights) if self.rate else None

    def with_weights(self, weights: Weights) -> "NeuralDesign":
        """Return the design with other weights."""
        hidden, (output,) = weights
        record = WeightsRecord.model_construct(hidden=_rows(hidden), output=tuple(output))
        return self.model_copy(update={"weights": record})


def _rows(layer: Any) -> tuple[tuple[float, ...], ...]:
    return tuple(map(tuple, layer))


def drawn(hidden: int, seed: int) -> WeightsRecord:
    """Return random weights of an untrained network, uniform between -1 and 1."""
    random = np.random.default_rng(seed)
    first, second = (random.uniform(-1.0, 1.0, x) for x in ((hidden, INPUTS + 1), hidden + 1))
    return WeightsRecord(hidden=_rows(first.tolist()), output=tuple(second.tolist()))


#: Search ranges on a milling table: errors in mm and commands in V.
RANGES = NeuralGains(
    (1e-3, 0.1), (1e-3, 0.1), (0.1, 20.0), (1e-6, 0.1), (1e-3, 0.9), (1e-4, 0.1), (0.0, 1.0)
)


class NeuralSettings(GainsSettings):
    """Settings of a search: ranges of the numbers besides the weights, and the initial weights."""

    own_ranges = RANGES
    own_plants = FEEDS
    kind: Literal["neural"]
    #: design with the initial weights; left out: untrained
    start: NeuralDesign | None = Field(None, exclude_if=not_)
    #: hidden units of an untrained network
    hidden: int = Field(25, ge=1, le=MOST)
    seed: int = Field(0, ge=0)  # random seed of the initial weights

    _controller_of = field_validator("start", mode="before")(controller_named)

    def fault(self, target: Target) -> str | None:
        """Return why the search is impossible (sample time or ranges), or None."""
        return sampled_otherwise(self.start, target) or super().fault(target)

    def weights(self) -> WeightsRecord:
        """Return the initial weights of every individual."""
        return self.start.weights if self.start is not None else drawn(self.hidden, self.seed)


#: Default units, which suit the numbers of the paper: that of changes as a multiple of the root
#: mean square of the errors, that of commands as a multiple of that of the commands.
CHANGE, COMMAND = 2.0, 0.1


class Lesson(NamedTuple):
    """Settings of the training of a network."""

    hidden: int = 25  # number of hidden units of an untrained network
    seed: int = 0  # random seed of the weights of an untrained network
    rate: float = 0.5  # learning rate off line, eta
    passes: int = 1  # passes through all samples


class Trained(NamedTuple):
    """Trained network and its root mean square errors in the unit of the command."""

    design: NeuralDesign
    before: float  # of the network's command less the training command, before the training
    after: float  # the same after the training
    taught: float  # root mean square of the training commands themselves


def begun(
    start: ControllerRecord | None, numbers: Json, lesson: Lesson, errors: Floats, commands: Floats
) -> NeuralDesign:
    """Return the network before its training: ``start``, or an untrained one by ``lesson``.

    ``numbers`` are values for keys of the ``NeuralDesign``.

    Raises:
        UserError: ``start`` is of another kind, or a number is not allowed.
    """
    if start is not None and not isinstance(start, NeuralDesign):
        raise UserError(f"{option('start')}: must be of kind neural (got {start.kind})")
    for key, low, high in (("hidden", 1, MOST), ("seed", 0, None), ("passes", 1, None)):
        check_whole(key, getattr(lesson, key), low, high)
    check_positive("training_rate", lesson.rate, argument="rate")
    if lesson.rate > FASTEST:
        given = either(f"--training-rate {lesson.rate:g}", f"rate={lesson.rate:g}")
        raise UserError(f"{given}: must be at most {FASTEST:g}")
    if start is not None:
        data = start.model_dump()
    else:
        usual = (np.sqrt(np.mean(values * values)) for values in (errors, commands))
        error, command = (float(f"{size:.2g}") or 1.0 for size in usual)  # 1 if all values are 0
        data = {"weights": drawn(lesson.hidden, lesson.seed).model_dump(), "error_unit": error}
        data |= {"change_unit": CHANGE * error, "command_unit": COMMAND * command}
    return checked(NeuralDesign, data | numbers, option("network"), Path())


def trained(start: NeuralDesign, errors: Floats, commands: Floats, lesson: Lesson) -> Trained:
    """Train the network ``start``: every sample of every axis in turn moves the weights.

    Args:
        start: the network, with its units, its slope and its momentum.
        errors: (samples, axes) errors that the controller read from which the network learns.
        commands: (samples, axes) commands of that controller.
        lesson: learning rate and number of passes; the rest of it is not used.

    Raises:
        UserError: the network diverges.
    """
    inputs = inputs_of(start, errors).reshape(-1, INPUTS)
    targets = (commands / start.command_unit).ravel()
    network = start.network()
    last = Weights(*(each(lambda weight: 0.0, layer) for layer in network))
    rates = lesson.rate, start.momentum, start.slope
    for _ in range(lesson.passes):
        for sample, target in zip(inputs.tolist(), targets.tolist(), strict=True):
            answer = passed(SCALARS, network, start.slope, sample)
            off = [target - answer.outputs[0]]
            last = changes(SCALARS, network, last, answer, off, *rates)
            network = added(SCALARS, network, last)
    design = start.with_weights(network)
    before, after = (_distance(one, inputs, targets) for one in (start, design))
    if not np.isfinite(after):
        given = either(f"--training-rate {lesson.rate:g}", f"rate={lesson.rate:g}")
        message = f"{given}: the network diverges"
        raise UserError(f"{message}; use a lower one, larger units or a smaller slope")
    taught = float(np.sqrt(np.mean(commands * commands)))
    return Trained(design, before, after, taught)


def inputs_of(design: NeuralDesign, errors: Floats) -> Floats:
    """Return the network's inputs (samples, ..., 2) for ``errors`` (samples, ...)."""
    change = np.diff(errors, axis=0, prepend=0.0 * errors[:1])
    return np.stack([errors / design.error_unit, change / design.change_unit], axis=-1)


def command(design: NeuralDesign, inputs: Floats) -> Floats:
    """Return the commands (...) of the network for inputs (..., 2)."""
    hidden, output = map(np.array, (design.weights.hidden, design.weights.output))
    with np.errstate(all="ignore"):
        active = np.tanh(design.slope * (inputs @ hidden[:, :-1].T + hidden[:, -1]))
        return np.asarray(design.command_unit * (active @ output[:-1] + output[-1]))


def _distance(design: NeuralDesign, inputs: Floats, targets: Floats) -> float:
    with np.errstate(all="ignore"):
        off = command(design, inputs) - design.command_unit * targets
        return float(np.sqrt(np.mean(off * off)))
