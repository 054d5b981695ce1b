"""Values of a scenario file and values left at their defaults, with the origin of each."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from hfc_design.core.numbers import Json, Plain
from hfc_design.reference import entries as reference
from hfc_design.reference.entries import Entry

FILE, DEFAULT, SCENARIO = "the file", "default", "the scenario"
#: Key that a motion may set -> key of the scenario that holds if it does not.
OF_MOTION = {
    "duration_s": "simulation.duration_s",
    "settled_after_s": "fitness.settled_after_s",
    "reference": "reference",
    "load": "load",
    "start": "start",
}


class Value(NamedTuple):
    """A key of a scenario with its value."""

    key: str
    value: Plain
    default: Plain
    where: str  # origin of the value: FILE, DEFAULT, or in a motion SCENARIO
    unit: str = ""
    meaning: str = ""


def values(data: Json, known: Sequence[Entry], others: Sequence[Entry] = ()) -> list[Value]:
    """Return the keys that a file sets, in its order, then those that it leaves at a default.

    ``known`` are the existing keys, ``others`` the entries of a user's own parts.
    """
    named = reference.chosen(data)
    units = reference.units_of(named[reference.PLANT], others)
    listed = [_set(key, value, known, units) for key, value in reference.leaves(data)]
    keys = [one.key for one in listed]
    absent = [
        f"{one.key}."
        for one in known
        if one.absent and not any(f"{key}.".startswith(f"{one.key}.") for key in keys)
    ]
    for one in known:
        of_motion = one.kind == reference.REFERENCE and one.name != named[reference.REFERENCE]
        without = one.required or one.type == "table" or one.default in (None, {}, [])
        places = reference.PLACES.keys() & {*one.key.split(".")}
        # If several motions have one kind of reference, its keys are known several times.
        is_told = any(f"{x.key}.".startswith(f"{one.key}.") for x in listed)
        if not (of_motion or one.key.startswith(tuple(absent)) or without or places or is_told):
            unit = reference.in_units(one.unit, units)
            listed.append(Value(one.key, one.default, one.default, DEFAULT, unit, one.meaning))
    return listed


def _set(key: str, value: Plain, known: Sequence[Entry], units: Mapping[str, str]) -> Value:
    """Return a key that a file sets, with default, unit and meaning if it is known."""
    entry = reference.entry_of(key, known)
    if entry is None:
        return Value(key, value, None, FILE)
    same = entry.key.rpartition(".")[2] == key.rpartition(".")[2]
    default = entry.default if same else None
    return Value(key, value, default, FILE, reference.unit_at(key, entry, units), entry.meaning)


def motions(data: Json) -> Iterator[tuple[str, list[Value]]]:
    """Yield each motion's name, and the values that it sets or takes from the scenario."""
    listed = data.get("motions", [])
    for k, motion in enumerate(listed if isinstance(listed, list) else ()):
        if isinstance(motion, Mapping):
            pairs = ((key, motion.get(key), _at(data, above)) for key, above in OF_MOTION.items())
            rows = [
                Value(
                    key, there if here is None else here, None, SCENARIO if here is None else FILE
                )
                for key, here, there in pairs
                if here is not None or there is not None
            ]
            yield str(motion.get("name", k)), rows


def _at(data: Any, key: str) -> Plain:
    """Return the value at a dotted key; None if the key is not set."""
    for part in key.split("."):
        data = data.get(part) if isinstance(data, Mapping) else None
    return data
