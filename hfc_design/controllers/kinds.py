"""Every kind of controller by its name: the folders here, and what users add."""

from typing import get_args

from hfc_design import controllers
from hfc_design.controllers.gains import Law, genome_of_gains, kind_of
from hfc_design.controllers.kind import Kind
from hfc_design.core.plugins import Group, found_in


def _fault(kind: Kind) -> str | None:
    """What keeps a kind from working, in a line; None if nothing that is seen at once."""
    if (kind.law is None) == (kind.controller is None):
        return "needs either law, of one axis, or controller, of a whole machine"
    if (kind.settings is None) != (kind.genome is None):
        return "settings and genome go together: what is searched, and how it varies"
    if kind.genome is genome_of_gains and kind.of_gains is None:
        return "genome_of_gains needs of_gains, the record of given gains"
    for part in filter(None, (kind.record, kind.settings)):
        allowed = get_args(part.model_fields["kind"].annotation) or (kind.name,)
        if kind.name not in allowed:
            return f"name has to be the kind of its {part.__name__}, {allowed[0]!r}"
    return None


KINDS: Group[Kind] = Group(
    "controller",
    (Law, Kind),  # of a law a kind is made
    "hfc_design.controllers",
    found_in(controllers, "KIND", folders=True),
    fault=_fault,
    adopt=lambda thing: kind_of(thing) if isinstance(thing, Law) else thing,
)
