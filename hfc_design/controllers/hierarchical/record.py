"""PD plus a fuzzy hierarchy in a design file. Never imports JAX."""

from collections.abc import Iterable
from typing import Annotated, Any, Literal

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from hfc_design.controllers.hierarchical.law import HierarchicalGains, Layout
from hfc_design.controllers.hierarchical.root import Adaptation
from hfc_design.controllers.hierarchical.unit import Term
from hfc_design.controllers.kind import ControllerRecord
from hfc_design.controllers.pd import PdRecord
from hfc_design.core.records import TERMS, Finite, Label, NotNegative, Positive, Record, Table


class InputRecord(Record):
    """One input of the hierarchy and its scale to the normalised universe."""

    name: Label
    scale: Positive


class TermRecord(Record):
    """One linguistic term: a Gaussian with a flat top (LL eq. 3)."""

    label: Label
    centre: Finite
    half_width: NotNegative
    rate: Positive


class UnitRecord(Record):
    """One unit: its place in the heap, its two inputs and its 7 x 7 singletons [row][column]."""

    id: int = Field(ge=0, le=1000)
    column_input: Label | Annotated[str, Field(pattern=r"^unit-\d{1,4}$")]
    row_input: Label | Annotated[str, Field(pattern=r"^unit-\d{1,4}$")]
    consequents: Table


class AdaptationRecord(Record):
    """How the root's consequents adapt on line, see ``root``."""

    k_c: NotNegative = 3e-4  # step of a consequent in a sample
    largest_move: Positive  # of a consequent from where it started
    error_scale: Positive | None = None  # [1/unit of error]; None: that of the input error

    def law(self) -> Adaptation:
        """The same as numbers."""
        return Adaptation(self.k_c, self.largest_move, self.error_scale)


def check_adaptation(adaptation: AdaptationRecord | None, inputs: Iterable[InputRecord]) -> None:
    """Whether the error that judges the root's rules has a scale.

    Raises:
        ValueError: it has none.
    """
    if adaptation is None or adaptation.error_scale is not None:
        return
    if "error" not in [item.name for item in inputs]:
        raise ValueError(
            "adaptation.error_scale: is missing, and no input is named error whose scale could "
            "stand for it"
        )


class HierarchicalDesign(ControllerRecord):
    """A controller of kind ``pd+hierarchical-fuzzy``; units in evaluation order, the root last."""

    kind: Literal["pd+hierarchical-fuzzy"] = "pd+hierarchical-fuzzy"
    pd: PdRecord
    inputs: Annotated[tuple[InputRecord, ...], Field(min_length=2, max_length=6)]
    output_scale: Positive
    terms: Annotated[tuple[TermRecord, ...], Field(min_length=TERMS, max_length=TERMS)]
    units: Annotated[tuple[UnitRecord, ...], Field(min_length=1, max_length=5)]
    adaptation: AdaptationRecord | None = None  # of the root; None: its table stays

    @model_serializer(mode="wrap")
    def _without_what_is_absent(self, whole: SerializerFunctionWrapHandler) -> dict[str, Any]:
        data: dict[str, Any] = whole(self)
        if adaptation := data.pop("adaptation", None):
            data["adaptation"] = {k: v for k, v in adaptation.items() if v is not None}
        return data

    @model_validator(mode="after")
    def _is_a_tree(self) -> "HierarchicalDesign":
        waiting = [item.name for item in self.inputs]
        if len(set(waiting)) < len(waiting):
            raise ValueError(f"inputs: a name stands there twice: {', '.join(waiting)}")
        if len({term.label for term in self.terms}) < TERMS:
            raise ValueError("terms: a label stands there twice")
        for unit in self.units:
            for source in (unit.column_input, unit.row_input):
                if source not in waiting:
                    raise ValueError(
                        f"units: unit {unit.id} reads {source!r}, which is not an input or an "
                        "earlier unit whose value is still free"
                    )
                waiting.remove(source)
            waiting.append(f"unit-{unit.id}")
        if waiting != [f"unit-{self.units[-1].id}"]:
            raise ValueError(f"units: nothing reads {', '.join(waiting[:-1])}")
        check_adaptation(self.adaptation, self.inputs)
        return self

    def sources(self) -> list[tuple[int, int]]:
        """Column and row source of each unit, as ``tree.Unit`` numbers them."""
        names = [item.name for item in self.inputs] + [f"unit-{unit.id}" for unit in self.units]
        return [
            (names.index(unit.column_input), names.index(unit.row_input)) for unit in self.units
        ]

    def layout(self) -> Layout:
        """What is no number of it."""
        return Layout(
            tuple(item.name for item in self.inputs),
            self.output_scale,
            tuple(Term(**term.model_dump()) for term in self.terms),
            self.adaptation.law() if self.adaptation else None,
        )

    def gains(self) -> HierarchicalGains:
        """The gains of one individual."""
        return HierarchicalGains(
            self.pd.kp,
            self.pd.kd,
            tuple(item.scale for item in self.inputs),
            tuple(self.sources()),
            tuple(unit.consequents for unit in self.units),
        )
