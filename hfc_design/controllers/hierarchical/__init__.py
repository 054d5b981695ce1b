"""PD plus a hierarchy of two-input fuzzy units (Lin & Lee 1999)."""

from hfc_design.controllers.hierarchical.code import ST, C
from hfc_design.controllers.hierarchical.law import hierarchical
from hfc_design.controllers.hierarchical.record import HierarchicalDesign
from hfc_design.controllers.hierarchical.rules import EXPLAIN, RULES, reads
from hfc_design.controllers.hierarchical.settings import HierarchicalSettings
from hfc_design.controllers.kind import Kind, later

KIND = Kind(
    name="pd+hierarchical-fuzzy",
    summary="PD plus a hierarchy of two-input fuzzy units (Lin & Lee 1999)",
    record=HierarchicalDesign,
    settings=HierarchicalSettings,
    gains=HierarchicalDesign.gains,
    law=lambda record, limit: hierarchical(record.layout(), record.sample_time_s, limit),
    genome=later("hfc_design.controllers.hierarchical.genome", "genome_of"),
    reads=reads,
    rules=RULES,
    explain=EXPLAIN,
    c=C,
    st=ST,
    lookup=later("hfc_design.controllers.hierarchical.lookup", "tabulated"),
    sections=later("hfc_design.controllers.hierarchical.section", "sections"),
)
