"""What of a self-organising controller is saved: its rules by now."""

from hfc_design.controllers.kind import STARTED, Member, Saved
from hfc_design.controllers.soc.law import SETS
from hfc_design.controllers.soc.record import SocDesign
from hfc_design.core.numbers import Floats


def _learnt(record: SocDesign) -> list[Member]:
    if not record.adaptation.gamma:
        return []
    return [Member("rules", (SETS, SETS), "[set of the error][set of its change]")]


def _past(record: SocDesign) -> list[Member]:
    return [STARTED, Member("error", what="of the sample before")]


def _taken(record: SocDesign, found: dict[str, Floats]) -> SocDesign:
    table = tuple(map(tuple, found["rules"].tolist()))
    return record.model_copy(update={"table": table})


SAVED = Saved(_learnt, _past, _taken)
