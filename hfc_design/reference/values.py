"""What a scenario file says, beside what it leaves as it is: where each value comes from."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from hfc_design.core.numbers import Json, Plain
from hfc_design.reference import entries as reference
from hfc_design.reference.entries import Entry

FILE, DEFAULT, SCENARIO = "the file", "default", "the scenario"
#: What a motion may say itself, and where it is from if it does not.
OF_MOTION = {
    "duration_s": "simulation.duration_s",
    "settled_after_s": "fitness.settled_after_s",
    "reference": "reference",
    "load": "load",
    "start": "start",
}


class Value(NamedTuple):
    """A key of a scenario with what stands there."""

    key: str
    value: Plain
    default: Plain
    where: str  # the value is from: FILE, DEFAULT, or SCENARIO in a motion
    unit: str = ""
    meaning: str = ""


def values(data: Json, known: Sequence[Entry], own: Sequence[Entry] = ()) -> list[Value]:
    """The keys that a file sets, as they stand there, then those that it leaves at a default.

    ``known`` are the keys that there are, ``own`` the entries of own parts.
    """
    named = reference.chosen(data)
    plant, followed = named[reference.PLANT], named[reference.REFERENCE]
    units = reference.units_of(plant, own)
    found = [_said(key, value, known, units) for key, value in reference.leaves(data)]
    unset = [x.key for x in known if "left out:" in x.meaning and x.type == "table"]
    unset = [key for key in unset if not any(f"{one.key}.".startswith(f"{key}.") for one in found)]
    for one in known:
        if one.kind == reference.REFERENCE and one.name != followed:
            continue  # of a motion
        if one.key.startswith(tuple(f"{key}." for key in unset)):
            continue  # nothing of it holds
        passed = one.required or one.type == "table" or one.default in (None, {}, [])
        free = {"N", "AXIS", "NAME"} & set(one.key.split("."))
        set_here = any(key == one.key or key.startswith(f"{one.key}.") for key, *_ in found)
        if not (passed or free or set_here):
            unit = reference.in_units(one.unit, units)
            found.append(Value(one.key, one.default, one.default, DEFAULT, unit, one.meaning))
    return found


def _said(key: str, value: Plain, known: Sequence[Entry], units: Mapping[str, str]) -> Value:
    entry = reference.entry_of(key, known)
    if entry is None:
        return Value(key, value, None, FILE)
    same = entry.key.rpartition(".")[2] == key.rpartition(".")[2]
    default = entry.default if same else None
    return Value(key, value, default, FILE, reference.unit_at(key, entry, units), entry.meaning)


def motions(data: Json) -> Iterator[tuple[str, list[Value]]]:
    """Name of each motion, and what holds in it: said there, or by the scenario, or nowhere."""
    listed = data.get("motions", [])
    for k, motion in enumerate(listed if isinstance(listed, list) else ()):
        if not isinstance(motion, Mapping):
            continue
        rows = []
        for key, above in OF_MOTION.items():
            here, there = motion.get(key), _at(data, above)
            where = FILE if here is not None else SCENARIO if there is not None else DEFAULT
            if here is not None or there is not None:
                rows.append(Value(key, there if here is None else here, None, where))
        yield str(motion.get("name", k)), rows


def _at(data: Any, key: str) -> Plain:
    """What stands at a dotted key; None where nothing does."""
    for part in key.split("."):
        data = data.get(part) if isinstance(data, Mapping) else None
    return data
