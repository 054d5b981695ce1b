"""Plants as entries: what each is, its parameters, the signals and the metrics that it has."""

import inspect
import sys
from collections.abc import Iterator
from contextlib import suppress
from math import nan

from hfc_design.formats.writing import MEANINGS, meanings_of
from hfc_design.gather.comments import Comment, comments_of, said
from hfc_design.gather.texts import described, source_in
from hfc_design.motion.contour import contour_meanings
from hfc_design.objectives.metrics import meanings
from hfc_design.objectives.program_metrics import program_meanings
from hfc_design.reference.entries import PLANT, Entry
from plants import Drive, Machine, machine_of

#: What no format has to tell of the signals of every drive.
COMMON = {
    "command": "what the controller gives",
    "load": "what pushes against the drive, positive against forward motion",
}


def plant_entries(plant: Drive | Machine) -> Iterator[Entry]:
    """The entries of a plant."""
    machine = machine_of(plant)
    module = sys.modules.get(getattr(machine.drives[0].step, "__module__", ""))
    text = inspect.getdoc(module) or "" if module else ""
    head = Entry(PLANT, plant.name)
    several = len(machine.axes) > 1
    axes = ", ".join(machine.axes) if several else "one"
    own = _beside(machine) if isinstance(plant, Machine) else described(text)
    yield head._replace(meaning=own or "a drive of one axis", source=source_in(text))
    yield head._replace(part="fact", key="axes", meaning=axes)
    for axis, drive in zip(machine.axes, machine.drives, strict=True):
        yield from _parameters(head, f"axes.{axis}" if several else "parameters", drive)
        yield from _signals(head, f"{axis}." if several else "", drive)
    yield from _metrics(head, machine)


def _beside(machine: Machine) -> str:
    """What a machine is made of."""
    drives = ", ".join(dict.fromkeys(drive.name for drive in machine.drives))
    coupled = "; they push one another" if machine.forces else ""
    return f"axes {', '.join(machine.axes)} with the drives {drives}{coupled}"


def _parameters(head: Entry, table: str, drive: Drive) -> Iterator[Entry]:
    comments = comments_of(drive.parameters)
    for name, value in drive.parameters()._asdict().items():
        told = comments.get(name, Comment())
        yield head._replace(
            part="parameter",
            key=f"plant.{table}.{name}",
            type="number",
            unit=drive.parameter_units.get(name) or told.unit,
            default=value,
            allowed=_allowed(drive, name),
            meaning=told.meaning,
            source=source_in(told.meaning),
        )


def _allowed(drive: Drive, name: str) -> str:
    """What a parameter may be, as the drive says of a value that nothing may be."""
    with suppress(Exception):  # a user's own code
        return (drive.fault({name: nan}) or "").partition("has to be ")[2]
    return ""


def _signals(head: Entry, axis: str, drive: Drive) -> Iterator[Entry]:
    told = MEANINGS | COMMON | meanings_of(drive)
    for name, unit in drive.units.items():
        one = head._replace(part="signal", key=axis + name, type="number", unit=unit)
        yield one._replace(meaning=told.get(name, ""))


def _metrics(head: Entry, machine: Machine) -> Iterator[Entry]:
    """What is read off a motion: of one axis; of two on a path in X-Y; of a program."""
    drive = machine.drives[0]
    if len(machine.axes) > 1:
        found = program_meanings(machine)
    else:
        found = meanings(drive)
        if drive.millimetres is not None:
            path = contour_meanings([drive, drive])
            found |= {name: f"in X-Y: {told}" for name, told in path.items() if name not in found}
    for name, told in found.items():
        meaning, unit = said(told)
        yield head._replace(part="metric", key=name, type="number", unit=unit, meaning=meaning)
