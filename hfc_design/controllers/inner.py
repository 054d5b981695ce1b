"""The record of a controller that has another one inside. Never imports JAX."""

from pydantic import model_validator

from hfc_design.controllers.kind import ControllerRecord
from hfc_design.controllers.per_axis import OwnRecord, sampled_alike
from hfc_design.core.numbers import Plain


class OuterDesign(ControllerRecord):
    """``inner`` is one controller for every axis, or ``per-axis``, or any of a whole machine."""

    inner: OwnRecord

    @model_validator(mode="before")
    @classmethod
    def _sampled_alike(cls, data: Plain) -> Plain:
        """What is inside takes the sample time of the whole where it says none."""
        if not isinstance(data, dict) or not isinstance(data.get("inner"), dict):
            return data
        every = {key: data[key] for key in ("sample_time_s",) if key in data}
        return data | {"inner": every | data["inner"]}

    @model_validator(mode="after")
    def _steps_at_once(self) -> "OuterDesign":
        sampled_alike("inner", self.inner, self.sample_time_s)
        return self
