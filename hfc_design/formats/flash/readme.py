"""The page on a design: what to connect, how it was made, what happens, how it is checked."""

from typing import NamedTuple

from hfc_design.controllers.controller import units_of
from hfc_design.controllers.kind import kinds
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Json
from hfc_design.files.design import Design
from hfc_design.files.machine import PlantSettings
from hfc_design.files.pairing import axes_of
from hfc_design.formats import saving
from hfc_design.formats.flash.sensing import scene
from hfc_design.formats.flash.vectors import Vectors
from hfc_design.formats.writing import MEANINGS, meanings_of, plain, signal_meanings, signal_units


class Signal(NamedTuple):
    """A row of the table of what is connected."""

    name: str
    axes: str  # that it is of, "" where it is of all
    unit: str
    meaning: str


def values(design: Design, found: Vectors) -> Json:
    """What the templates of the page read."""
    record = design.controller
    read = design.kind.reads(record) if design.kind.reads else []
    axes = found.axes if found.axes != ("",) else ()
    return {
        "design": design,
        "kind": design.kind.name,
        "axes": found.axes,
        "signals": _signals(design, list(read), axes),
        "commands": _signals(design, ["command"], axes),
        "path": found.path,
        "scene": scene(design, read),
        "connecting": _connecting(design, axes),
        "limits": {axis: design.limits.of(axis).command for axis in axes or (design.axis,)},
        "changes": design.changes(axes or (design.axis,)),
        "score": told(design.score),
        "source": source(design),
        "vectors": found,
        "learns": saving.learns(design),
    }


def _signals(design: Design, names: list[str], axes: tuple[str, ...]) -> list[Signal]:
    """Unit and meaning of each signal; axes whose drives differ have rows of their own."""
    units, meanings = signal_units(design), signal_meanings(design)
    if units or not axes:
        each = [(identifier(x), units.get(x, "")) for x in names]
        return [Signal(x, "", unit, plain(meanings.get(x, ""))) for x, unit in each]
    rows: dict[tuple[str, str, str], list[str]] = {}
    for axis in PlantSettings(**design.plant.model_dump()).each():
        own, told = units_of(axis.drive.units), MEANINGS | meanings_of(axis.drive)
        for name in names:
            row = identifier(name), own.get(name, ""), plain(told.get(name, ""))
            rows.setdefault(row, []).append(axis.name)
    return [Signal(row[0], ", ".join(of), *row[1:]) for row, of in sorted(rows.items())]


def _connecting(design: Design, axes: tuple[str, ...]) -> list[str]:
    """What the kind says, and what is inside of it, once each."""
    record = design.controller
    found = list(design.kind.connecting(record))
    inside = design.kind.inside.records(record, axes_of(design)) if design.kind.inside else {}
    for own in inside.values():
        found += kinds().get(own.kind).connecting(own)
    return list(dict.fromkeys(found))


def source(design: Design) -> str:
    """Where a design says that it comes from."""
    return plain(str(design.provenance.get("source", "")))


def told(score: Json) -> dict[str, str]:
    """What the score of a design says in numbers and words."""
    return {
        plain(key): f"{value:.6g}" if isinstance(value, float) else plain(str(value))
        for key, value in score.items()
        if isinstance(value, str | int | float)
    }
