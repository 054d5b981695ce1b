"""PD plus a hierarchy of two-input fuzzy units (Lin & Lee 1999)."""

from hfc_design.controllers.hierarchical.code import tabulated
from hfc_design.controllers.hierarchical.law import hierarchical
from hfc_design.controllers.hierarchical.record import (
    HierarchicalDesign,
    HierarchicalSettings,
    layout_of,
)
from hfc_design.controllers.hierarchical.rules import EXPLAIN, RULES, reads
from hfc_design.controllers.hierarchical.units import units_that_matter
from hfc_design.controllers.kind import Kind, later

KIND = Kind(
    name="pd+hierarchical-fuzzy",
    summary="PD plus a hierarchy of two-input fuzzy units (Lin & Lee 1999)",
    record=HierarchicalDesign,
    settings=HierarchicalSettings,
    gains=HierarchicalDesign.gains,
    law=lambda record, limit: hierarchical(layout_of(record), record.sample_time_s, limit),
    genome=later("hfc_design.controllers.hierarchical.linear_genome", "genome_of"),
    structure=HierarchicalDesign.structure,
    units=units_that_matter,
    reads=reads,
    reach=HierarchicalDesign.reach,
    connecting=HierarchicalDesign.connecting,
    rules=RULES,
    explain=EXPLAIN,
    adapted=HierarchicalDesign.adapted,
    lookup=tabulated,
    pictures=later("hfc_design.controllers.hierarchical.pictures", "pictures"),
    sections=later("hfc_design.controllers.hierarchical.section", "sections"),
)
