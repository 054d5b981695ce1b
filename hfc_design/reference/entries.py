"""Entries of the reference from the data file of the package, and keys of a scenario.

``make reference`` rewrites the file from ``hfc_design.schema``. Reading it does not start JAX. A
key may contain placeholders for names: ``plant.axes.AXIS``, ``motions.N.weight``.
"""

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from hfc_design.core.numbers import Json, Plain
from hfc_design.core.quantities import without_unit
from hfc_design.core.records import UserError
from hfc_design.core.validation_errors import short
from hfc_design.core.wording import NUMBER, Keys, alternatives, near, of_its_name, one_of

FILE = Path(__file__).parent / "reference.json"
#: Kinds of things that an entry describes.
PLANT, CONTROLLER, STRATEGY, OBJECTIVE = "plant", "controller", "strategy", "objective"
REFERENCE, METRIC, FORMAT = "reference", "metric", "format"
SCENARIO, DESIGN, KEY, DESIGN_KEY = "scenario", "design", "key", "design-key"
#: Values of ``Entry.allowed``: of metrics that no scenario can name, and of stability margins.
IN_TABLES, IN_CONSTRAINTS = "in tables only", "in [constraints] only"
#: Value of ``Entry.unit`` for a number in the unit of the metric that its key names.
OF_METRIC = "of the metric"


class Entry(NamedTuple):
    """Entry of the reference: a named part, such as a plant, or one of its keys or numbers."""

    kind: str  # plant, controller, strategy, objective, reference, metric, format, ...
    name: str  # of the thing, as "c-axis"; of a "key" or "design-key" the dotted key
    part: str = ""  # "": the thing; else its parameter, signal, metric, setting, design, fact
    key: str = ""  # where it stands in a file: "plant.parameters.poles"; of a signal its name
    type: str = ""  # in words
    unit: str = ""  # "1": none; error, command, load and signal stand for those of the plant
    default: Plain = None  # None: there is none
    required: bool = False  # whether it has to be given
    absent: bool = False  # of a table: if it is left out, the defaults of its keys do not hold
    allowed: str = ""  # values in words; "": any value of the type
    meaning: str = ""
    source: str = ""  # where the equation is printed: "LL eq. 1-2"


@cache
def entries() -> tuple[Entry, ...]:
    """Return every entry, in the order of the data file."""
    return tuple(Entry(**one) for one in json.loads(FILE.read_text("utf-8")))


def written(every: Iterable[Entry]) -> str:
    """Return the text of the data file for entries: a line for each, without default values."""
    usual = Entry._field_defaults
    lines = [
        {key: x for key, x in one._asdict().items() if key not in usual or x != usual[key]}
        for one in every
    ]
    return "[\n" + ",\n".join(json.dumps(one, ensure_ascii=False) for one in lines) + "\n]\n"


def things(kind: str) -> list[Entry]:
    """Return the entries of all things of a kind, as all plants, without those of their parts."""
    return [one for one in entries() if one.kind == kind and not one.part]


def parts(kind: str, name: str, others: Iterable[Entry] = ()) -> list[Entry]:
    """Return the entries of a thing's parts; those of a user's own thing are in ``others``."""
    for every in (entries(), others):
        if listed := [one for one in every if (one.kind, one.name) == (kind, name) and one.part]:
            return listed
    return []


def unknown(
    what: str, name: str, known: Iterable[str], listed: Iterable[str] | None = None
) -> UserError:
    """Return the error for an unknown name, with similar names and the known or ``listed`` ones."""
    names = [*known]
    if listed is None:
        there = one_of(name, names)
    else:
        meant = " or ".join(near(name, names, 2))
        there = f"{meant and f'did you mean {meant}? '}{one_of('', listed)}"
    return UserError(f"{short(name)}: unknown {what}; {there}")


def in_units(unit: str, units: Mapping[str, str]) -> str:
    """Return a unit in the units of a plant: for a C-axis, command/error becomes V/rad."""

    def unit_of(match: re.Match[str]) -> str:
        text = units.get(match[0], match[0])
        alone = match[0] == unit or not re.search(r"[ /]", text)
        return text if alone else f"({text})"

    return re.sub(r"\b(error|command|load|signal)\b", unit_of, unit)


def units_of(plant: str, others: Iterable[Entry] = ()) -> dict[str, str]:
    """Return signal -> unit of a plant; if it has several axes, of the first one."""
    units: dict[str, str] = {}
    for one in parts(PLANT, plant, others):
        if one.part == "signal":
            units.setdefault(one.key.rpartition(".")[2], one.unit)
    return units


#: Keys of a scenario that name a thing -> kind of that thing.
NAMED = {
    "plant.name": PLANT,
    "reference.kind": REFERENCE,
    "fitness.kind": OBJECTIVE,
    "controller.kind": CONTROLLER,
    "search.preset": STRATEGY,
}
#: Parts that ``entry_of`` removes from keys: the axis in a table, the motion, the axis of a plant.
ALIKE = re.compile(r"^(load|limits|sensors)\.axes\.[^.]+\.(?=.)")
IN_MOTION = re.compile(r"^motions\.\d+\.(?=(reference|load|start)\.)")
OF_AXIS = re.compile(r"^plant\.axes\.[^.]+\.(?=.)")
#: Units that stay words: "of the ...", and of a signal that the plant does not have.
ANY = re.compile(r"^of the |\b(error|command|load|signal)\b")
#: Types of the reference that are numbers.
NUMBERS = "number", "whole number"
#: Placeholder in a key of the reference -> pattern of the names for which it stands.
PLACES = {"AXIS": r"[^.]+", "NAME": r"[^.]+", "N": r"\d+"}
#: Tables in which each entry has the keys of its own kind; they are not checked here.
OWN = re.compile(r"^(motions\.\d+\.)?(reference\.axes|controller\.(axes|inner|start))\.")


def chosen(data: Json) -> dict[str, str]:
    """Return kind -> name of the thing that a scenario names or has by default."""
    names = {}
    defaults = {one.key: one.default for one in things(KEY)}
    for key, kind in NAMED.items():
        table, _, last = key.partition(".")
        record = data.get(table)
        name = record.get(last) if isinstance(record, Mapping) else None
        names[kind] = str(name if name is not None else defaults[key])
    return names


def keys_of(named: Mapping[str, str], others: Sequence[Entry] = ()) -> list[Entry]:
    """Return the entries of all keys of a scenario with the things ``named`` (kind -> name).

    ``others`` are entries of a user's own parts. The tables are in the order of the reference.
    """
    keys = things(KEY)
    order = {one.key.partition(".")[0]: k for k, one in enumerate(keys)}
    for kind, name in named.items():
        wanted = "parameter" if kind == PLANT else "setting"
        keys += [one for one in parts(kind, name, others) if one.part == wanted]
    return sorted(keys, key=lambda one: order.get(one.key.partition(".")[0], 0))


def scenario_keys(data: Json, others: Sequence[Entry] = ()) -> list[Entry]:
    """Return the entries of keys that a scenario may have; those of its motions come last."""
    keys = keys_of(chosen(data), others)
    motions = data.get("motions")
    for motion in motions if isinstance(motions, list) else ():
        motion_reference = motion.get("reference") if isinstance(motion, Mapping) else None
        if isinstance(motion_reference, Mapping):
            keys += parts(REFERENCE, str(motion_reference.get("kind")))
    return keys


def entry_of(key: str, known: Sequence[Entry]) -> Entry | None:
    """Return the entry of a key, or of a list or table of names around it; None: unknown."""
    key = ALIKE.sub(r"\1.", IN_MOTION.sub("", key))
    if any(one.key.startswith("plant.parameters.") for one in known):  # axes of one drive
        key = OF_AXIS.sub("plant.parameters.", key)
    table = key
    while table:
        exact = next((one for one in known if _fits(one.key, table)), None)
        if exact is not None:
            named = exact.type.startswith(("table of", "list")) and exact.key != "plant.parameters"
            return exact if table == key or named else None
        table = table.rpartition(".")[0]
    return None


def unit_at(key: str, entry: Entry, units: Mapping[str, str]) -> str:
    """Return the unit of the value at a key with this ``entry``, in the ``units`` of a plant."""
    named = (one for one in things(METRIC) if one.allowed != IN_TABLES)
    measured = next((one.unit for one in named if one.name in key.split(".")), entry.unit)
    return in_units(measured if entry.unit == OF_METRIC else entry.unit, units)


def keys_in(data: Json, unlisted: Callable[[str], list[Entry]] = lambda plant: []) -> Keys:
    """Return the keys of the scenario in ``data``, which are looked up at the first use.

    ``unlisted`` gives the entries of a plant that is a user's own.
    """

    @cache
    def known() -> tuple[list[Entry], dict[str, str]]:
        plant = chosen(data)[PLANT]
        others = unlisted(plant)
        return scenario_keys(data, others), units_of(plant, others)

    def unit(key: str) -> str:
        every, units = known()
        entry = entry_of(key, every)
        unit_here = "" if entry is None else unit_at(key, entry, units)
        return of_its_name(key) if ANY.search(unit_here) else unit_here if unit_here != "1" else ""

    return Keys(unit, lambda: (one.key for one in known()[0]), whose)


#: A key that more things than this have is attributed to none of them.
FEW = 3


def whose(key: str) -> str:
    """Return the names of the things that have this key; "" if more than ``FEW`` have it."""
    every = (one for one in entries() if one.part in ("setting", "parameter"))
    names = {f"{one.kind} {one.name}" for one in every if _fits(one.key, key)}
    return alternatives(sorted(names)) if len(names) <= FEW else ""


def _fits(pattern: str, key: str) -> bool:
    """True if a key matches a pattern with placeholders for names."""
    if not PLACES.keys() & set(pattern.split(".")):
        return pattern == key
    expression = r"\.".join(PLACES.get(part, re.escape(part)) for part in pattern.split("."))
    return re.fullmatch(expression, key) is not None


def leaves(data: Any, prefix: str = "") -> Iterator[tuple[str, Plain]]:
    """Yield (dotted key, value) of a file, also of empty tables; motions, windows are numbered."""
    listed = prefix in ("motions", "windows")
    if isinstance(data, Mapping) and (data or not prefix):
        for key, value in data.items():
            yield from leaves(value, f"{prefix}.{key}" if prefix else str(key))
    elif listed and isinstance(data, list) and all(isinstance(one, Mapping) for one in data):
        for k, one in enumerate(data):
            yield from leaves(one, f"{prefix}.{k}")
    else:
        yield prefix, data


def _metric_fault(key: str) -> str:
    """Return what is wrong with the metric that a key of a file names; "" if nothing is."""
    bound = re.fullmatch(r"(constraints|fitness\.tolerances)\.([^.]+)(\..*)?", key)
    if bound is None or key == "constraints.band":
        return ""
    allowed = ("", IN_CONSTRAINTS) if bound[1] == "constraints" else ("",)
    known = [one.name for one in things(METRIC) if one.allowed in allowed]
    if {bound[2], f"estimated_{bound[2]}"} & {*known}:
        return ""
    meant = "".join(f"did you mean {one}? " for one in near(bound[2], known))
    return f"unknown metric; {meant}see hfc show metric"


def check_keys(data: Json, known: Sequence[Entry], source: str) -> None:
    """Check a file; UserError: unknown keys or metrics, or another value in place of a number."""
    wrong = []
    for key, value in leaves(data):
        entry = entry_of(key, known)
        if entry and entry.type in NUMBERS and type(value) not in (int, float):
            unit = keys_in(data).unit(key)
            rule = f"{NUMBER}{f' [{unit}]' if unit else ''}{without_unit(value, unit)}"
            wrong.append(f"{key} = {short(value)}: {rule}")
        if entry and entry.unit == OF_METRIC and (fault := _metric_fault(key)):
            wrong.append(f"{key}: {fault}")
        if OWN.match(key) or entry is not None:
            continue
        meant = " or ".join(near(key, (one.key for one in known), 2))
        wrong.append(f"{key}: unknown key{f'; did you mean {meant}?' if meant else ''}")
    if wrong:
        raise UserError(*wrong).within(source)
