"""Kinds whose parameters are a few gains: pd, pid, and every law of a user's own.

The folder is no kind itself; ``kind_of`` makes one of a law. Never imports JAX.
"""

from collections.abc import Callable
from functools import partial
from math import isfinite
from typing import Any, ClassVar, NamedTuple, TypeAlias

from pydantic import create_model, model_validator

from hfc_design.controllers.controller import AxisLaw, Signals
from hfc_design.controllers.kind import ControllerRecord, ControllerSettings, Kind, later
from hfc_design.core.numbers import Gains, Memory, Scalar, Xp
from hfc_design.core.records import Finite, Label, Record, UserError

Range = tuple[float, float]
#: A NamedTuple of a ``Range`` for each gain.
Ranges: TypeAlias = Any


class Law(NamedTuple):
    """A control law as pure functions of scalars, and where its gains are searched::

        memory = law.initial_memory(0.0)
        command, memory = law.step(sample_time, gains, memory, signals)

    ``ranges`` is a NamedTuple of (low, high), ``gains`` one of the same class with numbers. A
    range above zero is searched by its logarithm, any other one on a straight line. ``signals``
    holds ``error``, ``error_rate`` and the plant's readings.
    """

    name: str  # the ``kind`` of a controller in a file
    ranges: Ranges
    initial_memory: Callable[[Scalar], Memory]
    step: Callable[[float, Gains, Memory, dict[str, Scalar]], tuple[Scalar, Memory]]


def own(law: Law, sample_time: float, limit: float | None = None) -> AxisLaw:
    """The user's ``law`` as that of an axis."""
    return AxisLaw(_sample, _initial_memory, sample_time, limit, law)


def _initial_memory(law: AxisLaw, zero: Scalar) -> Memory:
    return law.structure.initial_memory(zero)


def _sample(
    xp: Xp, law: AxisLaw, gains: Gains, memory: Memory, signals: Signals
) -> tuple[Scalar, Memory, None]:
    return *law.structure.step(law.sample_time, gains, memory, signals), None


def range_fault(pair: Any) -> str | None:
    """What is wrong with a range, in a line; None if nothing is."""
    numbers = isinstance(pair, tuple) and all(isinstance(end, int | float) for end in pair)
    if not numbers or len(pair) != 2 or not all(map(isfinite, pair)):
        return f"{pair!r} is no tuple of two finite numbers"
    return None if pair[0] < pair[1] else f"{pair!r} has to be (low, high)"


def law_fault(law: Law) -> str | None:
    """What keeps a law from being searched, in a line; None if nothing does."""
    if not getattr(law.ranges, "_fields", ()):
        return "ranges has to be a NamedTuple of (low, high)"
    for name, pair in law.ranges._asdict().items():
        if fault := range_fault(pair):
            return f"ranges.{name}: {fault}"
    return None


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
