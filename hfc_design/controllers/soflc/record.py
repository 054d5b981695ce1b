"""The self-organising fuzzy controller in a design file. Never imports JAX."""

from typing import Literal

from hfc_design.controllers.aflc.record import AdaptiveDesign


class SoflcDesign(AdaptiveDesign):
    """A controller of kind ``soflc``."""

    kind: Literal["soflc"] = "soflc"
