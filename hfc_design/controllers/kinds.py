"""Every kind of controller by its name: those in the folders here, and those that users add."""

from typing import Any

from hfc_design import controllers
from hfc_design.controllers.gains import Law, kind_of
from hfc_design.controllers.gains.genome import GainsGenome
from hfc_design.controllers.kind import ControllerRecord, names_of
from hfc_design.core.plugins import Group, found_in

#: Attributes of a kind that must be functions, if they are not None.
METHODS = ("law", "controller", "genome", "of_gains", "reads", "sections")


def _fault(kind: type[ControllerRecord]) -> str | None:
    """Return why a kind cannot work, in a line; None if no fault is found at once."""
    settings: Any = kind.settings
    named = names_of(settings) if isinstance(settings, type) else ()
    for key in METHODS:
        if (value := getattr(kind, key)) is not None and not callable(value):
            return f"{key} = {value!r}: must be a function"
    gains_alone = kind.genome is GainsGenome and kind.of_gains is None
    faults = {
        "law_gains is missing, which returns the gains of its law": kind.law_gains
        is ControllerRecord.law_gains,
        f"name = {kind.name!r}: must be a string": not isinstance(kind.name, str),
        f"settings = {settings!r}: must be a class": not isinstance(settings, type | None),
        "must have either law, of one axis, or controller, of a whole machine": (kind.law is None)
        == (kind.controller is None),
        "must have both settings and genome, or neither": (settings is None)
        != (kind.genome is None),
        "genome_of_gains needs of_gains, which makes a record of given gains": gains_alone,
        f"name must be the kind of its settings, {named}": bool(named) and kind.name not in named,
    }
    return next((message for message, wrong in faults.items() if wrong), None)


KINDS: Group[type[ControllerRecord]] = Group(
    "controller",
    (Law,),  # ``adopt`` makes a kind of it
    "hfc_design.controllers",
    found_in(controllers, "KIND", folders=True),
    fault=_fault,
    adopt=lambda thing: kind_of(thing) if isinstance(thing, Law) else thing,
    classes=(ControllerRecord,),
)
