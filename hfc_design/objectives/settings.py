"""What counts as good in a scenario, and over which parts of the motion metrics are read."""

from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field, Tag, model_validator

from hfc_design.core.records import BUILT_IN, OWN, Name, NotNegative, Positive, Record, by_kind
from hfc_design.motion.samples import Simulation
from hfc_design.objectives.fitness import OWN_FITNESSES, Fitness, contour, lin_lee


class LinLeeSettings(Record):
    """Weights a and b of LL eq. 5, and from when on the metrics look at the settled motion."""

    kind: Literal["lin-lee"] = "lin-lee"
    error: NotNegative = 3.0
    error_rate: NotNegative = 0.1
    settled_after_s: NotNegative = 1.0

    @model_validator(mode="after")
    def _weighs_something(self) -> "LinLeeSettings":
        if not self.error and not self.error_rate:
            raise ValueError("one of the two weights has to be positive")
        return self

    def fitness(self) -> Fitness:
        """The same as functions."""
        return lin_lee(self.error, self.error_rate)


class ContourSettings(Record):
    """Contour error of an X-Y machine; see ``fitness.contour``."""

    kind: Literal["contour"] = "contour"
    worst: NotNegative = 0.3  # weight of the largest contour error
    lag: NotNegative = 0.01  # weight of the lag
    settled_after_s: NotNegative = 1.0

    def fitness(self) -> Fitness:
        """The same as functions."""
        return contour(self.worst, self.lag)


class OwnFitnessSettings(Record):
    """A user's own fitness, by its name."""

    kind: Annotated[Name, AfterValidator(OWN_FITNESSES.checked)]
    settled_after_s: NotNegative = 1.0

    def fitness(self) -> Fitness:
        """The same as functions."""
        return OWN_FITNESSES.get(self.kind)


FitnessSettings = Annotated[
    Annotated[LinLeeSettings | ContourSettings, Field(discriminator="kind"), Tag(BUILT_IN)]
    | Annotated[OwnFitnessSettings, Tag(OWN)],
    by_kind(*OWN_FITNESSES.built_in),
]


class Window(Record):
    """A part of the motion over which every metric is read once more, a cycle for example."""

    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,31}$")]  # stands before the metric's
    from_s: NotNegative = 0.0
    to_s: Positive | None = None  # left out: to the end

    def part(self, simulation: Simulation) -> slice:
        """Its samples."""
        time = simulation.time
        end = None if self.to_s is None else int(np.searchsorted(time, self.to_s))
        return slice(int(np.searchsorted(time, self.from_s)), end)
