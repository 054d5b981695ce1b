"""The neural controller in a design file and in a scenario. Never imports JAX."""

from operator import not_
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from hfc_design.controllers.gains import FEEDS, GainsSettings
from hfc_design.controllers.kind import ControllerRecord, Target, controller_named, reach_of
from hfc_design.controllers.neural.law import NeuralGains, NeuralMemory, Weights
from hfc_design.core.records import Finite, Positive, Record

INPUTS = 2  # error and its change
#: Units of the hidden layer: the loop is unrolled, more of them take minutes to compile.
MOST = 100
#: Largest rate of learning: one of 1e12 is a slip, and leaves nothing of what was known.
FASTEST = 1e6
Hidden = Annotated[tuple[Finite, ...], Field(min_length=INPUTS + 1, max_length=INPUTS + 1)]
Rate = Annotated[float, Field(ge=0, le=FASTEST, allow_inf_nan=False)]


class WeightsRecord(Record):
    """Weights of both layers, the threshold of a unit behind those of what it reads."""

    #: of each hidden unit: on error, on its change, threshold [1]
    hidden: Annotated[tuple[Hidden, ...], Field(min_length=1, max_length=MOST)]
    output: tuple[Finite, ...]  # on each hidden unit, threshold [1]

    @model_validator(mode="after")
    def _fit(self) -> "WeightsRecord":
        units, found = len(self.hidden), len(self.output)
        if found != units + 1:
            told = f"has {found} numbers; {units} hidden units and a threshold make {units + 1}"
            raise ValueError(f"output: {told}")
        return self


class NeuralDesign(ControllerRecord):
    """A controller of kind ``neural``; see ``NeuralGains``."""

    kind: Literal["neural"] = "neural"
    weights: WeightsRecord  # what the network begins with
    error_unit: Positive  # error that the network reads as 1 [error]
    change_unit: Positive  # change of the error in a sample that it reads as 1 [error]
    command_unit: Positive  # command of an output of 1 [command]
    rate: Rate = 1e-4  # of learning on line, eta; 0: it does not learn [1]
    momentum: Annotated[float, Field(ge=0, lt=1)] = 0.005  # alpha, share of the step before [1]
    slope: Positive = 1e-3  # lambda of the hidden units, tanh(lambda net) [1]
    #: weight of the change in the error of the output [1]
    xi: Annotated[float, Field(ge=0, le=1)] = 0.5

    def gains(self) -> NeuralGains:
        """The numbers beside the weights."""
        return NeuralGains(*(getattr(self, name) for name in NeuralGains._fields))

    def reach(self, limit: float | None) -> dict[str, float]:
        """Where the network to begin with, were all its weights of one sign, commands the limit."""
        hidden = list(zip(self.weights.hidden, self.weights.output, strict=False))
        first = self.command_unit * self.slope
        error, change = (first * sum(abs(row[k] * out) for row, out in hidden) for k in (0, 1))
        gains = {"error": error / self.error_unit, "error_change": change / self.change_unit}
        return reach_of(gains, limit)

    def network(self) -> Weights:
        """What it begins with."""
        return Weights(self.weights.hidden, (self.weights.output,))

    def adapted(self, memory: NeuralMemory) -> "NeuralDesign | None":
        """With the weights as they have become; None: they stay."""
        return self.with_weights(memory.weights) if self.rate else None

    def with_weights(self, weights: Weights) -> "NeuralDesign":
        """The same with other weights."""
        hidden, (output,) = weights
        found = WeightsRecord.model_construct(hidden=_rows(hidden), output=tuple(output))
        return self.model_copy(update={"weights": found})


def _rows(layer: Any) -> tuple[tuple[float, ...], ...]:
    return tuple(map(tuple, layer))


def drawn(hidden: int, seed: int) -> WeightsRecord:
    """Weights of a network that knows nothing, uniform between -1 and 1."""
    random = np.random.default_rng(seed)
    layers = random.uniform(-1.0, 1.0, (hidden, INPUTS + 1)), random.uniform(-1.0, 1.0, hidden + 1)
    return WeightsRecord.model_validate(
        {"hidden": _rows(layers[0].tolist()), "output": tuple(layers[1].tolist())}
    )


#: What is searched, on a milling table: errors in mm and commands in V.
RANGES = NeuralGains(
    (1e-3, 0.1), (1e-3, 0.1), (0.1, 20.0), (1e-6, 0.1), (1e-3, 0.9), (1e-4, 0.1), (0.0, 1.0)
)


class NeuralSettings(GainsSettings):
    """Ranges of the numbers beside the weights, and the network to begin with."""

    own_ranges = RANGES
    own_plants = FEEDS
    kind: Literal["neural"]
    #: a design whose weights it begins with; left out: ``hidden`` units that know nothing
    start: NeuralDesign | None = Field(None, exclude_if=not_)
    #: units of the hidden layer of a network that begins with nothing
    hidden: int = Field(25, ge=1, le=MOST)
    seed: int = Field(0, ge=0)  # that its first weights are drawn with

    _controller_of = field_validator("start", mode="before")(controller_named)

    def fault(self, target: Target) -> str | None:
        """A start that runs at another sample time, or ranges that are for other plants."""
        if self.start is not None and self.start.sample_time_s != target.sample_time:
            return (
                f"controller.start: runs every {self.start.sample_time_s} s, "
                f"simulation.sample_time_s is {target.sample_time}"
            )
        return super().fault(target)

    def weights(self) -> WeightsRecord:
        """What every individual begins with."""
        return self.start.weights if self.start is not None else drawn(self.hidden, self.seed)
