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

HERE = "hfc_design.controllers.neural"

INPUTS = 2  # error and its change
#: Largest number of hidden units: the loop is unrolled, and more take minutes to compile.
MOST = 100
#: Largest learning rate: a rate such as 1e12 is a typing error and would erase what was learned.
FASTEST = 1e6
Hidden = Annotated[tuple[Finite, ...], Field(min_length=INPUTS + 1, max_length=INPUTS + 1)]
Rate = Annotated[float, Field(ge=0, le=FASTEST, allow_inf_nan=False)]


class WeightsRecord(Record):
    """Weights of both layers; the threshold of a unit follows the weights on its inputs."""

    #: weights of each hidden unit: on error, on its change, threshold [1]
    hidden: Annotated[tuple[Hidden, ...], Field(min_length=1, max_length=MOST)]
    output: tuple[Finite, ...]  # weights on each hidden unit, threshold [1]

    @model_validator(mode="after")
    def _fit(self) -> "WeightsRecord":
        units, count = len(self.hidden), len(self.output)
        if count != units + 1:
            message = (
                f"must have {units + 1} numbers, one per hidden unit and a threshold (got {count})"
            )
            raise ValueError(f"output: {message}")
        return self


class NeuralDesign(ControllerRecord):
    """Design of kind ``neural``; see ``NeuralGains``."""

    kind: Literal["neural"] = "neural"
    summary = "a network trained off line on another controller, then on line (Huang et al.)"
    settings = later(f"{HERE}.record", "NeuralSettings")
    genome = later(HERE, "NeuralGenome")
    pictures = later(f"{HERE}.section", "pictures")
    sections = later(f"{HERE}.section", "sections")
    weights: WeightsRecord  # initial weights of the network
    error_unit: Positive  # error that the network reads as 1 [error]
    change_unit: Positive  # change of the error in a sample that it reads as 1 [error]
    command_unit: Positive  # command of an output of 1 [command]
    rate: Rate = 1e-4  # learning rate on line, eta [1]; 0: no learning
    momentum: Annotated[float, Field(ge=0, lt=1)] = 0.005  # alpha, share of the previous step [1]
    slope: Positive = 1e-3  # lambda of the hidden units, tanh(lambda net) [1]
    #: weight of the change in the error of the output [1]
    xi: Annotated[float, Field(ge=0, le=1)] = 0.5

    def law_gains(self) -> NeuralGains:
        """Return the numbers besides the weights."""
        return NeuralGains(*(getattr(self, name) for name in NeuralGains._fields))

    def law(self, limit: float | None) -> AxisLaw:
        """Return the law of one axis."""
        return neural(self.network(), self.sample_time_s, limit)

    def reads(self) -> list[str]:
        """Signals that the controller reads; it forms the change of the error itself."""
        return ["error"]

    def connecting(self) -> list[str]:
        """Return a note on signals formed inside the controller."""
        return [CHANGES]

    def input_range(self, limit: float | None) -> dict[str, float]:
        """Ranges at which the initial network, with weights of one sign, commands the limit."""
        hidden = list(zip(self.weights.hidden, self.weights.output, strict=False))
        first = self.command_unit * self.slope
        error, change = (first * sum(abs(row[k] * out) for row, out in hidden) for k in (0, 1))
        gains = {"error": error / self.error_unit, "error_change": change / self.change_unit}
        return input_ranges(gains, limit)

    def network(self) -> Weights:
        """Return the initial weights."""
        return Weights(self.weights.hidden, (self.weights.output,))

    def adapted(self, memory: NeuralMemory) -> "NeuralDesign | None":
        """Return the design with the learned weights; None if it does not learn."""
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
    layers = random.uniform(-1.0, 1.0, (hidden, INPUTS + 1)), random.uniform(-1.0, 1.0, hidden + 1)
    return WeightsRecord.model_validate(
        {"hidden": _rows(layers[0].tolist()), "output": tuple(layers[1].tolist())}
    )


#: Search ranges on a milling table: errors in mm and commands in V.
RANGES = NeuralGains(
    (1e-3, 0.1), (1e-3, 0.1), (0.1, 20.0), (1e-6, 0.1), (1e-3, 0.9), (1e-4, 0.1), (0.0, 1.0)
)


class NeuralSettings(GainsSettings):
    """Settings of a search: ranges of the numbers besides the weights, and the initial network."""

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
        if self.start is not None and self.start.sample_time_s != target.sample_time:
            return (
                "controller.start: must have the sample time simulation.sample_time_s = "
                f"{target.sample_time} (got {self.start.sample_time_s})"
            )
        return super().fault(target)

    def weights(self) -> WeightsRecord:
        """Return the initial weights of every individual."""
        return self.start.weights if self.start is not None else drawn(self.hidden, self.seed)


#: Default units of changes and commands, which suit the numbers of the paper: changes are counted
#: in twice the root mean square of the errors, commands in a tenth of that of the commands.
CHANGE, COMMAND = 2.0, 0.1


class Lesson(NamedTuple):
    """Settings of the training of a network."""

    hidden: int = 25  # units of a network that knows nothing
    seed: int = 0  # of its weights
    rate: float = 0.5  # eta off line
    passes: int = 1  # through all samples


class Trained(NamedTuple):
    """Trained network and its distance from the training commands."""

    design: NeuralDesign
    before: float  # root mean square of its command less what is taught [unit of the command]
    after: float
    taught: float  # root mean square of what is taught


def begun(
    start: ControllerRecord | None, numbers: Json, lesson: Lesson, errors: Floats, commands: Floats
) -> NeuralDesign:
    """Return the network before its training (``lesson``): that of ``start``, or an untrained one.

    ``numbers`` are keys of a ``NeuralDesign``.

    Raises:
        UserError: start is of another kind, or a number is not allowed.
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
        error, command = (float(f"{size:.2g}") or 1.0 for size in usual)  # 1 of what is always 0
        data = {"weights": drawn(lesson.hidden, lesson.seed).model_dump(), "error_unit": error}
        data |= {"change_unit": CHANGE * error, "command_unit": COMMAND * command}
    return checked(NeuralDesign, data | numbers, option("network"), Path())


def trained(start: NeuralDesign, errors: Floats, commands: Floats, lesson: Lesson) -> Trained:
    """Train the network ``start`` by a ``lesson``: every sample moves the weights, axes in turn.

    Args:
        start: the network, its units, its slope and its momentum.
        errors: (samples, axes) read by the controller that the network learns from.
        commands: (samples, axes) given by that controller.
        lesson: its rate and its passes.

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
    """Return the inputs (samples, ..., 2) of the network from errors (samples, ...)."""
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
