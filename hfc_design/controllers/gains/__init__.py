"""Kinds whose parameters are a few gains: pd, pid, and every law of a user's own.

The folder is no kind itself; ``kind_of`` makes one of a law. Never imports JAX.
"""

from pydantic import model_validator

from hfc_design.controllers.gains.law import Law, Ranges, law_fault, own
from hfc_design.controllers.gains.settings import GainsSettings
from hfc_design.controllers.kind import ControllerRecord, Kind, later
from hfc_design.core.records import Finite, Label, UserError

#: The genome of a kind with settings of ``settings_of`` and ``Kind.of_gains``.
genome_of_gains = later("hfc_design.controllers.gains.genome", "genome_of")


class LawDesign(ControllerRecord):
    """A controller of a user's own law, see ``law.Law``."""

    gains: dict[Label, Finite]


def kind_of(law: Law) -> Kind:
    """The kind of a user's own ``law``.

    Raises:
        UserError: the law cannot be searched.
    """
    if fault := law_fault(law):
        raise UserError(f"controller {law.name!r}: {fault}")
    names = law.ranges._fields

    class Design(LawDesign):
        @model_validator(mode="after")
        def _known(self) -> "Design":
            if set(self.gains) != set(names):
                raise ValueError(f"gains: has to hold {', '.join(names)} and nothing else")
            return self

    return Kind(
        name=law.name,
        summary="an own law",
        record=Design,
        settings=settings_of(law.ranges),
        gains=lambda record: type(law.ranges)(**record.gains),
        law=lambda record, limit: own(law, record.sample_time_s, limit),
        genome=genome_of_gains,
        of_gains=lambda gains: {"gains": gains},
    )


def settings_of(own: Ranges) -> type[GainsSettings]:
    """The settings of a kind whose gains have the ranges ``own``, a NamedTuple."""

    class Settings(GainsSettings):
        own_ranges = own

    return Settings
