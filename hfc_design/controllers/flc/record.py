"""Feed-drive controllers in a design file: kinds pid, flc, aflc, soflc. Never imports JAX."""

from itertools import pairwise
from math import inf
from typing import Annotated, Literal

from pydantic import Field, model_validator

from hfc_design.controllers.aflc.adaptation import Sectors
from hfc_design.controllers.aflc.law import AdaptiveGains, Rates
from hfc_design.controllers.flc.law import Compensation, FlcGains
from hfc_design.controllers.flc.rule_bases import LABELS
from hfc_design.controllers.pid.law import PidGains
from hfc_design.core.records import TERMS, Finite, NotNegative, Positive, Record, Table

TermLabel = Literal["NL", "NM", "NS", "ZR", "PS", "PM", "PL"]
LabelRow = Annotated[tuple[TermLabel, ...], Field(min_length=TERMS, max_length=TERMS)]
LabelTable = Annotated[tuple[LabelRow, ...], Field(min_length=TERMS, max_length=TERMS)]


class PidRecord(Record):
    """Gains of ``pid.step``."""

    k_p: Finite  # [units/BLU]
    k_i: Finite  # [units/(BLU s)]
    k_d: Finite  # [units s/BLU]


class PidDesign(Record):
    """A controller of kind ``pid``."""

    kind: Literal["pid"] = "pid"
    sample_time_s: Positive
    pid: PidRecord

    def gains(self) -> PidGains:
        """The gains of one individual."""
        return PidGains(self.pid.k_p, self.pid.k_i, self.pid.k_d)


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

    def law(self) -> Compensation:
        """The same as numbers."""
        return Compensation(
            self.forward,
            self.backward,
            self.highest_velocity_mm_s,
            self.breakaway,
            self.smallest_error,
        )


class FuzzyRecord(Record):
    """What the three fuzzy kinds have in common."""

    kind: str
    sample_time_s: Positive
    error_terms: Triangles
    error_change_terms: Triangles
    rules: RulesRecord
    integral_gain: Finite  # [units/(BLU s)]
    low_velocity: CompensationRecord | None = None

    @model_validator(mode="after")
    def _has_no_gap(self) -> "FuzzyRecord":
        for key in ("error_terms", "error_change_terms"):
            if fault := terms_fault(getattr(self, key)):
                raise ValueError(f"{key}: {fault}")
        return self

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

    def gains(self) -> FlcGains:
        """The gains of one individual."""
        return self.table()


class OverlapRecord(Record):
    """The least that two neighbouring terms overlap."""

    error: Positive  # [BLU]
    error_change: Positive  # [BLU]


class SectorsRecord(Record):
    """The rectangle that the table may not leave, see ``adaptation.Sectors``."""

    k1_max: Positive  # [units/BLU]
    k2_max: Positive  # [units/BLU]


class RatesRecord(Record):
    """Steps of the adaptation, see ``aflc.Rates``, and its bounds."""

    k_a: NotNegative  # [BLU]
    k_b: NotNegative  # [BLU]
    k_c: NotNegative  # units of the command
    smallest_overlap: OverlapRecord | None = None  # None: one step
    stable_range: SectorsRecord | None = None  # None: the table has no bounds, as in JK95

    def rates(self) -> Rates:
        """The same for the law."""
        least = self.smallest_overlap
        overlaps = (self.k_a, self.k_b) if least is None else (least.error, least.error_change)
        return Rates(self.k_a, self.k_b, self.k_c, *overlaps)


class BoundedRatesRecord(RatesRecord):
    """Steps of the adaptation; JK04 has it stay inside a stable range."""

    stable_range: SectorsRecord


class AdaptiveDesign(FuzzyRecord):
    """What the two adaptive kinds have in common."""

    adaptation: RatesRecord

    @model_validator(mode="after")
    def _steps_fit(self) -> "AdaptiveDesign":
        rates, least = self.adaptation, self.adaptation.smallest_overlap
        for key, step, name, terms in (
            ("k_a", rates.k_a, "error", self.error_terms),
            ("k_b", rates.k_b, "error_change", self.error_change_terms),
        ):
            room = min(upper.centre - lower.centre for lower, upper in pairwise(terms))
            limit = f"{room}, the smallest distance between two centres"
            if step >= room:
                raise ValueError(f"adaptation.{key} = {step}: has to be less than {limit}")
            overlap = 0.0 if least is None else getattr(least, name)
            if overlap > room:
                place = f"adaptation.smallest_overlap.{name}"
                raise ValueError(f"{place} = {overlap}: has to be at most {limit}")
        return self

    def gains(self) -> AdaptiveGains:
        """The gains of one individual."""
        limits = self.adaptation.stable_range
        sectors = None if limits is None else Sectors(limits.k1_max, limits.k2_max)
        return AdaptiveGains(self.table(), self.adaptation.rates(), sectors)


class AflcDesign(AdaptiveDesign):
    """A controller of kind ``aflc``."""

    kind: Literal["aflc"] = "aflc"
    adaptation: BoundedRatesRecord


class SoflcDesign(AdaptiveDesign):
    """A controller of kind ``soflc``."""

    kind: Literal["soflc"] = "soflc"


FeedDesign = PidDesign | FlcDesign | AflcDesign | SoflcDesign


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
