"""The two-input fuzzy controller in a design file. Never imports JAX."""

import sys
from collections.abc import Sequence
from itertools import pairwise
from math import inf
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from hfc_design.controllers.flc.law import Compensation, FlcGains
from hfc_design.controllers.kind import ControllerRecord
from hfc_design.core.records import TERMS, Finite, Positive, Record, Table
from hfc_design.stability.sectors import Triangle, sectors_at_centres, true_sectors

#: Linguistic labels, negative large to positive large.
LABELS = ("NL", "NM", "NS", "ZR", "PS", "PM", "PL")
#: JK04 Table 3: centroid of each label in units of the command.
CENTROIDS = (-32.0, -16.0, -8.0, 0.0, 8.0, 16.0, 32.0)
#: Length of a BLU [mm] where a design says none.
BLU_MM = 0.01
TermLabel = Literal["NL", "NM", "NS", "ZR", "PS", "PM", "PL"]
LabelRow = Annotated[tuple[TermLabel, ...], Field(min_length=TERMS, max_length=TERMS)]
LabelTable = Annotated[tuple[LabelRow, ...], Field(min_length=TERMS, max_length=TERMS)]


class TriangleRecord(Record):
    """One linguistic term: a triangle (JK04 eq. 1). An edge of null is infinite.

    So is one that is left out: TOML has no null.
    """

    label: TermLabel
    left: Finite | None = None  # [BLU]
    centre: Finite  # [BLU]
    right: Finite | None = None  # [BLU]


Triangles = Annotated[tuple[TriangleRecord, ...], Field(min_length=TERMS, max_length=TERMS)]


class RulesRecord(Record):
    """The rule base, rows by error and columns by its change, both NL to PL."""

    labels: LabelTable
    centroids: Table  # units of the command


class CompensationRecord(Record):
    """Low-velocity compensation in units of the command (JK04 eq. 28-30), V in mm/s."""

    forward: tuple[Finite, Finite, Finite]  # coefficients of V^2, V, 1 for V >= 0
    backward: tuple[Finite, Finite, Finite]  # the same for V < 0
    highest_velocity_mm_s: Positive
    breakaway: tuple[Finite, Finite]  # command at rest towards + and towards -
    smallest_error: Positive  # [BLU]
    blu_mm: Positive = BLU_MM  # length of a BLU

    @model_serializer(mode="wrap")
    def _without_what_is_usual(self, whole: SerializerFunctionWrapHandler) -> dict[str, Any]:
        data: dict[str, Any] = whole(self)
        if data["blu_mm"] == BLU_MM:
            del data["blu_mm"]
        return data

    def law(self) -> Compensation:
        """The same as numbers."""
        return Compensation(
            self.forward,
            self.backward,
            self.highest_velocity_mm_s,
            self.breakaway,
            self.smallest_error,
            self.blu_mm,
        )


class FuzzyRecord(ControllerRecord):
    """What the three fuzzy kinds have in common."""

    error_terms: Triangles
    error_change_terms: Triangles
    rules: RulesRecord
    integral_gain: Finite  # [units/(BLU s)]
    low_velocity: CompensationRecord | None = None
    adapts: ClassVar[bool] = False

    @model_validator(mode="after")
    def _has_no_gap(self) -> "FuzzyRecord":
        for key in ("error_terms", "error_change_terms"):
            if fault := terms_fault(getattr(self, key)):
                raise ValueError(f"{key}: {fault}")
        return self

    def control_form(self) -> str:
        """Of JK95 eq. 1; only an flc can choose."""
        return "PD"

    def adaptation_limit(self) -> dict[str, tuple[float, float]]:
        """(K_1, K_2) that an adaptation may not pass, if there is one."""
        return {}

    def held(self) -> Self:
        """The same without adaptation."""
        return self

    def reads(self) -> list[str]:
        """Signals of a sample."""
        return ["error", "velocity"] if self.low_velocity else ["error"]

    def on(self, drive: Any, parameters: Any) -> Self:
        """The same for a drive whose positions count in other lengths."""
        if self.low_velocity is None or drive.millimetres is None:
            return self
        low = self.low_velocity.model_copy(update={"blu_mm": drive.millimetres(parameters)})
        return self.model_copy(update={"low_velocity": low})

    def table(self) -> FlcGains:
        """The fuzzy controller of one individual."""
        low = self.low_velocity
        return FlcGains(
            _edges(self.error_terms),
            _edges(self.error_change_terms),
            self.rules.centroids,
            self.integral_gain,
            low.law() if low else None,
        )


class FlcDesign(FuzzyRecord):
    """A controller of kind ``flc``; ``form`` as in JK95 eq. 1."""

    kind: Literal["flc"] = "flc"
    form: Literal["P", "PI", "PD"] = "PD"

    def control_form(self) -> str:
        """The one that it has."""
        return self.form

    def gains(self) -> FlcGains:
        """The gains of one individual."""
        return self.table()


def _edges(terms: tuple[TriangleRecord, ...]) -> tuple[tuple[float, float, float], ...]:
    return tuple(
        (
            -inf if term.left is None else term.left,
            term.centre,
            inf if term.right is None else term.right,
        )
        for term in terms
    )


def terms_fault(terms: tuple[TriangleRecord, ...]) -> str | None:
    """What is wrong with a row of terms, in one line; None if nothing is."""
    if [term.label for term in terms] != list(LABELS):
        return f"has to hold the labels {', '.join(LABELS)} in this order"
    for k, term in enumerate(terms):
        if (term.left is None) != (k == 0) or (term.right is None) != (k == TERMS - 1):
            return f"{term.label}: null has to stand left of NL and right of PL and nowhere else"
    edges = _edges(terms)
    for term, (left, centre, right) in zip(terms, edges, strict=True):
        if not left < centre < right:
            return f"{term.label}: left, centre, right = {left}, {centre}, {right} have to rise"
    for (low, high), (a, b) in zip(pairwise(terms), pairwise(edges), strict=True):
        if a[2] <= b[0]:
            return (
                f"there is a gap between {low.label}, right {a[2]}, and {high.label}, left {b[0]}"
            )
        if not (a[1] <= b[0] and a[2] <= b[1]):
            return f"an edge between {low.label} and {high.label} passes the other's centre"
    return None


def points(record: FuzzyRecord) -> dict[str, tuple[float, float]]:
    """(K_1, K_2) of the rule table [unit/BLU], by how they were found."""
    error, change = (
        [Triangle(term.left, term.centre, term.right) for term in terms]
        for terms in (record.error_terms, record.error_change_terms)
    )
    table = record.rules.centroids
    at_centres = sectors_at_centres(
        [term.centre for term in error], [term.centre for term in change], table
    )
    with_edges = true_sectors(error, change, table)
    found = {
        "table, eq. 13 and 14": (at_centres.k1, at_centres.k2),
        "table, with its edges": (with_edges.k1, with_edges.k2),
    }
    return found | record.adaptation_limit()


def nearest_labels(table: Sequence[Sequence[float]]) -> list[list[str]]:
    """The label of each singleton whose usual height, in shares of the largest, is nearest."""
    largest = max(*(abs(u) for row in table for u in row), sys.float_info.min)

    def label(singleton: float) -> str:
        share = singleton / largest
        return min(LABELS, key=lambda x: abs(share - CENTROIDS[LABELS.index(x)] / CENTROIDS[-1]))

    return [[label(u) for u in row] for row in table]
