"""The fuzzy controller that adapts within a stable range (Jee & Koren 2004).

What it shares with the flc it has from there; its block of Structured Text is what it starts from.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from hfc_design.controllers.aflc import law
from hfc_design.controllers.aflc.adaptation import ALIKE, PERFORMANCE, blamed_aflc
from hfc_design.controllers.aflc.record import AdaptiveDesign, AflcDesign, AflcSettings
from hfc_design.controllers.flc import KIND as FLC
from hfc_design.controllers.flc.export import EXPLAIN, HERE, apart, c_values
from hfc_design.controllers.kind import Template, later
from hfc_design.core.numbers import SCALARS, Floats, Json
from hfc_design.core.records import ZR, UserError

#: How far a table of the runtime may be from that of C, in shares of its largest singleton.
KEPT = 1e-12
#: Where the templates of the adaptation lie.
ADAPTATION = (Path(__file__).parent / "templates",)


def c_template(blamed: law.Blame) -> Template:
    """The template of a controller whose rules are ``blamed`` so."""

    def values(record: AdaptiveDesign) -> Json:
        """It starts from what its law makes of the design at the first sample."""
        start = record.gains()
        memory = law.aflc(record.sample_time_s).initial_memory(0.0)
        first = law.adapted(SCALARS, blamed, start, memory, 0.0)
        _check_kept(np.array(start.flc.singletons), np.array(first.singletons))
        values, narrow = c_values(record, first), _closest(start)
        return values | {
            "adaptive": True,
            "in_place": True,
            "divisors": values["divisors"] + narrow,
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


def _check_kept(start: Floats, now: Floats) -> None:
    """Whether the runtime, which keeps how far ``start`` has moved, has what C has.

    Raises:
        UserError: the table starts so far outside its stable range that a move rounds it away.
    """
    if np.abs(start + (now - start) - now).max() > KEPT * np.abs(now).max():
        raise UserError(
            f"controller.rules.centroids: go up to {np.abs(start).max():g}, and "
            f"adaptation.stable_range holds them to {np.abs(now).max():g}: too far apart for C to "
            "equal the runtime"
        )


def _closest(start: law.AdaptiveGains) -> list[float]:
    """How near an edge can come to a centre, in single precision.

    Raises:
        UserError: it can come to 0.
    """
    table, rates, found = start.flc, start.rates, []
    for terms, overlap in (
        (table.error_terms, rates.a_overlap),
        (table.change_terms, rates.b_overlap),
    ):
        for _, centre, _ in terms if overlap else ():
            for edge in (centre - 0.5 * overlap, centre + 0.5 * overlap):
                if edge == centre:
                    told = f"= {overlap:g}: nothing beside a centre of {centre:g}"
                    raise UserError(f"controller.adaptation: an overlap {told}")
                found.append(apart(edge, centre))
    return found


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
