"""Everything that a user can name, gathered from the code.

This imports the whole package with JAX; ``reference.entries`` reads the result without JAX.
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
from hfc_design.motion.references import Load
from hfc_design.objectives.judge import OBJECTIVES
from hfc_design.objectives.metric import ALONE, PLANE, PROGRAM
from hfc_design.objectives.metrics import METRICS, RUNNING, band_time
from hfc_design.objectives.objective import Objective, ObjectiveSettings
from hfc_design.objectives.tables import columns
from hfc_design.reference import entries as reference
from hfc_design.reference.entries import Entry
from hfc_design.schema.comments import Comment, comments_of, described, first_line, said, source_in
from hfc_design.schema.fields import fields_of, records_in
from hfc_design.search.loop import STRATEGIES
from hfc_design.search.strategy import Strategy
from hfc_design.stability.margins import MEANT
from plants import Drive, Machine, machine_of

#: Meanings of signals that every drive has, in addition to ``writing.MEANINGS``.
COMMON = {
    "command": "output of the controller",
    "load": "force or torque against the drive, positive against forward motion",
}


def plant_entries(plant: Drive | Machine) -> Iterator[Entry]:
    """Yield the entries of a plant: itself, axes, parameters, signals and metrics."""
    machine = machine_of(plant)
    drives = dict.fromkeys(drive.name for drive in machine.drives)
    text = _docstring(getattr(machine.drives[0].step, "__module__", ""))
    head = Entry(reference.PLANT, plant.name)
    several = len(machine.axes) > 1
    meaning = described(text) or "a drive of one axis"
    if isinstance(plant, Machine):
        coupled = "; they are coupled" if machine.forces else ""
        meaning = f"axes {', '.join(machine.axes)} with the drives {', '.join(drives)}{coupled}"
    yield head._replace(meaning=meaning, source=source_in(text))
    axes = ", ".join(machine.axes) if several else "one"
    yield head._replace(part="fact", key="axes", meaning=axes)
    for axis, drive in zip(machine.axes, machine.drives, strict=True):
        yield from _parameters(head, f"axes.{axis}" if several else "parameters", drive)
        known = MEANINGS | COMMON | meanings_of(drive)
        for name, unit in drive.units.items():
            key = f"{axis}.{name}" if several else name
            one = head._replace(part="signal", key=key, type="number", unit=unit)
            yield one._replace(meaning=known.get(name, ""))
    for name, text in _metrics(machine).items():
        comment = said(text)
        one = head._replace(part="metric", key=name, type="number", unit=comment.unit)
        yield one._replace(meaning=comment.meaning)


def _docstring(module: str) -> str:
    """Return the docstring of a module; "" if the module is not loaded."""
    return inspect.getdoc(sys.modules[module]) or "" if module in sys.modules else ""


def _parameters(head: Entry, table: str, drive: Drive) -> Iterator[Entry]:
    comments = comments_of(drive.parameters)
    for name, value in drive.parameters()._asdict().items():
        comment, allowed = comments.get(name, Comment()), ""
        with suppress(Exception):  # a user's own ``fault`` may not take nan
            allowed = (drive.fault({name: nan}) or "").partition("must be ")[2]
        yield head._replace(
            part="parameter",
            key=f"plant.{table}.{name}",
            type="number",
            unit=drive.parameter_units.get(name) or comment.unit,
            default=value,
            allowed=allowed,
            meaning=comment.meaning,
            source=source_in(comment.meaning),
        )


def _metrics(machine: Machine) -> dict[str, str]:
    """Return metric -> its comment, for a motion of one axis, in X-Y, or of a program."""
    drive = machine.drives[0]
    tables = {"": columns(machine, PROGRAM if len(machine.axes) > 1 else ALONE)}
    if len(machine.axes) == 1 and drive.millimetres is not None:
        tables["in X-Y: "] = columns(Machine("", ("x", "y"), (drive, drive)), PLANE, 2)
    texts: dict[str, str] = {}
    for where, table in tables.items():
        for key, column in table.items():
            texts.setdefault(key, where + column.meaning)
    return texts


def kind_entries(kind: type[ControllerRecord]) -> Iterator[Entry]:
    """Yield the entries of a kind of controller: settings of a search, keys of a design file."""
    sources = [source_in(text) for text in (_law_text(kind), kind.summary)]
    source = max(sources, key=len)  # a source with an equation is longer
    head = Entry(reference.CONTROLLER, kind.name)
    yield head._replace(meaning=kind.summary, source=source)
    setting = head._replace(part="setting")
    ranges = getattr(kind.settings, "own_ranges", None)  # of gains in a search
    gains = {} if ranges is None else comments_of(type(ranges))
    if kind.settings is not None:
        yield from fields_of(kind.settings, "controller.", setting, (ControllerRecord,))
    for name, pair in ranges._asdict().items() if ranges is not None else ():
        comment = gains.get(name, Comment())
        yield setting._replace(
            key=f"controller.ranges.{name}",
            type="list of numbers",
            unit=comment.unit,
            default=list(pair),
            allowed="[low, high]",
            meaning=comment.meaning,
        )
    for entry in fields_of(kind.record, "controller.", head._replace(part="design")):
        # A kind that consists of gains has comments at these, not at its record.
        gain = None if entry.meaning else gains.get(entry.key.rpartition(".")[2])
        yield entry if gain is None else entry._replace(meaning=gain.meaning, unit=gain.unit)


def _law_text(kind: type[ControllerRecord]) -> str:
    """Return the docstring of the module of a kind's control law; "" if there is none."""
    package = kind.record.__module__.removesuffix(".record")
    if not hasattr(sys.modules.get(package), "__path__") or find_spec(f"{package}.law") is None:
        return ""  # a user's own kind
    return inspect.getdoc(importlib.import_module(f"{package}.law")) or ""


def strategy_entries(strategy: Strategy) -> Iterator[Entry]:
    """Yield the entries of a search strategy."""
    text = first_line(_docstring(strategy.settings.__module__))
    head = Entry(reference.STRATEGY, strategy.name)
    yield head._replace(meaning=strategy.summary, source=source_in(text))
    yield from fields_of(strategy.settings, "search.", head._replace(part="setting"))


def objective_entries(objective: Objective) -> Iterator[Entry]:
    """Yield the entries of an objective."""
    plain = objective.settings is ObjectiveSettings
    text = "" if plain else first_line(_docstring(objective.settings.__module__))
    head = Entry(reference.OBJECTIVE, objective.name)
    meaning = said(objective.meaning or objective.title).meaning
    yield head._replace(meaning=meaning, unit=objective.unit, source=source_in(text))
    yield from fields_of(objective.settings, "fitness.", head._replace(part="setting"))


def reference_entries(record: type[BaseModel], passed: tuple[type[Any], ...]) -> Iterator[Entry]:
    """Yield the entries of a kind of reference; for ``passed`` see ``fields_of``."""
    head = Entry(reference.REFERENCE, str(record.model_fields["kind"].default))
    yield head._replace(meaning=first_line(inspect.getdoc(record) or ""))
    setting = head._replace(part="setting")
    yield from fields_of(record, "reference.", setting, passed)


#: Kinds of entries -> the plug-ins of that kind, and the function that makes their entries.
PLUGINS: dict[str, tuple[Group[Any], Callable[[Any], Iterator[Entry]]]] = {
    reference.PLANT: (ALL_PLANTS, plant_entries),
    reference.CONTROLLER: (KINDS, kind_entries),
    reference.STRATEGY: (STRATEGIES, strategy_entries),
    reference.OBJECTIVE: (OBJECTIVES, objective_entries),
}
#: Tables with the same keys as [load], which get no entries of their own.
AS_LOAD = "motions.N.load.", "load.axes.AXIS."
#: Tables of a scenario whose keys depend on the kind that they name: the key with the name, its
#: default, and the available kinds.
CHOSEN: dict[str, tuple[str, str, Group[Any] | None]] = {
    "reference": ("kind", "ramp", None),
    "fitness": ("kind", "lin-lee", OBJECTIVES),
    "controller": ("kind", DEFAULT_KIND, KINDS),
    "search": ("preset", "race", STRATEGIES),
}


def collect() -> list[Entry]:
    """Return every entry: keys of files, and the built-in parts of every kind."""
    references = records_in(AnyReference)
    entries = [*_keys(references), *fields_of(Design, "", Entry(reference.DESIGN_KEY, ""))]
    for group, entries_of in PLUGINS.values():
        for name in _built_in(group):
            entries += entries_of(group.get(name))
    for record in references:
        entries += reference_entries(record, (*references, Load))
    tabled = (one for one in METRICS if one.name not in RUNNING)
    for one in (*RUNNING.values(), band_time(0.0), *tabled):
        meaning = one.meaning.replace("within 0", "within the band given with it")
        metric = Entry(reference.METRIC, one.name, type="number", unit=one.unit, meaning=meaning)
        entries.append(metric._replace(allowed="" if one.running else reference.IN_TABLES))
    for name, (unit, meaning) in MEANT.items():
        metric = Entry(reference.METRIC, name, type="number", unit=unit, meaning=meaning)
        entries.append(metric._replace(allowed=reference.IN_CONSTRAINTS))
    entries += [Entry(reference.FORMAT, one.name, meaning=one.text) for one in FORMATS.values()]
    for name in builtin_names():
        meaning = read_toml(BUILTIN / f"{name}.toml").get("description", "")
        entries.append(Entry(reference.SCENARIO, name, meaning=meaning))
    for name in builtin_designs():
        design = named_design(name)
        whole = f"{design.kind.name} for {design.plant.name}: {design.provenance['source']}"
        entries.append(Entry(reference.DESIGN, name, meaning=whole))
    return [one._replace(name=one.name or one.key) for one in entries]


def live(kind: str, name: str) -> list[Entry]:
    """Return the entries of one plug-in; ``name`` is a known name, or ``module:OBJECT``.

    Raises:
        UserError: the plug-in does not exist.
    """
    group, entries_of = PLUGINS[kind]
    return [*entries_of(group.resolve(name))]


def _built_in(group: Group[Any]) -> list[str]:
    return [name for name in group.names() if name in group.built_in]


def _keys(references: list[type[BaseModel]]) -> Iterator[Entry]:
    """Yield the entries of the keys that every scenario may have."""
    for one in fields_of(Scenario, "", Entry(reference.KEY, ""), tuple(references)):
        table, _, rest = one.key.partition(".")
        if one.key.startswith(AS_LOAD):
            continue
        if table not in CHOSEN:
            yield one._replace(required=one.required and one.key != "name")  # the file names it
        elif not rest:
            yield one
            key, default, group = CHOSEN[table]
            kinds = [str(record.model_fields["kind"].default) for record in references]
            names = kinds if group is None else _built_in(group)
            choice = Entry(reference.KEY, "", key=f"{table}.{key}", type="text", default=default)
            yield choice._replace(allowed=", ".join(names), meaning="which one")
