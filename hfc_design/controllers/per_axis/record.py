"""A controller of its own for every axis, in a design file and in a scenario. Never imports JAX."""

from typing import Annotated, Literal

from pydantic import Field, SerializeAsAny, model_validator

from hfc_design.controllers.kind import ControllerRecord, ControllerSettings, Target, kinds
from hfc_design.core.plugins import chosen
from hfc_design.core.records import Label
from hfc_design.core.shapes import Gains, Plain

OwnRecord = Annotated[SerializeAsAny[ControllerRecord], chosen(kinds, "record")]
OwnSettings = Annotated[SerializeAsAny[ControllerSettings], chosen(kinds, "settings")]


class PerAxisDesign(ControllerRecord):
    """Controllers of any kinds, by the names of the machine's axes and in their order."""

    kind: Literal["per-axis"] = "per-axis"
    axes: Annotated[dict[Label, OwnRecord], Field(min_length=1)]

    @model_validator(mode="before")
    @classmethod
    def _sampled_alike(cls, data: Plain) -> Plain:
        """Axes take the sample time of the whole where they say none."""
        if not isinstance(data, dict) or not isinstance(data.get("axes"), dict):
            return data
        every = {key: data[key] for key in ("sample_time_s",) if key in data}
        axes = {k: every | own if isinstance(own, dict) else own for k, own in data["axes"].items()}
        return data | {"axes": axes}

    @model_validator(mode="after")
    def _steps_at_once(self) -> "PerAxisDesign":
        for axis, own in self.axes.items():
            if own.sample_time_s != self.sample_time_s:
                raise ValueError(
                    f"axes.{axis}.sample_time_s = {own.sample_time_s}: has to be that of all, "
                    f"{self.sample_time_s}"
                )
        return self

    def gains(self) -> tuple[Gains, ...]:
        """The gains of each axis."""
        return tuple(kinds().get(own.kind).gains(own) for own in self.axes.values())


class PerAxisSettings(ControllerSettings):
    """What a search varies on every axis."""

    kind: Literal["per-axis"]
    axes: Annotated[dict[Label, OwnSettings], Field(min_length=1)]

    def fault(self, target: Target) -> str | None:
        """Other axes than the machine's, or one that its kind cannot be searched for."""
        if tuple(self.axes) != target.machine.axes:
            return f"controller.axes: have to be {', '.join(target.machine.axes)}, in this order"
        for k, (axis, own) in enumerate(self.axes.items()):
            if fault := own.fault(target.of(k)):
                return fault.replace("controller.", f"controller.axes.{axis}.", 1)
        return None
