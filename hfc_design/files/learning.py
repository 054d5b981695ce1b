"""A design as it has become, by what its controller has learnt in a motion or on a machine.

Never imports JAX.
"""

from collections.abc import Iterable
from pathlib import Path

from hfc_design.controllers.controller import within_rate
from hfc_design.controllers.kind import ControllerRecord, needed
from hfc_design.controllers.per_axis import learnt
from hfc_design.core.numbers import Json, Memory, finite
from hfc_design.core.records import UserError, checked
from hfc_design.files.design import Design

#: What the name of such a design ends with, and letters of a name.
ENDING, LONGEST = "-learned", 64


def learned(design: Design, axes: Iterable[str], memory: Memory, told: Json) -> Design:
    """The design that starts with what the ``memory`` of its controller has learnt.

    ``axes`` are those of the machine: where they have learnt different things, each has a
    controller of its own. ``told`` is for the provenance.

    Raises:
        UserError: it does not adapt, or what it remembers is no number any more.
    """
    if not finite(memory):
        raise UserError(f"design {design.name}: has diverged; nothing it has learnt can be kept")
    found = learnt(design.controller, tuple(axes), within_rate(memory))
    return with_learned(design, needed(found, design, "it does not adapt"), told)


def with_learned(design: Design, controller: ControllerRecord, told: Json) -> Design:
    """The design with a ``controller`` that has learnt; its score is gone.

    Raises:
        UserError: it is none that can run.
    """
    name = design.name.removesuffix(ENDING)[: LONGEST - len(ENDING)] + ENDING
    data = design.model_dump(mode="json", exclude={"score", "controller"})
    data |= {"name": name, "controller": controller.model_dump(mode="json")}
    data["provenance"] |= {"learned": {"from": design.name, **told}}
    return checked(Design, data, f"what {design.name} has learnt", Path())
