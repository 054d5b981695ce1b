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
from hfc_design.controllers.flc.law import FlcGains
from hfc_design.controllers.flc.record import terms_of
from hfc_design.controllers.kind import STARTED, Member, Saved, Template, later
from hfc_design.core.numbers import SCALARS, Floats, Json
from hfc_design.core.records import TERMS, ZR, UserError

#: How far a table of the runtime may be from that of C, in shares of its largest singleton.
KEPT = 1e-12
#: Where the templates of the adaptation lie.
ADAPTATION = (Path(__file__).parent / "templates",)


def _c(record: AdaptiveDesign) -> Json:
    """C starts from what the law makes of the design at the first sample."""
    start, judge = record.gains(), record.judge()
    memory = law.aflc(record.sample_time_s).initial_memory(0.0)
    first = law.adapted(SCALARS, judge, start, memory, 0.0)
    values = c_values(record, first)
    return values | {
        "adaptive": True,
        "in_place": True,
        "widths": values["widths"] + _widths(start, first),
        "start": "start_",
        "current": "state->",
        "rates": start.rates,
        "sectors": start.sectors,
        "positive": [
            [int(u >= 0.0 if i > ZR else u > 0.0) for u in row]
            for i, row in enumerate(start.flc.singletons)
        ],
        "blames_what_it_did": judge.blamed is blamed_aflc,
        "narrows_zero": judge.narrows_zero,
        "alike": ALIKE,
        "performance": PERFORMANCE,
    }


def _widths(start: law.AdaptiveGains, first: FlcGains) -> list[float]:
    """How near an edge can come to a centre, in single precision.

    Raises:
        UserError: it can come to 0, or the table starts so far outside its stable range that the
            runtime, which keeps how far it has moved, does not have what C has.
    """
    # The middle row has no bounds.
    old: Floats = np.delete(start.flc.singletons, ZR, axis=0)
    new: Floats = np.delete(first.singletons, ZR, axis=0)
    largest = np.abs(new).max()
    if np.abs(old + (new - old) - new).max() > KEPT * largest:
        raise UserError(
            f"controller.rules.centroids: go up to {np.abs(old).max():g}, adaptation.stable_range "
            f"holds them to {largest:g}: too far apart for C to equal the runtime"
        )
    table, rates = start.flc, start.rates
    pairs = ((table.error_terms, rates.a_overlap), (table.change_terms, rates.b_overlap))
    near = [
        (m, m + side * k / 2) for terms, k in pairs if k for _, m, _ in terms for side in (1, -1)
    ]
    if any(centre == edge for centre, edge in near):
        raise UserError("controller.adaptation: an overlap is too small beside a term's centre")
    return [apart(*pair) for pair in near]


#: Members of a state -> the terms that they are of.
JOINTS = {"error_joints": "error_terms", "change_joints": "error_change_terms"}
EDGES = {"right": "right edge of the lower of two terms", "left": "left edge of the upper one"}
#: An edge that single precision has put so far beyond a centre, as a share, is on it.
ROUNDING = 1e-6


def _learnt(record: AdaptiveDesign) -> list[Member]:
    """Its table and its terms by now."""
    found = [Member("table", (TERMS, TERMS), "[term of the error][term of its change]")]
    for joints in JOINTS:
        found += [Member(f"{joints}[].{k}", (TERMS - 1,), f"{x} [BLU]") for k, x in EDGES.items()]
    return found


def _past(record: AdaptiveDesign) -> list[Member]:
    found = [STARTED, Member("error", what="of the sample before [BLU]")]
    found.append(Member("action", what="of the rules at the sample before"))
    if record.integral_gain * record.sample_time_s:
        found.append(Member("integral"))
    for place in ("in_error", "in_change"):
        found.append(Member(f"{place}.term", whole=(0, TERMS - 2)))
        found.append(Member(f"{place}.degree", (2,)))
    return found


def _taken(record: AdaptiveDesign, found: dict[str, Floats]) -> AdaptiveDesign:
    table, changes = record.table(), {}
    for joints, key in JOINTS.items():
        terms = table.error_terms if key == "error_terms" else table.change_terms
        labels = [term.label for term in getattr(record, key)]
        left, centre, right = map(np.array, zip(*terms, strict=True))
        right[:-1] = _between(centre, found[f"{joints}[].right"])
        left[1:] = _between(centre, found[f"{joints}[].left"])
        changes[key] = terms_of(np.stack([left, centre, right], axis=1).tolist(), labels)
    rules = record.rules.moved(found["table"].tolist())
    return record.model_copy(update={**changes, "rules": rules})


def _between(centre: Floats, edges: Floats) -> Floats:
    """Edges between neighbouring centres, where they are not beyond them by more than rounding."""
    held = np.clip(edges, centre[:-1], centre[1:])
    return np.where(np.abs(held - edges) <= ROUNDING * np.abs(edges), held, edges)


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
    c=Template((*ADAPTATION, HERE), _c),
    saved=Saved(_learnt, _past, _taken),
    table_gains=AflcDesign.table_gains,
    sections=later("hfc_design.controllers.aflc.section", "sections"),
)
