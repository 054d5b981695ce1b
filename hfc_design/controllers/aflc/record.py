"""Records of adaptive fuzzy controllers in a design file. Never imports JAX."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from hfc_design.controllers.aflc.adaptation import blamed_aflc
from hfc_design.controllers.aflc.law import AdaptiveGains, AdaptiveMemory, Judge, Rates, aflc
from hfc_design.controllers.controller import AxisLaw
from hfc_design.controllers.flc import export
from hfc_design.controllers.flc.law import RuleBase
from hfc_design.controllers.flc.record import FuzzyRecord, FuzzySettings, TriangleRecord, terms_of
from hfc_design.controllers.flc.rules import RulesRecord
from hfc_design.controllers.kind import later
from hfc_design.controllers.neighbours import Partition
from hfc_design.core.numbers import SCALARS, Scalar
from hfc_design.core.records import TERMS, NotNegative, Positive, Record, UserError
from hfc_design.stability.sectors import Curve, Rectangle

Point = tuple[NotNegative, NotNegative]
#: Largest relative distance by which rounding to single precision puts an edge beyond a centre.
ROUNDING = 1e-6


class OverlapRecord(Record):
    """Smallest overlaps of two neighbouring terms."""

    error: Positive  # overlap of the terms of the error [BLU]
    error_change: Positive  # overlap of the terms of the change of the error [BLU]


class RangeRecord(Record):
    """Sectors that the adapted table must stay in."""

    k1_max: Positive  # largest gain K_1 of the table on the error [units/BLU]
    k2_max: Positive  # largest gain K_2 of the table on the error's change [units/BLU]
    #: points (K_1, K_2) of a line that K_2 must not exceed, K_1 rising and K_2 falling [units/BLU];
    #: none: only k2_max counts
    curve: Annotated[tuple[Point, ...], Field(exclude_if=().__eq__)] = ()

    @model_validator(mode="after")
    def _falls(self) -> "RangeRecord":
        for (a, b), (c, d) in pairwise(self.curve):
            if not (a < c and b >= d):
                segment = f"({a:g}, {b:g}), ({c:g}, {d:g})"
                raise ValueError(f"curve: K_1 must rise and K_2 must not, in {segment}")
        return self

    def sectors(self) -> Rectangle | Curve:
        """Return the sectors in the form that the law uses."""
        if not self.curve:
            return Rectangle(self.k1_max, self.k2_max)
        return Curve(self.k1_max, self.k2_max, self.curve)


class RatesRecord(Record):
    """Steps of the adaptation per unit of the performance index, and its bounds."""

    k_a: NotNegative  # step of an edge of a term of the error [BLU]
    k_b: NotNegative  # step of an edge of a term of the error's change [BLU]
    k_c: NotNegative  # step of the output of a rule [command]
    #: smallest overlap of neighbouring terms; left out: one step
    smallest_overlap: OverlapRecord | None = None
    #: stable range of the table's gains; left out: unbounded, as in JK95
    stable_range: RangeRecord | None = None
    #: whether the terms of rules of ZR are narrowed by a step when the error leaves ZR
    narrows_zero: Annotated[bool, Field(exclude_if=False.__eq__)] = False


class BoundedRatesRecord(RatesRecord):
    """Steps of the adaptation, which JK04 keeps inside a stable range."""

    stable_range: RangeRecord  # stable range of the table's gains, JK04 Appendix B


#: Rules are judged by a table for seven terms (JK04 Table 2).
SevenTerms = Annotated[tuple[TriangleRecord, ...], Field(min_length=TERMS, max_length=TERMS)]


class AdaptiveDesign(FuzzyRecord):
    """Common base of the two adaptive kinds."""

    adapts: ClassVar[bool] = True
    steps_of_adaptation = ("k_a", "k_b", "k_c")
    error_terms: SevenTerms  # seven triangles of the error, in order
    error_change_terms: SevenTerms  # seven triangles of the error's change, in order
    adaptation: RatesRecord  # step sizes and limits of the adaptation

    @field_validator("rules")
    @classmethod
    def _as_they_are_by_now(cls, rules: RulesRecord) -> RulesRecord:
        """Return the rules, with new labels if adapted numbers contradict the old labels."""
        return rules.relabelled() if rules.contradiction() else rules

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
                raise ValueError(f"adaptation.{key} = {step}: must be less than {limit}")
            overlap = 0.0 if least is None else getattr(least, name)
            if overlap > room:
                place = f"adaptation.smallest_overlap.{name}"
                raise ValueError(f"{place} = {overlap}: must be at most {limit}")
        return self

    def law(self, limit: float | None) -> AxisLaw:
        """Return the law of one axis."""
        return aflc(self.sample_time_s, limit, self.judge())

    def widths(self) -> list[float]:
        """Return the least distances of edges from centres, in float32; UserError: one can be 0."""
        table, rates = self.table(), self.law_gains().rates
        pairs = ((table.error_terms, rates.a_overlap), (table.change_terms, rates.b_overlap))
        wide = [(m, k / 2) for terms, k in pairs if k for _, m, _ in terms]
        near = [(m, m + side * half) for m, half in wide for side in (1, -1)]
        if any(centre == edge for centre, edge in near):
            fault = "an overlap is too small compared with a term's centre"
            raise UserError(f"controller.adaptation: {fault}")
        return [*export.widths(self), *(export.apart(*pair) for pair in near)]

    def law_gains(self) -> AdaptiveGains:
        """Return the gains of the design, as those of one individual."""
        steps, limits = self.adaptation, self.adaptation.stable_range
        least = steps.smallest_overlap
        overlaps = (steps.k_a, steps.k_b) if least is None else (least.error, least.error_change)
        rates = Rates(steps.k_a, steps.k_b, steps.k_c, *overlaps)
        return AdaptiveGains(self.table(), rates, limits.sectors() if limits else None)

    def judge(self) -> Judge:
        """Return the functions and options that judge the rules."""
        return Judge(blamed_aflc, self.adaptation.narrows_zero)

    def adapted(self, memory: AdaptiveMemory) -> Self:
        """Return the controller with the terms and the rule table of ``memory``."""
        base = memory.base(self.law_gains())
        return self._with(base._replace(error=_within(base.error), change=_within(base.change)))

    def at_first(self) -> Self:
        """Return the controller with the table of its first sample, held within the bounds."""
        memory = aflc(self.sample_time_s).begun(SCALARS, 0.0, self.law_gains())
        return self.adapted(memory)

    def _with(self, base: RuleBase) -> Self:
        error, change = export.labels_of(self)
        changes = {
            "error_terms": terms_of(base.error.triangles(), error),
            "error_change_terms": terms_of(base.change.triangles(), change),
            "rules": self.rules.moved(base.singletons),
        }
        return self.model_copy(update=changes)


def _within(terms: Partition) -> Partition:
    """Return the terms; edges that rounding put beyond a neighbour's centre are moved onto it."""
    centres = np.array(terms.centres)

    def near(edges: Sequence[Scalar]) -> list[float]:
        clipped = np.clip(edges, centres[:-1], centres[1:])
        return np.where(np.isclose(clipped, edges, ROUNDING, 0.0), clipped, edges).tolist()

    return Partition(terms.centres, near(terms.rights), near(terms.lefts))


class AflcDesign(AdaptiveDesign):
    """Design of kind ``aflc``."""

    kind: Literal["aflc"] = "aflc"
    summary = "flc that adapts its terms and rules within a stable range (Jee & Koren 2004)"
    settings = later(".record", "AflcSettings")
    genome = later(".genome", "AflcGenome")
    sections = later(".section", "sections")
    adaptation: BoundedRatesRecord  # step sizes and limits of the adaptation, JK04 section 4

    def table_gains(self) -> dict[str, tuple[float, float]]:
        """Return gains (K_1, K_2) of the table by method, and those that limit the adaptation."""
        stable = self.adaptation.stable_range
        k2 = stable.sectors().k2(SCALARS, [stable.k1_max])
        return {**super().table_gains(), "limit of the adaptation": (stable.k1_max, k2)}


class AflcSettings(FuzzySettings):
    """Settings of a search for an ``aflc``, with the design it starts from."""

    kind: Literal["aflc"]
    #: design that the search starts from: a built-in name, a file, or a record
    start: AflcDesign = Field("jee-koren-2004-aflc", validate_default=True)
