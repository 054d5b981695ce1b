"""Export of adaptive fuzzy sliding control: its rule table, and its samples in words.

The exported rules include the moves that the rules have learned so far.
"""

from hfc_design.controllers.fuzzy_sliding.law import Parts
from hfc_design.controllers.fuzzy_sliding.record import LABELS, SlidingDesign
from hfc_design.controllers.kind import Explain
from hfc_design.controllers.neighbours import spread
from hfc_design.controllers.rules import Rows, RuleBase, RuleUnit, Triangle, fired, rows_of, side
from hfc_design.core.numbers import Json
from hfc_design.core.records import TERMS, ZR


def _terms(largest: float) -> tuple[Triangle, ...]:
    """Return seven evenly spaced triangles with centres from -``largest`` to ``largest``."""
    gap = largest / ZR
    centres = [gap * (k - ZR) for k in range(TERMS)]
    edges = [-float("inf"), *centres, float("inf")]
    return tuple(
        Triangle(label, edges[k], centres[k], edges[k + 2]) for k, label in enumerate(LABELS)
    )


def units(record: SlidingDesign) -> list[RuleUnit]:
    """Return the one rule table."""
    rate, error = _terms(record.largest_error_rate), _terms(record.largest_error)
    return [RuleUnit("rules", "error_rate", "error", rate, error, record.table())]


def about(record: SlidingDesign, signal_units: dict[str, str]) -> Json:
    """Return the name of the output, the sliding surface and the linear gains, as JSON."""
    pid = record.pid
    return {
        "output": "rules",
        "sliding": record.sliding.model_dump(mode="json"),
        "pid": pid.model_dump(mode="json") if pid else None,
    }


def notes(record: SlidingDesign) -> list[str]:
    """Return lines on the units and on what a rule table does not contain."""
    return [
        "error and error_rate in the units of the drive, output in those of its command",
        "the switching part and the adaptation, which starts from these rules, are not included",
    ]


def tables(record: SlidingDesign) -> dict[str, Rows]:
    """Return CSV files: rules (rows: error, columns: error_rate), centres and a manifest."""
    corner = "row error \\ column error_rate"
    centres = [["input", *LABELS]]
    for name in ("error", "error_rate"):
        terms = _terms(getattr(record, f"largest_{name}"))
        centres.append([name, *(repr(term.centre) for term in terms)])
    manifest = [["unit", "column_input", "row_input", "file"]]
    manifest.append([record.kind, "error_rate", "error", "rules.csv"])
    rules = rows_of(corner, LABELS, LABELS, record.table())
    return {"rules.csv": rules, "centres.csv": centres, "manifest.csv": manifest}


def shown(record: SlidingDesign, parts: Parts) -> Json:
    """Return the rules that fire in a sample, and the parts of its command, as JSON."""
    column = side("error_rate", parts.rate, LABELS, spread(parts.in_rate, TERMS))
    row = side("error", parts.error, LABELS, spread(parts.in_error, TERMS))
    unit = fired("rules", column, row, parts.consequents, parts.fuzzy)
    shares = {"fuzzy": float(parts.fuzzy), "switching": float(parts.switching)}
    if parts.pid is not None:
        shares["pid"] = float(parts.pid)
    return {"units": [unit], "parts": shares}


RULES = RuleBase(units, lambda record: ["error_rate", "error"], about, notes, tables)
EXPLAIN = Explain(
    lambda record: (["error", "error_rate"], []), lambda memory, readings: memory, shown
)
