"""The fuzzy controller that organises itself (Jee & Koren 1995)."""

from dataclasses import replace
from typing import Literal

from hfc_design.controllers.aflc import KIND as AFLC
from hfc_design.controllers.aflc.adaptation import blamed_soflc
from hfc_design.controllers.aflc.law import Judge
from hfc_design.controllers.aflc.record import AdaptiveDesign
from hfc_design.controllers.kind import later


class SoflcDesign(AdaptiveDesign):
    """A controller of kind ``soflc`` in a design file."""

    kind: Literal["soflc"] = "soflc"

    def judge(self) -> Judge:
        """As JK95 prints it."""
        return super().judge()._replace(blamed=blamed_soflc)


KIND = replace(
    AFLC,
    name="soflc",
    summary="flc that organises its terms and rules itself (Jee & Koren 1995)",
    record=SoflcDesign,
    settings=None,
    genome=None,
    table_gains=SoflcDesign.table_gains,
    sections=later("hfc_design.controllers.flc.section", "table_sections"),
)
