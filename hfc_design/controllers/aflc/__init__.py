"""The fuzzy controller that adapts within a stable range (Jee & Koren 2004).

What it shares with the flc it has from there; its block of Structured Text is what it starts from.
"""

from dataclasses import replace

from hfc_design.controllers.aflc import law
from hfc_design.controllers.aflc.record import AdaptiveDesign, AflcDesign, AflcSettings
from hfc_design.controllers.flc import KIND as FLC
from hfc_design.controllers.flc.export import EXPLAIN, apart, widths
from hfc_design.controllers.kind import later
from hfc_design.core.records import UserError


def _widths(record: AdaptiveDesign) -> list[float]:
    """How near an edge can come to a centre, in single precision.

    Raises:
        UserError: it can come to 0.
    """
    table, rates = record.table(), record.gains().rates
    pairs = ((table.error_terms, rates.a_overlap), (table.change_terms, rates.b_overlap))
    near = [
        (m, m + side * k / 2) for terms, k in pairs if k for _, m, _ in terms for side in (1, -1)
    ]
    if any(centre == edge for centre, edge in near):
        raise UserError("controller.adaptation: an overlap is too small beside a term's centre")
    return [*widths(record), *(apart(*pair) for pair in near)]


KIND = replace(
    FLC,
    name="aflc",
    summary="flc that adapts its terms and rules within a stable range (Jee & Koren 2004)",
    record=AflcDesign,
    settings=AflcSettings,
    gains=AflcDesign.gains,
    law=lambda record, limit: law.aflc(record.sample_time_s, limit, record.judge()),
    genome=later("hfc_design.controllers.aflc.genome", "AflcGenome"),
    explain=EXPLAIN._replace(held=AflcDesign.held),
    adapted=AflcDesign.adapted,
    widths=_widths,
    table_gains=AflcDesign.table_gains,
    sections=later("hfc_design.controllers.aflc.section", "sections"),
)
