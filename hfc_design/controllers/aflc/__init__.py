"""The fuzzy controller that adapts within a stable range (Jee & Koren 2004)."""

from hfc_design.controllers.aflc.code import ST, C
from hfc_design.controllers.aflc.law import aflc
from hfc_design.controllers.aflc.record import AflcDesign, AflcSettings
from hfc_design.controllers.flc.record import points
from hfc_design.controllers.flc.rules import EXPLAIN, RULES
from hfc_design.controllers.kind import Kind, later

KIND = Kind(
    name="aflc",
    summary="flc that adapts its terms and rules within a stable range (Jee & Koren 2004)",
    record=AflcDesign,
    settings=AflcSettings,
    gains=AflcDesign.gains,
    law=lambda record, limit: aflc(record.sample_time_s, limit),
    genome=later("hfc_design.controllers.aflc.genome", "genome_of"),
    reads=AflcDesign.reads,
    rules=RULES,
    explain=EXPLAIN,
    adapted=AflcDesign.adapted,
    c=C,
    st=ST,
    table_gains=points,
    sections=later("hfc_design.controllers.aflc.section", "sections"),
)
