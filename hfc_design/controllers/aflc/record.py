"""Fuzzy controllers that adapt in a design file. Never imports JAX."""

from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from hfc_design.controllers.aflc.law import AdaptiveGains, AdaptiveMemory, Rates, current
from hfc_design.controllers.flc.record import FuzzyRecord, Triangles
from hfc_design.controllers.flc.sectors import Sectors
from hfc_design.controllers.flc.settings import FuzzySettings, Start
from hfc_design.core.records import NotNegative, Positive, Record


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

    adapts: ClassVar[bool] = True
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

    def held(self) -> Self:
        """The same without adaptation."""
        steps = self.adaptation.model_copy(update={"k_a": 0.0, "k_b": 0.0, "k_c": 0.0})
        return self.model_copy(update={"adaptation": steps})

    def gains(self) -> AdaptiveGains:
        """The gains of one individual."""
        limits = self.adaptation.stable_range
        sectors = None if limits is None else Sectors(limits.k1_max, limits.k2_max)
        return AdaptiveGains(self.table(), self.adaptation.rates(), sectors)

    def adapted(self, memory: AdaptiveMemory) -> Self:
        """The controller with its terms and its rule table as ``memory`` has them."""
        error_terms, change_terms, table = current(self.gains(), memory)
        rules = self.rules.model_copy(update={"centroids": tuple(map(tuple, table))})
        changes = {
            "error_terms": _with_edges(self.error_terms, error_terms),
            "error_change_terms": _with_edges(self.error_change_terms, change_terms),
            "rules": rules,
        }
        return self.model_copy(update=changes)


class AflcDesign(AdaptiveDesign):
    """A controller of kind ``aflc``."""

    kind: Literal["aflc"] = "aflc"
    adaptation: BoundedRatesRecord

    def adaptation_limit(self) -> dict[str, tuple[float, float]]:
        """Of its stable range."""
        stable = self.adaptation.stable_range
        return {"limit of the adaptation": (stable.k1_max, stable.k2_max)}


class AflcSettings(FuzzySettings):
    """What a search for an ``aflc`` starts from."""

    kind: Literal["aflc"]
    start: Annotated[AflcDesign, Start] = Field("jee-koren-2004-aflc", validate_default=True)


def _with_edges(terms: Triangles, moved: Any) -> Triangles:
    """Terms with other edges; those at infinity stay there."""
    return tuple(
        term.model_copy(
            update={
                "left": None if term.left is None else left,
                "right": None if term.right is None else right,
            }
        )
        for term, (left, _, right) in zip(terms, moved, strict=True)
    )
