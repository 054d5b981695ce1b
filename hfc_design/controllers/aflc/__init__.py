"""The fuzzy controller that adapts within a stable range (Jee & Koren 2004).

What it shares with the flc it has from there; its block of Structured Text is what it starts from.
"""

from dataclasses import replace
from pathlib import Path

from hfc_design.controllers.aflc import law
from hfc_design.controllers.aflc.adaptation import ALIKE, PERFORMANCE, blamed_aflc
from hfc_design.controllers.aflc.record import AdaptiveDesign, AflcDesign, AflcSettings
from hfc_design.controllers.flc import KIND as FLC
from hfc_design.controllers.flc.export import EXPLAIN, HERE, c_values
from hfc_design.controllers.kind import Template, later
from hfc_design.core.numbers import SCALARS, Json
from hfc_design.core.records import ZR

#: Where the templates of the adaptation lie.
ADAPTATION = (Path(__file__).parent / "templates",)


def c_template(blamed: law.Blame) -> Template:
    """The template of a controller whose rules are ``blamed`` so."""

    def values(record: AdaptiveDesign) -> Json:
        """It starts from what its law makes of the design at the first sample."""
        start = record.gains()
        memory = law.aflc(record.sample_time_s).initial_memory(0.0)
        return c_values(record, law.adapted(SCALARS, blamed, start, memory, 0.0)) | {
            "adaptive": True,
            "start": "start_",
            "current": "state->",
            "rates": start.rates,
            "sectors": start.sectors,
            "positive": [
                [int(u >= 0.0 if i > ZR else u > 0.0) for u in row]
                for i, row in enumerate(start.flc.singletons)
            ],
            "blames_what_it_did": blamed is blamed_aflc,
            "alike": ALIKE,
            "performance": PERFORMANCE,
        }

    return Template((*ADAPTATION, HERE), values)


KIND = replace(
    FLC,
    name="aflc",
    summary="flc that adapts its terms and rules within a stable range (Jee & Koren 2004)",
    record=AflcDesign,
    settings=AflcSettings,
    gains=AflcDesign.gains,
    law=lambda record, limit: law.aflc(record.sample_time_s, limit),
    genome=later("hfc_design.controllers.aflc.genome", "AflcGenome"),
    explain=EXPLAIN._replace(held=AflcDesign.held),
    adapted=AflcDesign.adapted,
    c=c_template(blamed_aflc),
    table_gains=AflcDesign.table_gains,
    sections=later("hfc_design.controllers.aflc.section", "sections"),
)
