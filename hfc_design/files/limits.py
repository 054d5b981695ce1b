"""Settings of a machine's axes, and the limits among them. Never imports JAX."""

from operator import not_
from typing import TypeVar

from pydantic import Field, JsonValue, ValidationError, model_validator

from hfc_design.core.records import Label, Positive, Record

Own = TypeVar("Own", bound="PerAxisRecord")


class PerAxisRecord(Record):
    """Settings of every axis; ``axes`` has what differs in one of them."""

    axes: dict[Label, dict[str, JsonValue]] = Field({}, exclude_if=not_)

    @model_validator(mode="after")
    def _axes_fit(self: Own) -> Own:
        for axis, own in self.axes.items():
            try:
                self.of(axis)
            except ValidationError as error:
                first = error.errors()[0]
                key = ".".join(map(str, first["loc"]))
                raise ValueError(f"axes.{axis}.{key} = {own.get(key)!r}: {first['msg']}") from None
        return self

    def of(self: Own, axis: str) -> Own:
        """The settings of one axis."""
        own = self.axes.get(axis)
        return self if own is None else type(self)(**self.model_dump(exclude={"axes"}) | own)


class Limits(PerAxisRecord):
    """Limits of the drives, in the units of the plant."""

    command: Positive | None = None
