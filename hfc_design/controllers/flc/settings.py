"""What a search for a feed drive's fuzzy controller starts from."""

from typing import Annotated, Any, Literal

from pydantic import (
    BeforeValidator,
    Field,
    SerializerFunctionWrapHandler,
    ValidationInfo,
    model_serializer,
)

from hfc_design.controllers.flc.record import FlcDesign
from hfc_design.controllers.kind import ControllerSettings, Target
from hfc_design.core.records import TERMS, NotNegative, UserError
from hfc_design.core.shapes import Json, Plain


def _controller_of(start: Plain, info: ValidationInfo) -> Plain:
    """The controller of the design that ``start`` names; a record stays one."""
    if not isinstance(start, str):
        return start
    try:
        design = (info.context or {})["named_design"](start)
    except UserError as error:
        raise ValueError(str(error)) from None
    return design.controller.model_dump()


Start = BeforeValidator(_controller_of)


class FuzzySettings(ControllerSettings):
    """Bounds of a search that begins with a fuzzy controller, or with a design's."""

    start: Any
    symmetric: bool = True  # both directions are treated alike
    largest_integral_gain: NotNegative = 8.0  # [units/(BLU s)]

    @model_serializer(mode="wrap")
    def _kind_last(self, whole: SerializerFunctionWrapHandler) -> Json:
        """Where it always has been, as the cells of batches are named by the text."""
        data: Json = whole(self)
        kind = data.pop("kind")
        return {**data, "kind": kind}

    def fault(self, target: Target) -> str | None:
        """A plant without a stable range, or a start that cannot be one."""
        for drive in target.machine.drives:
            if drive.linear is None:
                return (
                    f"controller.kind = {self.kind!r}: is for a feed drive, not for the "
                    f"{drive.name}"
                )
        if self.start.sample_time_s != target.sample_time:
            return (
                f"controller.start: runs every {self.start.sample_time_s} s, "
                f"simulation.sample_time_s is {target.sample_time}"
            )
        for key in ("error_terms", "error_change_terms"):
            middle = getattr(self.start, key)[TERMS // 2]
            if middle.centre != 0.0:
                return (
                    f"controller.start: {middle.label} of its {key} is centred on "
                    f"{middle.centre}; a search keeps it on 0"
                )
        return None


class FlcSettings(FuzzySettings):
    """A fuzzy controller of a feed drive."""

    kind: Literal["flc"]
    start: Annotated[FlcDesign, Start] = Field("jee-koren-2004-flc", validate_default=True)
