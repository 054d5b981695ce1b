"""The controller of a scenario: what the search starts from and may vary."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, Tag, ValidationInfo, model_validator

from hfc_design.controllers.flc.record import AflcDesign, FlcDesign
from hfc_design.controllers.gains.law import LAWS, Law, Range, range_fault
from hfc_design.controllers.hierarchical.tree import MAX_INPUTS
from hfc_design.controllers.hierarchical.unit import LIN_LEE_TERMS, Term
from hfc_design.controllers.kinds import Layout
from hfc_design.core.records import (
    BUILT_IN,
    OWN,
    TERMS,
    Finite,
    NotNegative,
    Positive,
    Record,
    UserError,
    by_kind,
)
from hfc_design.files.design import (
    AdaptationRecord,
    InputRecord,
    Label,
    LawName,
    TermRecord,
    check_adaptation,
    named_design,
)


def _default_inputs() -> tuple[InputRecord, ...]:
    layout = Layout()
    pairs = zip(layout.inputs, layout.scales, strict=True)
    return tuple(InputRecord(name=name, scale=scale) for name, scale in pairs)


class HierarchicalSettings(Record):
    """Inputs, scales and terms of the hierarchical fuzzy controller."""

    kind: Literal["pd+hierarchical-fuzzy"] = "pd+hierarchical-fuzzy"
    inputs: tuple[InputRecord, ...] = Field(
        default_factory=_default_inputs, min_length=2, max_length=MAX_INPUTS
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

    def layout(self) -> Layout:
        """The same for the closed loop."""
        return Layout(
            tuple(item.name for item in self.inputs),
            tuple(item.scale for item in self.inputs),
            self.output_scale,
            tuple(Term(**term.model_dump()) for term in self.terms),
            self.adaptation.law() if self.adaptation else None,
        )


def _controller_of(start: Any, info: ValidationInfo) -> Any:
    """The controller of the design that ``start`` names; a record stays one."""
    if not isinstance(start, str):
        return start
    path = Path((info.context or {}).get("folder", "")) / start
    try:
        design = named_design(str(path) if path.exists() else start)
    except UserError as error:
        raise ValueError(str(error)) from None
    return design.controller.model_dump()


Start = BeforeValidator(_controller_of)


class _FuzzySettings(Record):
    """Bounds of a search that begins with a fuzzy controller, or with a design's."""

    symmetric: bool = True  # both directions are treated alike
    largest_integral_gain: NotNegative = 8.0  # [units/(BLU s)]


class FlcSettings(_FuzzySettings):
    """A fuzzy controller of a feed drive."""

    kind: Literal["flc"]
    start: Annotated[FlcDesign, Start] = Field("jee-koren-2004-flc", validate_default=True)


class AflcSettings(_FuzzySettings):
    """A fuzzy controller of a feed drive that adapts."""

    kind: Literal["aflc"]
    start: Annotated[AflcDesign, Start] = Field("jee-koren-2004-aflc", validate_default=True)


class LawSettings(Record):
    """A law whose gains are a few numbers: pd, pid or a user's own."""

    kind: LawName
    ranges: dict[Label, tuple[Finite, Finite]] = {}  # other than the law's own

    @model_validator(mode="after")
    def _fit(self) -> "LawSettings":
        own = LAWS.get(self.kind).ranges._fields
        for name, pair in self.ranges.items():
            fault = range_fault(pair) if name in own else f"unknown; there is {', '.join(own)}"
            if fault:
                raise ValueError(f"ranges.{name}: {fault}")
        return self

    @property
    def law(self) -> Law:
        """The law with the ranges to search."""
        law = LAWS.get(self.kind)
        ranges: dict[str, Range] = law.ranges._asdict() | self.ranges
        return law._replace(ranges=type(law.ranges)(**ranges))


BuiltInSettings = HierarchicalSettings | FlcSettings | AflcSettings
ControllerSettings = Annotated[
    Annotated[BuiltInSettings, Field(discriminator="kind"), Tag(BUILT_IN)]
    | Annotated[LawSettings, Tag(OWN)],
    by_kind("pd+hierarchical-fuzzy", "flc", "aflc"),
]
