"""What of a hierarchy that adapts is saved: by how much the consequents of its root have moved."""

from hfc_design.controllers.hierarchical.record import HierarchicalDesign, layout_of
from hfc_design.controllers.kind import STARTED, Member, Saved
from hfc_design.controllers.linear.code import past as linear_past
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Floats
from hfc_design.core.records import TERMS, ZR


def _learnt(record: HierarchicalDesign) -> list[Member]:
    if record.adaptation is None:
        return []
    told = f"of the consequents of unit {record.units[-1].id}, rows one after the other"
    return [Member("moves", (TERMS * TERMS,), told)]


def _past(record: HierarchicalDesign) -> list[Member]:
    found = []
    if record.adaptation is not None:
        found += [
            Member("term", what="of the error at the sample before", whole=(-ZR, ZR)),
            Member("column", (TERMS,), "degrees of the column input then"),
            Member("row", (TERMS,), "degrees of the row input then"),
        ]
    previous = [Member(f"previous_{identifier(name)}") for name in layout_of(record).remembered]
    found += [STARTED, *previous] if previous else []
    return found + (linear_past(part) if (part := record.linear_part) else [])


def _taken(record: HierarchicalDesign, found: dict[str, Floats]) -> HierarchicalDesign:
    assert record.adaptation is not None  # or nothing is learnt
    moves = tuple(map(tuple, found["moves"].reshape(TERMS, TERMS).tolist()))
    adaptation = record.adaptation.model_copy(update={"moves": moves})
    return record.model_copy(update={"adaptation": adaptation})


SAVED = Saved(_learnt, _past, _taken)
