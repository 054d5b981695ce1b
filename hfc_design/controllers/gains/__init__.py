"""Kinds whose parameters are a few gains: pd, pid, and every law of a user's own.

The folder is no kind itself; ``kind_of`` makes one of a law. Never imports JAX.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar

from pydantic import create_model, model_validator

from hfc_design.controllers.controller import AxisLaw
from hfc_design.controllers.gains.law import Law, Range, Ranges, law_fault, own, range_fault
from hfc_design.controllers.kind import ControllerRecord, ControllerSettings, Kind, later
from hfc_design.core.records import Finite, Label, Record, UserError

#: The genome of a kind with settings of ``settings_of`` and ``Kind.of_gains``.
genome_of_gains = later("hfc_design.controllers.gains.genome", "GainsGenome")


class GainsSettings(ControllerSettings):
    """A controller whose gains are a few numbers, and the ranges in which a search looks."""

    own_ranges: ClassVar[Ranges]  # of the kind
    ranges: dict[Label, tuple[Finite, Finite]] = {}  # other than the kind's own

    @model_validator(mode="after")
    def _fit(self) -> "GainsSettings":
        own = self.own_ranges._fields
        for name, pair in self.ranges.items():
            fault = range_fault(pair) if name in own else f"unknown; there is {', '.join(own)}"
            if fault:
                raise ValueError(f"ranges.{name}: {fault}")
        return self

    def searched(self) -> Ranges:
        """The ranges to search, a NamedTuple of the kind's."""
        changed: dict[str, Range] = dict(self.ranges)
        return self.own_ranges._replace(**changed)


def settings_of(own: Ranges) -> type[GainsSettings]:
    """The settings of a kind whose gains have the ranges ``own``, a NamedTuple."""

    class Settings(GainsSettings):
        own_ranges = own

    return Settings


def kind_of_gains(
    name: str,
    ranges: Ranges,
    law: Callable[[float, float | None], AxisLaw],
    record: type[ControllerRecord] | None = None,
    **further: Any,
) -> Kind:
    """A kind whose gains have ``ranges``, with a law of (sample time [s], limit of the command).

    Its ``record`` has them under ``gains``; without one they stand in a design file under the
    name of the kind. ``further`` are fields of ``Kind``.
    """
    key = "gains" if record else name
    if record is None:
        numbers: Any = dict.fromkeys(ranges._fields, (Finite, ...))
        gains: Any = {name: (create_model("Gains", __base__=Record, **numbers), ...)}
        record = create_model("Design", __base__=ControllerRecord, **gains)
    return Kind(
        name=name,
        record=record,
        settings=settings_of(ranges),
        gains=lambda record: type(ranges)(**dict(getattr(record, key))),
        law=lambda record, limit: law(record.sample_time_s, limit),
        genome=genome_of_gains,
        of_gains=lambda gains: {key: gains},
        **further,
    )


def kind_of(law: Law) -> Kind:
    """The kind of a user's own ``law``.

    Raises:
        UserError: the law cannot be searched.
    """
    if fault := law_fault(law):
        raise UserError(f"controller {law.name!r}: {fault}")
    names = law.ranges._fields

    class Design(ControllerRecord):
        """A controller of the law."""

        gains: dict[Label, Finite]

        @model_validator(mode="after")
        def _known(self) -> "Design":
            if set(self.gains) != set(names):
                raise ValueError(f"gains: has to hold {', '.join(names)} and nothing else")
            return self

    return kind_of_gains(law.name, law.ranges, partial(own, law), Design, summary="an own law")
