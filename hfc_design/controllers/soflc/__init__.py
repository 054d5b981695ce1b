"""Self-organising fuzzy controller (Jee & Koren 1995)."""

from typing import Literal

from hfc_design.controllers.aflc.adaptation import blamed_soflc
from hfc_design.controllers.aflc.law import Judge
from hfc_design.controllers.aflc.record import AdaptiveDesign


class SoflcDesign(AdaptiveDesign):
    """Design of kind ``soflc``."""

    kind: Literal["soflc"] = "soflc"
    summary = "flc that organises its terms and rules itself (Jee & Koren 1995)"

    def judge(self) -> Judge:
        """Return the judgement of the rules that JK95 prints."""
        return super().judge()._replace(blamed=blamed_soflc)


KIND = SoflcDesign
