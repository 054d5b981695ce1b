"""The fuzzy controller that organises itself (Jee & Koren 1995)."""

from typing import Literal

from hfc_design.controllers.aflc.adaptation import blamed_soflc
from hfc_design.controllers.aflc.code import ST, c_template
from hfc_design.controllers.aflc.law import aflc
from hfc_design.controllers.aflc.record import AdaptiveDesign
from hfc_design.controllers.flc.record import points
from hfc_design.controllers.flc.rules import EXPLAIN, RULES
from hfc_design.controllers.kind import Kind, later


class SoflcDesign(AdaptiveDesign):
    """A controller of kind ``soflc`` in a design file."""

    kind: Literal["soflc"] = "soflc"


KIND = Kind(
    name="soflc",
    summary="flc that organises its terms and rules itself (Jee & Koren 1995)",
    record=SoflcDesign,
    settings=None,
    gains=SoflcDesign.gains,
    law=lambda record, limit: aflc(record.sample_time_s, limit, blamed_soflc),
    reads=SoflcDesign.reads,
    rules=RULES,
    explain=EXPLAIN,
    adapted=SoflcDesign.adapted,
    c=c_template(blamed_soflc),
    st=ST,
    table_gains=points,
    sections=later("hfc_design.controllers.flc.section", "table_sections"),
)
