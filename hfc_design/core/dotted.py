"""Keys inside tables by their dotted names, as in simulation.duration_s."""

import copy
from collections.abc import Iterable, Mapping

from hfc_design.core.numbers import Json, Plain
from hfc_design.core.records import UserError
from hfc_design.core.texts import DEEPEST, plain_fault, toml_of

#: Values by dotted key, or texts like "key.sub=value".
Changes = Iterable[str] | Mapping[str, Plain]
#: What changes a scenario, and what a design.
EXAMPLES = {"--set": "simulation.duration_s=5", "--change": "controller.integral_gain=8"}


def set_keys(changes: Iterable[str], option: str) -> Json:
    """Dotted keys and values of an option's "dotted.key=value".

    A value is TOML, or else a bare string.

    Raises:
        UserError: a change is not of that form.
    """
    found: Json = {}
    for change in changes:
        key, equals, text = change.partition("=")
        if not equals or not key.strip():
            raise UserError(
                f"{option} {change}: has to look like KEY=VALUE, as in {EXAMPLES[option]}"
            )
        try:
            told = toml_of(f"value = {text}")
        except ValueError:
            told = {}
        found[key.strip()] = told["value"] if [*told] == ["value"] else text.strip()
    return found


def changed(data: Json, changes: Changes, option: str = "--set") -> Json:
    """``data`` with the values of dotted keys; ``option`` stands in the messages.

    Raises:
        UserError: a key runs through something that is not a table, or a value is not plain.
    """
    values = changes if isinstance(changes, Mapping) else set_keys(_texts(changes, option), option)
    if fault := plain_fault(data):  # of a script; a file has been through this
        raise UserError(fault)
    data = copy.deepcopy(data)
    for key, value in values.items():
        *path, last = str(key).split(".")
        fault = f"has more than {DEEPEST} parts" if len(path) >= DEEPEST else None
        if fault := fault or plain_fault({key: value}):
            raise UserError(f"{option} {str(key)[:60]}: {fault}")
        place = data
        for part in path:
            if place.get(part) is None:  # an optional part of a design is null where there is none
                place[part] = {}
            place = place[part]
            if not isinstance(place, dict):
                raise UserError(f"{option} {key}={value}: {part} is not a table")
        place[last] = value
    return data


def _texts(changes: Iterable[str], option: str) -> list[str]:
    """Changes one by one; UserError: they are no texts."""
    each = [changes] if isinstance(changes, str) or not isinstance(changes, Iterable) else changes
    texts = [*each]
    for one in texts:
        if not isinstance(one, str):
            raise UserError(
                f"changes have to be texts as in {EXAMPLES[option]!r}, or a mapping of dotted keys "
                f"to values, not {one!r}"
            )
    return texts


def flat(table: Json, prefix: str = "") -> Json:
    """Nested tables as dotted keys; TOML reads ``run.seed = 1`` as a table in a table."""
    found: Json = {}
    for key, value in table.items():
        nested = isinstance(value, dict)
        found |= flat(value, f"{prefix}{key}.") if nested else {prefix + key: value}
    return found
