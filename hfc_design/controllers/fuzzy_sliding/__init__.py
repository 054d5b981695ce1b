"""Adaptive fuzzy sliding control of an axis (Lin & Gai 2009)."""

from hfc_design.controllers.fuzzy_sliding.export import EXPLAIN, RULES
from hfc_design.controllers.fuzzy_sliding.law import sliding
from hfc_design.controllers.fuzzy_sliding.record import SlidingDesign, SlidingSettings
from hfc_design.controllers.kind import Kind, later

KIND = Kind(
    name="fuzzy-sliding",
    summary="fuzzy rules that adapt beside a sliding mode with a boundary layer (Lin & Gai 2009)",
    record=SlidingDesign,
    settings=SlidingSettings,
    gains=SlidingDesign.gains,
    law=lambda record, limit: sliding(record.sample_time_s, limit),
    genome=later("hfc_design.controllers.fuzzy_sliding.genome", "SlidingGenome"),
    reach=SlidingDesign.reach,
    adapted=SlidingDesign.adapted,
    rules=RULES,
    explain=EXPLAIN,
    pictures=later("hfc_design.controllers.fuzzy_sliding.pictures", "pictures"),
    sections=later("hfc_design.controllers.fuzzy_sliding.pictures", "sections"),
)
