"""What a search for a hierarchy starts from: inputs, scales, terms."""

from typing import Any, Literal, NamedTuple

from pydantic import Field, model_validator

from hfc_design.controllers.hierarchical.law import LIN_LEE_INPUTS, PREVIOUS, Layout
from hfc_design.controllers.hierarchical.record import (
    AdaptationRecord,
    InputRecord,
    TermRecord,
    check_adaptation,
    layout_of,
)
from hfc_design.controllers.hierarchical.tree import MAX_INPUTS
from hfc_design.controllers.hierarchical.unit import LIN_LEE_TERMS
from hfc_design.controllers.kind import ControllerSettings, Target
from hfc_design.core.records import TERMS, Positive


class HierarchicalSettings(ControllerSettings):
    """Inputs, scales and terms of the hierarchical fuzzy controller."""

    kind: Literal["pd+hierarchical-fuzzy"] = "pd+hierarchical-fuzzy"
    inputs: tuple[InputRecord, ...] = Field(
        tuple(InputRecord(name=name, scale=scale) for name, scale in LIN_LEE_INPUTS.items()),
        min_length=2,
        max_length=MAX_INPUTS,
    )
    output_scale: Positive = 10.0
    terms: tuple[TermRecord, ...] = Field(
        tuple(TermRecord(**term._asdict()) for term in LIN_LEE_TERMS),
        min_length=TERMS,
        max_length=TERMS,
    )
    adaptation: AdaptationRecord | None = None  # of the root; None: its table stays

    @model_validator(mode="after")
    def _can_adapt(self) -> "HierarchicalSettings":
        check_adaptation(self.adaptation, self.inputs)
        return self

    def fault(self, target: Target) -> str | None:
        """An input that is no signal of every axis, or one that stands there twice."""
        names = [item.name for item in self.inputs]
        for drive in target.machine.drives:
            known = input_names(drive.inputs)
            for name in names:
                if name not in known:
                    return (
                        f"controller.inputs: {name!r} is no signal of the {drive.name}; "
                        f"there is {', '.join(known)}"
                    )
                if names.count(name) > 1:
                    return f"controller.inputs: {name!r} stands there twice"
        return None

    def scales(self) -> tuple[float, ...]:
        """Those that the search starts around."""
        return tuple(item.scale for item in self.inputs)

    def layout(self) -> Layout:
        """What the search leaves alone."""
        return layout_of(self)


class Bounds(NamedTuple):
    """On the C-axis; the ``[search]`` of a scenario may have other values under these keys."""

    kp_range: tuple[float, float] = (100.0, 10_000.0)  # of the first individuals [V/rad]
    kd_range: tuple[float, float] = (30.0, 3_000.0)  # [V s/rad]
    scale_range: float = 10.0  # factor around the layout's scales; 1: they stay
    inner_limit: float = 4.0  # |consequent| of an inner unit
    root_limit: float = 20.0  # |consequent| of the root


def bounds_of(search: Any) -> Bounds:
    """The bounds that the settings of a search have, else the defaults."""
    found = {key: getattr(search, key) for key in Bounds._fields if hasattr(search, key)}
    return Bounds()._replace(**found)


def input_names(signals: list[str]) -> list[str]:
    """Every input that a hierarchy can have of an axis with these signals."""
    return signals + [f"{PREVIOUS}{name}" for name in signals]
