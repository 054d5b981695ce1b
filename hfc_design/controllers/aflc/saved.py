"""What of a fuzzy controller that adapts is saved: its table and its terms by now."""

import numpy as np

from hfc_design.controllers.aflc.record import AdaptiveDesign
from hfc_design.controllers.flc.record import terms_of
from hfc_design.controllers.kind import STARTED, Member, Saved
from hfc_design.core.numbers import Floats
from hfc_design.core.records import TERMS

#: Members of a state -> the terms that they are of.
JOINTS = {"error_joints": "error_terms", "change_joints": "error_change_terms"}
EDGES = {"right": "right edge of the lower of two terms", "left": "left edge of the upper one"}
#: An edge that single precision has put so far beyond a centre, as a share, is on it.
ROUNDING = 1e-6


def _learnt(record: AdaptiveDesign) -> list[Member]:
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


SAVED = Saved(_learnt, _past, _taken)
