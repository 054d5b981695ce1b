"""Separate controllers of any kinds for the axes of a machine, each with its own gains.

This file has the record, the settings and the genome. Never imports JAX.
"""

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, SerializeAsAny, model_validator

from hfc_design.controllers.controller import PerAxis
from hfc_design.controllers.kind import (
    ControllerRecord,
    ControllerSettings,
    Limits,
    ReportContext,
    Target,
    kinds,
    later,
)
from hfc_design.controllers.product_genome import ProductGenome, ProductPopulation
from hfc_design.core.numbers import Gains, Json, Memory, Plain
from hfc_design.core.plugins import chosen
from hfc_design.core.records import Label, UserError

#: ``no_rules`` of kinds with inner controllers.
INSIDE = "it has rule tables only in its axis controllers; export it as c, st, js, m or fmu"
OwnRecord = Annotated[SerializeAsAny[ControllerRecord], chosen(kinds, "record")]
OwnSettings = Annotated[SerializeAsAny[ControllerSettings], chosen(kinds, "settings")]


def sampled_alike(key: str, part: ControllerRecord, sample_time: float) -> None:
    """Check that the inner controller under ``key`` has this sample time; else ValueError."""
    if part.sample_time_s != sample_time:
        needed = f"must be the sample time of the whole controller, {sample_time}"
        raise ValueError(f"{key}.sample_time_s = {part.sample_time_s}: {needed}")


def _timed(data: Json, part: Plain) -> Plain:
    """Return the data of an inner controller with the sample time of the whole, if it has none."""
    every = {key: data[key] for key in ("sample_time_s",) if key in data}
    return every | part if isinstance(part, dict) else part


class PerAxisDesign(ControllerRecord):
    """Design of kind ``per-axis``: controllers of any kinds by axis, in the machine's order."""

    kind: Literal["per-axis"] = "per-axis"
    summary = "a separate controller for every axis of a machine"
    settings = later(".", "PerAxisSettings")
    genome = later(".", "PerAxisGenome")
    no_rules = INSIDE
    #: controller of each axis by its name
    axes: Annotated[dict[Label, OwnRecord], Field(min_length=1)]

    @classmethod
    def renewed(cls, data: Json, keys: list[str]) -> None:
        """Apply ``renewed`` of the kind of each axis to the data of that axis."""
        axes = data.get("axes")
        for axis, axis_data in axes.items() if isinstance(axes, dict) else ():
            start = f"axes.{axis}."
            axis_keys = [key.removeprefix(start) for key in keys if key.startswith(start)]
            known = isinstance(axis_data, dict) and axis_data.get("kind") in kinds().names()
            if axis_keys and known:
                try:
                    kinds().get(axis_data["kind"]).record.renewed(axis_data, axis_keys)
                except ValueError as error:
                    raise ValueError(f"{start}{error}") from None

    @model_validator(mode="before")
    @classmethod
    def _sampled_alike(cls, data: Plain) -> Plain:
        """Return the data with the common sample time in each axis that has none."""
        if not isinstance(data, dict) or not isinstance(data.get("axes"), dict):
            return data
        return data | {"axes": {axis: _timed(data, x) for axis, x in data["axes"].items()}}

    @model_validator(mode="after")
    def _steps_at_once(self) -> "PerAxisDesign":
        for axis, design in self.axes.items():
            sampled_alike(f"axes.{axis}", design, self.sample_time_s)
        return self

    def law_gains(self) -> tuple[Gains, ...]:
        """Return the gains of each axis."""
        return tuple(design.law_gains() for design in self.axes.values())

    def axis_records(self) -> dict[str, ControllerRecord]:
        """Return the record of each axis by its name."""
        return self.axes

    def controller(self, limits: Limits) -> PerAxis:
        """Return the controller on axes with these limits.

        Raises:
            UserError: the machine has other axes, or another order of them.
        """
        if tuple(self.axes) != tuple(limits):
            got = f"(got {', '.join(self.axes)})"
            raise UserError(f"controller.axes: must be {', '.join(limits)} {got}")
        laws = (design.law(limits[axis]) for axis, design in self.axes.items())
        return PerAxis("per-axis", tuple(laws), own_gains=True)

    def learnt(self, axes: tuple[str, ...], memory: tuple[Memory, ...]) -> Self | None:
        """Return the design with what its axes learned in ``memory``; None if no axis learns."""
        learned = {}
        for (axis, design), remembered in zip(self.axes.items(), memory, strict=True):
            if design.adapted and (after := design.adapted(remembered)):
                learned[axis] = after
        return self.model_copy(update={"axes": self.axes | learned}) if learned else None

    def sections(self, shown: ReportContext) -> list[Any]:
        """Return the sections of all axes; titles begin with the name of the axis."""
        sections = []
        for axis, design in self.axes.items():
            each = design.sections(shown.of(axis))
            sections += [one._replace(title=f"{axis}: {one.title}") for one in each]
        return sections

    def structure(self) -> str:
        """Return each axis' structure, or its kind if it has only one; "" if all kinds have one."""
        structures = {axis: design.structure() for axis, design in self.axes.items()}
        each = (f"{axis}: {structures[axis] or design.kind}" for axis, design in self.axes.items())
        return ", ".join(each) if any(structures.values()) else ""


def learnt(
    record: ControllerRecord, axes: tuple[str, ...], memory: Memory
) -> ControllerRecord | None:
    """Return a controller with what it learned in ``memory``; None if it cannot learn.

    If ``axes`` with one common controller have learned different things, it is ``per-axis``.
    """
    if record.learnt is not None:
        learned: ControllerRecord | None = record.learnt(axes, memory)
        return learned
    records = [record.adapted(axis_memory) for axis_memory in memory] if record.adapted else [None]
    if records[0] is None or all(one == records[0] for one in records):
        return records[0]
    each = dict(zip(axes, records, strict=True))
    return PerAxisDesign(sample_time_s=record.sample_time_s, axes=each)


class OuterDesign(ControllerRecord):
    """Base of designs of a machine that contain an inner controller and add to its commands."""

    no_rules = INSIDE
    #: the inner controller: one that is used on every axis, per-axis, or one of a whole machine
    inner: OwnRecord

    @model_validator(mode="before")
    @classmethod
    def _sampled_alike(cls, data: Plain) -> Plain:
        """Return the data with the common sample time in an inner controller that has none."""
        if not isinstance(data, dict) or not isinstance(data.get("inner"), dict):
            return data
        return data | {"inner": _timed(data, data["inner"])}

    @model_validator(mode="after")
    def _steps_at_once(self) -> "OuterDesign":
        sampled_alike("inner", self.inner, self.sample_time_s)
        return self

    def inside(self, axes: tuple[str, ...]) -> dict[str, ControllerRecord]:
        """Return {axis: its inner controller}, or {"": the inner controller of all axes}."""
        if self.inner.axis_records is not None:
            return dict(self.inner.axis_records())
        return dict.fromkeys(axes if self.inner.law else ("",), self.inner)

    def structure(self) -> str:
        """Return the structure of the inner controller."""
        return self.inner.structure()

    def learnt(self, axes: tuple[str, ...], memory: Memory) -> Self | None:
        """Return the design with what the inner controller learned; None if it cannot learn."""
        inner = learnt(self.inner, axes, memory)
        return self.model_copy(update={"inner": inner}) if inner else None

    def inner_reads(self) -> list[str]:
        """Return the signals that the inner controllers read, of any axis; [] if not known."""
        axes = self.inner.axis_records
        signals: dict[str, None] = {}
        for record in axes().values() if axes else [self.inner]:
            if record.reads is None:
                return []
            signals |= dict.fromkeys(record.reads())
        return list(signals)


class PerAxisSettings(ControllerSettings):
    """Settings of a search for a controller of each axis."""

    kind: Literal["per-axis"]
    #: controller to search for on each axis, by its name
    axes: Annotated[dict[Label, OwnSettings], Field(min_length=1)]

    @property
    def staged(self) -> bool:
        """True if strategies that move a distribution can search the controllers of all axes."""
        return all(settings.staged for settings in self.axes.values())

    def fault(self, target: Target) -> str | None:
        """Return why the search is impossible (other axes, or a fault of one axis), or None."""
        if tuple(self.axes) != target.machine.axes:
            return f"controller.axes: must be {', '.join(target.machine.axes)}, in this order"
        for k, (axis, settings) in enumerate(self.axes.items()):
            if fault := settings.fault(target.of(k)):
                return fault.replace("controller.", f"controller.axes.{axis}.", 1)
        return None


class PerAxisGenome(ProductGenome):
    """Genome with one part for each axis; UserError: too many structures together."""

    def __init__(self, settings: PerAxisSettings, target: Target):
        axis_settings = enumerate(settings.axes.values())
        axes = [kinds().get(one.kind).genome(one, target.of(k)) for k, one in axis_settings]
        super().__init__(settings, target, axes, "axes")

    def notation(self, structure: int) -> str:
        """Return the notation of the structure of each axis, as one text."""
        trees = map(int, np.unravel_index(structure, self.counts))
        each = zip(self.settings.axes, self.each("notation", trees), strict=True)
        return ", ".join(f"{axis}: {notation}" for axis, notation in each)

    def record(self, individual: ProductPopulation) -> Json:
        """Return the record of a population of one, with the record of each axis."""
        each = zip(self.settings.axes, self.each("record", individual.parts), strict=True)
        return {"kind": "per-axis", "axes": dict(each)}


KIND = PerAxisDesign
