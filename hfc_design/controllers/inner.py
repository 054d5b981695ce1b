"""Controllers that have another one inside: their records, and what is inside of which axis.

Never imports JAX.
"""

from typing import Self

from pydantic import model_validator

from hfc_design.controllers.kind import ControllerRecord, Inside, kinds
from hfc_design.controllers.per_axis import OwnRecord, PerAxisDesign, sampled_alike
from hfc_design.core.numbers import Plain


class OuterDesign(ControllerRecord):
    """``inner`` is one controller for every axis, or ``per-axis``, or any of a whole machine."""

    #: what is inside: one controller for every axis, or per-axis, or any of a whole machine
    inner: OwnRecord

    @model_validator(mode="before")
    @classmethod
    def _sampled_alike(cls, data: Plain) -> Plain:
        """What is inside takes the sample time of the whole where it says none."""
        if not isinstance(data, dict) or not isinstance(data.get("inner"), dict):
            return data
        every = {key: data[key] for key in ("sample_time_s",) if key in data}
        return data | {"inner": every | data["inner"]}

    @model_validator(mode="after")
    def _steps_at_once(self) -> "OuterDesign":
        sampled_alike("inner", self.inner, self.sample_time_s)
        return self

    def inside(self, axes: tuple[str, ...]) -> dict[str, ControllerRecord]:
        """The controller of each of these axes by its name, or "" and that of all of them."""
        kind = kinds().get(self.inner.kind)
        if kind.axes is not None:
            return dict(kind.axes(self.inner))
        return dict.fromkeys(axes if kind.law else ("",), self.inner)

    def structure(self) -> str:
        """That of what is inside."""
        return kinds().get(self.inner.kind).structure(self.inner)

    def with_inside(self, records: dict[str, ControllerRecord]) -> Self:
        """The same with these controllers inside, by the names of axes or "" for all."""
        first, *others = records.values()
        inner = first
        if any(other != first for other in others):
            inner = PerAxisDesign(sample_time_s=self.sample_time_s, axes=records)
        return self.model_copy(update={"inner": inner})

    def inner_reads(self) -> list[str]:
        """What is read of any axis by what is inside; nothing where that is not known."""
        every = [self.inner] if not (axes := kinds().get(self.inner.kind).axes) else []
        every += axes(self.inner).values() if axes else []
        found: dict[str, None] = {}
        for record in every:
            reads = kinds().get(record.kind).reads
            if reads is None:
                return []
            found |= dict.fromkeys(reads(record))
        return list(found)


INSIDE = Inside(OuterDesign.inside, OuterDesign.with_inside)
