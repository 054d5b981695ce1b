"""The fuzzy controller that begins without rules and learns them in the loop (Huang & Shy)."""

from hfc_design.controllers import kind
from hfc_design.controllers.gains import FEEDS, genome_of_gains, settings_of
from hfc_design.controllers.kind import Kind
from hfc_design.controllers.neighbours import spread
from hfc_design.controllers.rules import fired, side
from hfc_design.controllers.soc.law import LABELS, SETS, Parts, SocGains, soc
from hfc_design.controllers.soc.record import SocDesign, of_gains
from hfc_design.core.numbers import Json

#: On a milling table, errors in mm and commands in V.
RANGES = SocGains((2.0, 100.0), (5.0, 300.0), (0.2, 20.0), (0.02, 0.9), (0.1, 0.9))


def _shown(record: SocDesign, parts: Parts) -> Json:
    """What a sample's command is made of."""
    column = side("error_change", parts.change, LABELS, spread(parts.in_change, SETS))
    row = side("error", parts.error, LABELS, spread(parts.in_error, SETS))
    unit = fired("rules", column, row, parts.rules, parts.inferred)
    return {"units": [unit], "parts": {"rules": record.gains().gu * float(parts.inferred)}}


KIND = Kind(
    name="soc",
    summary="fuzzy, learns its 11 x 11 rules from nothing (Huang & Shy)",
    record=SocDesign,
    settings=settings_of(RANGES, FEEDS),
    gains=SocDesign.gains,
    law=lambda record, limit: soc(record.table, record.sample_time_s, limit),
    genome=genome_of_gains,
    of_gains=of_gains,
    reads=lambda record: ["error"],
    reach=SocDesign.reach,
    connecting=lambda record: [kind.CHANGES],
    adapted=SocDesign.adapted,
    explain=kind.Explain(
        signals=lambda record: (["error"], ["previous_error"]),
        remember=lambda memory, now: memory._replace(error=now.get("error", memory.error)),
        shown=_shown,
        held=SocDesign.held,
        changes={"error_change": "previous_error"},
    ),
    no_rules="it learns its rules in the loop, which that format cannot do; c, fmu, linuxcnc do",
    pictures=kind.later("hfc_design.controllers.soc.section", "pictures"),
    sections=kind.later("hfc_design.controllers.soc.section", "sections"),
)
