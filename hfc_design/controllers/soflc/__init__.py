"""The fuzzy controller that organises itself (Jee & Koren 1995)."""

from dataclasses import replace
from typing import Literal

from hfc_design.controllers.aflc import KIND as AFLC
from hfc_design.controllers.aflc import c_template
from hfc_design.controllers.aflc.adaptation import blamed_soflc
from hfc_design.controllers.aflc.law import aflc
from hfc_design.controllers.aflc.record import AdaptiveDesign
from hfc_design.controllers.kind import later


class SoflcDesign(AdaptiveDesign):
    """A controller of kind ``soflc`` in a design file."""

    kind: Literal["soflc"] = "soflc"


KIND = replace(
    AFLC,
    name="soflc",
    summary="flc that organises its terms and rules itself (Jee & Koren 1995)",
    record=SoflcDesign,
    settings=None,
    genome=None,
    law=lambda record, limit: aflc(record.sample_time_s, limit, blamed_soflc),
    c=c_template(blamed_soflc),
    table_gains=SoflcDesign.table_gains,
    sections=later("hfc_design.controllers.flc.section", "table_sections"),
)
