"""Self-organising fuzzy controller, which learns its rules in the loop (Huang & Shy)."""

from hfc_design.controllers.kind import Explain
from hfc_design.controllers.neighbours import spread
from hfc_design.controllers.rules import fired, side
from hfc_design.controllers.soc.law import LABELS, SETS, Parts
from hfc_design.controllers.soc.record import SocDesign
from hfc_design.core.numbers import Json


def _shown(record: SocDesign, parts: Parts) -> Json:
    """Return the rules that fire in a sample, and the command that they give, as JSON."""
    column = side("error_change", parts.change, LABELS, spread(parts.in_change, SETS))
    row = side("error", parts.error, LABELS, spread(parts.in_error, SETS))
    unit = fired("rules", column, row, parts.rules, parts.inferred)
    return {"units": [unit], "parts": {"rules": record.law_gains().gu * float(parts.inferred)}}


EXPLAIN = Explain(
    signals=lambda record: (["error"], ["previous_error"]),
    remember=lambda memory, now: memory._replace(error=now.get("error", memory.error)),
    shown=_shown,
    changes={"error_change": "previous_error"},
)
KIND = SocDesign
