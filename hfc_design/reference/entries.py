"""The entries of the reference, from the data file that comes with the package.

``make reference`` writes the file anew, from ``hfc_design.gather``. Reading it starts no JAX.
"""

import json
import re
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

from hfc_design.core.faults import short
from hfc_design.core.numbers import Plain
from hfc_design.core.records import UserError
from hfc_design.core.wording import near, one_of

FILE = Path(__file__).parent / "reference.json"
#: What an entry may be about.
PLANT, CONTROLLER, STRATEGY, OBJECTIVE = "plant", "controller", "strategy", "objective"
REFERENCE, METRIC, FORMAT = "reference", "metric", "format"
SCENARIO, DESIGN, KEY, DESIGN_KEY = "scenario", "design", "key", "design-key"


class Entry(NamedTuple):
    """One thing that a user can name, or one key or number of it."""

    kind: str  # plant, controller, strategy, objective, reference, metric, format, ...
    name: str  # of the thing: "c-axis"; of a key of every scenario or design its dotted key
    part: str = ""  # "": the thing itself; parameter, signal, metric, setting, design, fact: of it
    key: str = ""  # where it stands in a file: "plant.parameters.poles"; of a signal its name
    type: str = ""  # in words
    unit: str = ""  # "1": none; error, command, load and signal stand for those of the plant
    default: Plain = None  # None: there is none
    required: bool = False  # whether it has to be given
    allowed: str = ""  # in words; "": whatever has its type
    meaning: str = ""
    source: str = ""  # where the equation is printed: "LL eq. 1-2"


@cache
def entries() -> tuple[Entry, ...]:
    """Every entry, in the order in which people read them."""
    return tuple(Entry(**one) for one in json.loads(FILE.read_text("utf-8")))


def written(every: Iterable[Entry]) -> str:
    """The data file of these entries: a line each, what is as usual left out."""
    usual = Entry._field_defaults
    lines = [
        {key: x for key, x in one._asdict().items() if key not in usual or x != usual[key]}
        for one in every
    ]
    return "[\n" + ",\n".join(json.dumps(one, ensure_ascii=False) for one in lines) + "\n]\n"


def things(kind: str, known: Iterable[Entry] | None = None) -> list[Entry]:
    """The things of a kind themselves, without their parts."""
    every = entries() if known is None else known
    return [one for one in every if one.kind == kind and not one.part]


def parts(kind: str, name: str, known: Iterable[Entry] | None = None) -> list[Entry]:
    """The parts of a thing."""
    every = entries() if known is None else known
    return [one for one in every if (one.kind, one.name) == (kind, name) and one.part]


def unknown(
    what: str, name: str, known: Iterable[str], listed: Iterable[str] | None = None
) -> UserError:
    """The line for a name that there is not: what is near it, and what there is or is listed."""
    names = [*known]
    if listed is None:
        told = one_of(name, names)
    else:
        meant = " or ".join(near(name, names, 2))
        told = f"{meant and f'did you mean {meant}? '}{one_of('', listed)}"
    return UserError(f"{short(name)}: no such {what}; {told}")


def in_units(unit: str, units: Mapping[str, str]) -> str:
    """A unit of the reference with those of a plant: command/error of a C-axis is V/rad."""

    def own(found: re.Match[str]) -> str:
        told = units.get(found[0], found[0])
        alone = found[0] == unit or not re.search(r"[ /]", told)
        return told if alone else f"({told})"

    return re.sub(r"\b(error|command|load|signal)\b", own, unit)


def units_of(plant: str, known: Iterable[Entry] | None = None) -> dict[str, str]:
    """Unit of each signal of a plant; of one with several axes those of its first one."""
    found: dict[str, str] = {}
    for one in parts(PLANT, plant, known):
        if one.part == "signal":
            found.setdefault(one.key.rpartition(".")[2], one.unit)
    return found
