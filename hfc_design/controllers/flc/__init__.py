"""The two-input fuzzy controller of a feed drive (Jee & Koren 1995, 2004)."""

from hfc_design.controllers.flc.export import EXPLAIN, RULES, widths
from hfc_design.controllers.flc.law import flc
from hfc_design.controllers.flc.record import FlcDesign, FlcSettings
from hfc_design.controllers.kind import Kind, later

KIND = Kind(
    name="flc",
    summary="two-input fuzzy controller with an integral term (Jee & Koren 1995, 2004)",
    record=FlcDesign,
    settings=FlcSettings,
    gains=FlcDesign.gains,
    law=lambda record, limit: flc(record.form, record.sample_time_s, limit),
    genome=later("hfc_design.controllers.flc.genome", "FuzzyGenome"),
    reads=FlcDesign.reads,
    reach=FlcDesign.reach,
    connecting=FlcDesign.connecting,
    rules=RULES,
    explain=EXPLAIN,
    widths=widths,
    table_gains=FlcDesign.table_gains,
    pictures=later("hfc_design.controllers.flc.section", "pictures"),
    sections=later("hfc_design.controllers.flc.section", "sections"),
)
