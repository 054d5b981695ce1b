"""Keys inside tables by their dotted names, as in simulation.duration_s."""

import copy
import tomllib
from collections.abc import Iterable, Mapping

from hfc_design.core.numbers import Json, Plain
from hfc_design.core.records import UserError

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
            found[key.strip()] = tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError:
            found[key.strip()] = text.strip()
    return found


def changed(data: Json, changes: Changes, option: str = "--set") -> Json:
    """``data`` with the values of dotted keys; ``option`` stands in the messages.

    Raises:
        UserError: a key runs through something that is not a table.
    """
    data = copy.deepcopy(data)
    values = changes if isinstance(changes, Mapping) else set_keys(changes, option)
    for key, value in values.items():
        *path, last = key.split(".")
        place = data
        for part in path:
            if place.get(part) is None:  # an optional part of a design is null where there is none
                place[part] = {}
            place = place[part]
            if not isinstance(place, dict):
                raise UserError(f"{option} {key}={value}: {part} is not a table")
        place[last] = value
    return data


def flat(table: Json, prefix: str = "") -> Json:
    """Nested tables as dotted keys; TOML reads ``run.seed = 1`` as a table in a table."""
    found: Json = {}
    for key, value in table.items():
        nested = isinstance(value, dict)
        found |= flat(value, f"{prefix}{key}.") if nested else {prefix + key: value}
    return found
