"""Every kind of controller by its name: the folders here, and what users add."""

from typing import Any

from hfc_design import controllers
from hfc_design.controllers.gains import Law, kind_of
from hfc_design.controllers.kind import ControllerRecord, ControllerSettings, Kind
from hfc_design.core.plugins import Group, found_in


def _fault(kind: Any) -> str | None:
    """What keeps a kind from working, in a line; None if nothing that is seen at once."""
    if (kind.law is None) == (kind.controller is None):
        return "needs either law, of one axis, or controller, of a whole machine"
    if not (isinstance(kind.record, type) and issubclass(kind.record, ControllerRecord)):
        return "record has to be a subclass of ControllerRecord"
    own = kind.settings
    if own is not None and not (isinstance(own, type) and issubclass(own, ControllerSettings)):
        return "settings has to be a subclass of ControllerSettings, or None"
    if (own is None) != (kind.genome is None):
        return "settings and genome go together: what is searched, and how it varies"
    return None


def _adopted(thing: object) -> object:
    """A law whose gains are a few numbers is a kind without another word."""
    return kind_of(thing) if isinstance(thing, Law) else thing


KINDS: Group[Kind] = Group(
    "controller",
    (Law, Kind),  # of a law a kind is made
    "hfc_design.controllers",
    found_in(controllers, "KIND"),
    fault=_fault,
    adopt=_adopted,
)
