"""The ranges in which a search looks for gains."""

from typing import ClassVar

from pydantic import model_validator

from hfc_design.controllers.gains.law import Range, Ranges, range_fault
from hfc_design.controllers.kind import ControllerSettings
from hfc_design.core.records import Finite, Label


class GainsSettings(ControllerSettings):
    """A controller whose gains are a few numbers."""

    own_ranges: ClassVar[Ranges]  # of the kind
    ranges: dict[Label, tuple[Finite, Finite]] = {}  # other than the kind's own

    @model_validator(mode="after")
    def _fit(self) -> "GainsSettings":
        own = self.own_ranges._fields
        for name, pair in self.ranges.items():
            fault = range_fault(pair) if name in own else f"unknown; there is {', '.join(own)}"
            if fault:
                raise ValueError(f"ranges.{name}: {fault}")
        return self

    def searched(self) -> Ranges:
        """The ranges to search, a NamedTuple of the kind's."""
        changed: dict[str, Range] = dict(self.ranges)
        return self.own_ranges._replace(**changed)
