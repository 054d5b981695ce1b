"""The machine of a scenario: which plant, its limits, what its sensors see."""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, model_validator

from hfc_design.core.plugins import Group
from hfc_design.core.records import Finite, NotNegative, Positive, Record
from hfc_design.files.design import Label
from plants import PLANTS, Plant, plant_fault

#: Every plant that a scenario can name.
ALL_PLANTS: Group[Plant] = Group(
    "plant", Plant, "hfc_design.plants", PLANTS, frozenset(PLANTS), plant_fault
)


class PlantSettings(Record):
    """Which plant, and the parameters that differ from its nominal machine.

    A machine of several axes names them in ``axes``, each with what differs once more.
    """

    name: Annotated[str, AfterValidator(ALL_PLANTS.checked)] = "c-axis"
    parameters: dict[str, Finite] = {}
    axes: dict[Label, dict[str, Finite]] = {}

    @model_validator(mode="after")
    def _known(self) -> "PlantSettings":
        for place, changes in self._changes().items():
            fault = self.plant.fault(changes)
            if fault:
                raise ValueError(place + fault)
        return self

    def _changes(self) -> dict[str, dict[str, float]]:
        """What differs from the nominal machine in each axis, with its place in a message."""
        own = {f"axes.{name}: ": changes for name, changes in self.axes.items()}
        return {place: self.parameters | changes for place, changes in (own or {"": {}}).items()}

    @property
    def plant(self) -> Plant:
        """The plant's functions."""
        return PLANTS[self.name]

    def values(self) -> tuple[Any, ...]:
        """The parameter record of each axis."""
        return tuple(self.plant.parameters(**changes) for changes in self._changes().values())


class Limits(Record):
    """Limits of the drive, in the units of the plant."""

    command: Positive | None = None


class SensorSettings(Record):
    """What the controller sees of the machine, in the units of the plant; ideal without any."""

    encoder_resolution: NotNegative = 0.0
    noise: NotNegative = 0.0  # standard deviation of every encoder reading
    seed: int = Field(0, ge=0)
    velocity: Literal["tachometer", "encoder"] = "tachometer"
