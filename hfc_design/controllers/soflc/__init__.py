"""The fuzzy controller that organises itself (Jee & Koren 1995)."""

from typing import Literal

from hfc_design.controllers.aflc.adaptation import blamed_soflc
from hfc_design.controllers.aflc.law import Judge
from hfc_design.controllers.aflc.record import AdaptiveDesign


class SoflcDesign(AdaptiveDesign):
    """A controller of kind ``soflc`` in a design file."""

    kind: Literal["soflc"] = "soflc"
    summary = "flc that organises its terms and rules itself (Jee & Koren 1995)"

    def judge(self) -> Judge:
        """As JK95 prints it."""
        return super().judge()._replace(blamed=blamed_soflc)


KIND = SoflcDesign
