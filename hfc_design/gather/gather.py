"""Everything that a user can name, gathered from the code.

Imports all of the package, and with it JAX; whoever only reads has ``reference.entries``.
"""

import importlib
import inspect
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from importlib.util import find_spec
from math import nan
from typing import Any

from pydantic import BaseModel

from hfc_design.controllers.kind import ControllerRecord
from hfc_design.controllers.kinds import KINDS
from hfc_design.core.plugins import Group
from hfc_design.core.texts import read_toml
from hfc_design.files.design import Design, builtin_designs, named_design
from hfc_design.files.machine import ALL_PLANTS
from hfc_design.files.motions import AnyReference
from hfc_design.files.named_scenario import BUILTIN, builtin_names
from hfc_design.files.scenario import DEFAULT_KIND, Scenario
from hfc_design.formats import FORMATS
from hfc_design.formats.writing import MEANINGS, meanings_of
from hfc_design.gather.comments import Comment, comments_of, described, first_line, said, source_in
from hfc_design.gather.fields import fields_of, plain, records_in
from hfc_design.motion.contour import contour_meanings
from hfc_design.motion.references import Load
from hfc_design.objectives.judge import OBJECTIVES
from hfc_design.objectives.measures import MEASURES, band_time
from hfc_design.objectives.metrics import meanings
from hfc_design.objectives.objective import Objective, ObjectiveSettings
from hfc_design.objectives.program_metrics import program_meanings
from hfc_design.reference import entries as reference
from hfc_design.reference.entries import Entry
from hfc_design.search.loop import STRATEGIES
from hfc_design.search.strategy import Strategy
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
    head = Entry(reference.PLANT, plant.name)
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


def kind_entries(kind: type[ControllerRecord]) -> Iterator[Entry]:
    """The entries of a kind of controller: what is searched, what stands in a design file."""
    texts = [_law_text(kind), kind.summary]
    found = [*filter(None, map(source_in, texts))]
    source = max(found, key=len, default="")  # the one that has an equation too
    head = Entry(reference.CONTROLLER, kind.name)
    yield head._replace(meaning=kind.summary, source=source)
    if kind.settings is not None:
        own = head._replace(part="setting")
        yield from fields_of(kind.settings, "controller.", own, (ControllerRecord,))
        yield from _ranges(kind.settings, own)
    named = _told_elsewhere(kind)
    for entry in fields_of(kind.record, "controller.", head._replace(part="design"), ()):
        told = named.get(entry.key.rpartition(".")[2]) if not entry.meaning else None
        yield entry if told is None else entry._replace(meaning=told.meaning, unit=told.unit)


def _law_text(kind: type[ControllerRecord]) -> str:
    """What the module of a kind's law says of it."""
    package = kind.record.__module__.removesuffix(".record")
    if find_spec(package) is None or not hasattr(sys.modules[package], "__path__"):
        return ""  # a user's own
    if find_spec(f"{package}.law") is None:
        return ""
    return inspect.getdoc(importlib.import_module(f"{package}.law")) or ""


def _ranges(settings: type[Any], head: Entry) -> Iterator[Entry]:
    """Where a search of a few gains looks, if nothing else is told."""
    own = getattr(settings, "own_ranges", None)
    if own is None:
        return
    said = comments_of(type(own))
    for name, pair in own._asdict().items():
        told = said.get(name, Comment())
        yield head._replace(
            key=f"controller.ranges.{name}",
            type="list of numbers",
            unit=told.unit,
            default=list(pair),
            allowed="[low, high]",
            meaning=told.meaning,
        )


def _told_elsewhere(kind: type[ControllerRecord]) -> dict[str, Comment]:
    """Comments on the gains of a kind whose record was made of them."""
    own = getattr(kind.settings, "own_ranges", None)
    return {} if own is None else comments_of(type(own))


def strategy_entries(strategy: Strategy) -> Iterator[Entry]:
    """The entries of a search strategy."""
    module = sys.modules.get(strategy.settings.__module__)
    text = first_line(inspect.getdoc(module) or "" if module else "")
    head = Entry(reference.STRATEGY, strategy.name)
    yield head._replace(meaning=strategy.summary, source=source_in(text))
    yield from fields_of(strategy.settings, "search.", head._replace(part="setting"))


def objective_entries(objective: Objective) -> Iterator[Entry]:
    """The entries of an objective."""
    module = sys.modules.get(objective.settings.__module__)
    own = objective.settings is not ObjectiveSettings
    text = first_line(inspect.getdoc(module) or "" if module and own else "")
    head = Entry(reference.OBJECTIVE, objective.name)
    told = said(objective.meaning or objective.title).meaning
    yield head._replace(meaning=told, unit=objective.unit, source=source_in(text))
    yield from fields_of(objective.settings, "fitness.", head._replace(part="setting"))


def reference_entries(record: type[BaseModel], passed: tuple[type[Any], ...]) -> Iterator[Entry]:
    """The entries of a kind of reference."""
    head = Entry(reference.REFERENCE, str(record.model_fields["kind"].default))
    yield head._replace(meaning=first_line(inspect.getdoc(record) or ""))
    setting = head._replace(part="setting")
    yield from fields_of(record, "reference.", setting, passed)


#: Plug-ins by the kind of their entries, and what makes these of one.
PLUGINS: dict[str, tuple[Group[Any], Callable[[Any], Iterator[Entry]]]] = {
    reference.PLANT: (ALL_PLANTS, plant_entries),
    reference.CONTROLLER: (KINDS, kind_entries),
    reference.STRATEGY: (STRATEGIES, strategy_entries),
    reference.OBJECTIVE: (OBJECTIVES, objective_entries),
}
#: Tables with the keys of [load].
AS_LOAD = "motions.N.load.", "load.axes.AXIS."
#: Tables of a scenario whose keys are those of what they name: the key that names it, its default.
CHOSEN = {
    "reference": ("kind", "ramp"),
    "fitness": ("kind", "lin-lee"),
    "controller": ("kind", DEFAULT_KIND),
    "search": ("preset", "race"),
}


def gather() -> list[Entry]:
    """Every entry of what is built in."""
    references = records_in(AnyReference)
    found = [*_keys(references), *fields_of(Design, "", Entry(reference.DESIGN_KEY, ""))]
    for group, entries_of in PLUGINS.values():
        for name in group.names():
            if name in group.built_in:
                found += entries_of(group.get(name))
    for record in references:
        found += reference_entries(record, (*references, Load))
    for one in (*MEASURES.values(), band_time(0.0)):
        meaning = one.meaning.replace("within 0", "within the band that is told beside it")
        found.append(
            Entry(reference.METRIC, one.name, type="number", unit=one.unit, meaning=meaning)
        )
    found += [Entry(reference.FORMAT, one.name, meaning=one.text) for one in FORMATS.values()]
    for name in builtin_names():
        told = read_toml(BUILTIN / f"{name}.toml").get("description", "")
        found.append(Entry(reference.SCENARIO, name, meaning=told))
    for name in builtin_designs():
        told = str(named_design(name).provenance["source"])
        found.append(Entry(reference.DESIGN, name, meaning=told))
    return [one._replace(name=one.name or one.key) for one in found]


def live(kind: str, name: str) -> list[Entry]:
    """The entries of one plug-in, an own one too: a name that is known, or ``module:OBJECT``.

    Raises:
        UserError: there is none.
    """
    group, entries_of = PLUGINS[kind]
    return [*entries_of(group.resolve(name))]


def _keys(references: list[type[BaseModel]]) -> Iterator[Entry]:
    """The keys of every scenario."""
    for one in fields_of(Scenario, "", Entry(reference.KEY, ""), tuple(references)):
        table, _, rest = one.key.partition(".")
        if one.key.startswith(AS_LOAD):
            continue
        if table not in CHOSEN:
            yield one._replace(required=one.required and one.key != "name")  # a file has a name
        elif not rest:
            yield one
            yield _choice(table, references)


def _choice(table: str, references: list[type[BaseModel]]) -> Entry:
    """The key of a table that names what its other keys belong to."""
    key, default = CHOSEN[table]
    groups: dict[str, Group[Any]] = {
        "fitness": OBJECTIVES,
        "controller": KINDS,
        "search": STRATEGIES,
    }
    names = [plain(one.model_fields["kind"].default) for one in references]
    if table in groups:
        group = groups[table]
        names = [name for name in group.names() if name in group.built_in]
    own = Entry(reference.KEY, "", key=f"{table}.{key}", type="text", default=default)
    return own._replace(allowed=", ".join(names), meaning="which one")
