"""Changes of tables by dotted keys, as simulation.duration_s; numbers in keys are list indices."""

import copy
from collections.abc import Iterable, Mapping
from os.path import abspath, isfile

from hfc_design.core.numbers import Json, Plain
from hfc_design.core.records import NOTHING, UserError, option
from hfc_design.core.texts import DEEPEST, plain_fault, toml_of

#: Values by dotted key, or texts like "key.sub=value".
Changes = Iterable[str] | Mapping[str, Plain]
#: Keys that name a file.
FILES = ("file", "start")
#: Option for changes (of a scenario, a design, a network) or other named values -> example.
EXAMPLES = {"set": "simulation.duration_s=5", "change": "controller.integral_gain=8"}
EXAMPLES |= {"gains": "kp=900", "motor": "lead=5", "nearest": "chatter=2"}
EXAMPLES |= {"network": "momentum=0.9", "limit": "G=0.02", "tolerance": "backlash=0.5"}


def set_keys(changes: Iterable[str], by: str) -> Json:
    """Return dotted key -> value from the texts "dotted.key=value" of the option ``by``.

    A value is read as TOML; what is not TOML is a string.

    Raises:
        UserError: a change does not have that form.
    """
    settings: Json = {}
    for change in _texts(changes, by):
        key, equals, text = change.partition("=")
        if not equals or not key.strip():
            raise UserError(f"{_given(by, change)}: must be KEY=VALUE, as in {EXAMPLES[by]}")
        try:
            parsed = toml_of(f"value = {text}")
        except ValueError:
            parsed = {}
        value = parsed["value"] if [*parsed] == ["value"] else text.strip()
        settings[key.strip()] = _from_here(key.strip(), value) if by == "set" else value
    return settings


def _given(by: str, key: str, value: Plain = NOTHING) -> str:
    """Return the text for a message that names a change by the option ``by``."""
    return option(by, value, "changes" if by in ("set", "change") else by, key)


def _from_here(key: str, value: Plain) -> Plain:
    """Return ``value`` with absolute paths of files that the current folder contains."""
    if isinstance(value, dict):
        return {name: _from_here(name, x) for name, x in value.items()}
    named = key.rpartition(".")[2] in FILES and isinstance(value, str) and isfile(value)
    return abspath(value) if named else value


def overridden(data: Json, changes: Changes, by: str = "set") -> Json:
    """Return a copy of ``data`` with the ``changes``; messages name the option ``by``.

    In a list, a part of a key is the number of an entry, counted from 0.

    Raises:
        UserError: a key leads through a value that is neither table nor list, or names an entry
            that a list does not have; or a value is none that a file can hold.
    """
    values = changes if isinstance(changes, Mapping) else set_keys(changes, by)
    if fault := plain_fault(data):  # from a script; data of a file have passed this check
        raise UserError(fault)
    data = copy.deepcopy(data)
    for key, value in values.items():
        *path, last = str(key).split(".")
        fault = f"has more than {DEEPEST} parts" if len(path) >= DEEPEST else None
        if fault := fault or plain_fault({key: value}):
            raise UserError(f"{_given(by, str(key)[:60])}: {fault}")
        place: Plain = data
        given = _given(by, str(key), value)
        for part in path:
            place = _inner(place, part, given)
        place[_entry(place, last, given) if isinstance(place, list) else last] = value
    return data


def _texts(changes: Iterable[str], by: str) -> list[str]:
    """Return the changes as a list of texts; UserError: one of them is not a text."""
    each = [changes] if isinstance(changes, str) or not isinstance(changes, Iterable) else changes
    texts = [*each]
    for one in texts:
        if not isinstance(one, str):
            raise UserError(
                f"changes must be strings as in {EXAMPLES[by]!r}, or a mapping of "
                f"dotted keys to values (got {one!r})"
            )
    return texts


def _inner(place: Plain, part: str, given: str) -> Plain:
    """Return the table or list that a part of a key names in ``place``, or a new table there."""
    key: Plain = _entry(place, part, given) if isinstance(place, list) else part
    container: Plain = place[key] if isinstance(place, list) else place.get(key)
    if container is None:  # an optional part of a design is null where there is none
        container = {}
    elif isinstance(container, tuple):  # from a script
        container = list(container)
    if not isinstance(container, dict | list):
        raise UserError(f"{given}: {part} is not a table")
    place[key] = container
    return container


def _entry(place: list[Plain], part: str, given: str) -> int:
    """Return the list index that a part of a key is; UserError: the list has no such entry."""
    if not (part.isascii() and part.isdigit() and int(part) < len(place)):
        entries = f"the entries 0 to {len(place) - 1}" if place else "no entries"
        raise UserError(f"{given}: no entry {part!r}; the list has {entries}")
    return int(part)


def lists(value: Plain) -> Plain:
    """Return the value with lists in place of tuples, as a file holds it."""
    if isinstance(value, dict):
        return {key: lists(inside) for key, inside in value.items()}
    return [*map(lists, value)] if isinstance(value, list | tuple) else value


def flat(table: Json, prefix: str = "") -> Json:
    """Return dotted key -> value of nested tables; TOML reads ``run.seed = 1`` as nested tables.

    An empty table inside another is a value: ``controller.linear = {}`` requests a linear part. An
    empty section, such as one whose lines are all comments, gives no key.
    """
    flattened: Json = {}
    for key, value in table.items():
        nested = isinstance(value, dict) and (value or not prefix)
        flattened |= flat(value, f"{prefix}{key}.") if nested else {prefix + key: value}
    return flattened
