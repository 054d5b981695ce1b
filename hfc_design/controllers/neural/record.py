"""The neural controller in a design file and in a scenario. Never imports JAX."""

from operator import not_
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationInfo, field_validator, model_validator

from hfc_design.controllers.gains import GainsSettings
from hfc_design.controllers.kind import ControllerRecord, Limits, Target, controller_named
from hfc_design.controllers.neural.law import Neural, NeuralGains, NeuralMemory
from hfc_design.controllers.neural.network import Weights
from hfc_design.core.numbers import Json, Plain
from hfc_design.core.records import Finite, NotNegative, Positive, Record, UserError

#: Units of the hidden layer: the loop is unrolled, more of them take minutes to compile.
MOST = 100
Rows = Annotated[tuple[tuple[Finite, ...], ...], Field(min_length=1, max_length=MOST)]


class WeightsRecord(Record):
    """Both layers: a row of weights for each unit, its threshold last."""

    hidden: Rows  # (units, axes + 1)
    output: Rows  # (axes, units + 1)

    @model_validator(mode="after")
    def _fit(self) -> "WeightsRecord":
        units, axes = len(self.hidden), len(self.output)
        for key, rows, before in (("hidden", self.hidden, axes), ("output", self.output, units)):
            for k, row in enumerate(rows):
                if len(row) != before + 1:
                    told = f"weights.{key}.{k}: has {len(row)} numbers"
                    unit = "as many errors" if key == "hidden" else f"{units} hidden units"
                    raise ValueError(
                        f"{told}; with {axes} outputs, {unit} and a threshold it is {before + 1}"
                    )
        return self


class NeuralDesign(ControllerRecord):
    """A controller of kind ``neural``; its inputs are the tracking errors of all axes."""

    kind: Literal["neural"] = "neural"
    weights: WeightsRecord
    error_unit: Positive  # an input counts the error in it [unit of the position]
    command_unit: Positive  # an output counts the command in it [unit of the command]
    rate: NotNegative  # of learning on line, eta; 0: it does not
    momentum: Annotated[float, Field(ge=0, lt=1)]  # alpha
    slope: Positive = 1.0  # of the hidden units, lambda

    def gains(self) -> NeuralGains:
        """The numbers beside the weights."""
        return NeuralGains(*(getattr(self, name) for name in NeuralGains._fields))

    def network(self) -> Weights:
        """What it begins with."""
        return Weights(self.weights.hidden, self.weights.output)

    def controller(self, limits: Limits) -> Neural:
        """On axes with these limits.

        Raises:
            UserError: the network is one for another number of axes.
        """
        outputs = len(self.weights.output)
        if outputs != len(limits):
            axes = ", ".join(limits)
            raise UserError(f"controller.weights: are for {outputs} axes; the machine has {axes}")
        return Neural(self.kind, self.network(), tuple(limits.values()))

    def learnt(self, axes: tuple[str, ...], memory: NeuralMemory) -> "NeuralDesign | None":
        """With the weights as they have become; None: they stay."""
        return self.with_weights(memory.weights) if self.rate else None

    def with_weights(self, weights: Weights) -> "NeuralDesign":
        """The same with other weights."""
        hidden, output = (tuple(map(tuple, layer)) for layer in weights)
        found = WeightsRecord.model_construct(hidden=hidden, output=output)
        return self.model_copy(update={"weights": found})


def drawn(axes: int, hidden: int, seed: int) -> Weights:
    """Weights of a network that knows nothing, uniform between -1 and 1."""
    random = np.random.default_rng(seed)
    shapes = ((hidden, axes + 1), (axes, hidden + 1))
    return Weights(*(random.uniform(-1.0, 1.0, shape).tolist() for shape in shapes))


#: What is searched: on a milling table, errors in mm and commands in V.
RANGES = NeuralGains((5e-4, 0.5), (0.1, 20.0), (1e-6, 0.1), (1e-3, 0.9), (1e-3, 1.0))


class NeuralSettings(GainsSettings):
    """Ranges of the numbers beside the weights, and the network to begin with."""

    own_ranges = RANGES
    kind: Literal["neural"]
    #: A design whose weights it begins with; None: ``hidden`` units that know nothing.
    start: Any = Field(None, exclude_if=not_)
    hidden: int = Field(25, ge=1, le=MOST)
    seed: int = Field(0, ge=0)

    @field_validator("start", mode="before")
    @classmethod
    def _controller_of(cls, start: Plain, info: ValidationInfo) -> Plain:
        """The controller of the design that ``start`` names; a record stays one."""
        found = controller_named(start, info)
        return found if found is None else NeuralDesign.model_validate(found)

    def fault(self, target: Target) -> str | None:
        """A start for another machine."""
        if self.start is None:
            return None
        axes, outputs = target.machine.axes, len(self.start.weights.output)
        if outputs != len(axes):
            return f"controller.start: is for {outputs} axes; the machine has {', '.join(axes)}"
        return None

    def weights(self, axes: int) -> Json:
        """What every individual begins with."""
        if self.start is not None:
            return dict(self.start.weights)
        return drawn(axes, self.hidden, self.seed)._asdict()
