"""Keys of a scenario as lines of TOML with their meanings; keys that are not set are commented out.

``# text`` is a remark for readers; ``#key = value`` becomes a key if its # is removed.
"""

import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence

import tomli_w

from hfc_design.core.numbers import Json, Plain
from hfc_design.reference.entries import Entry, entry_of, in_units, leaves

WIDTH = 98
#: Tables that may be empty: their heads are not commented out, even without a key.
HARMLESS = (
    *("plant", "plant.parameters", "simulation", "reference", "load", "limits", "sensors"),
    *("fitness", "controller", "search", "run"),
)
#: Lists whose entries are tables of their own in a file.
LISTED = "motions", "windows"
NOT_SET = "# Keys that are not set, with their defaults; to set one, move it into its table."
#: Lines of ``tomli_w`` that begin a table, and lines with a key and a value.
HEAD, KEY = re.compile(r"\[\[?([\w.-]+)\]\]?"), re.compile(r"([\w-]+) = ")
#: Placeholder of a value that has no default.
STANDS_FOR = {"number": "NUMBER", "whole number": "NUMBER", "text": '"TEXT"', "file": '"FILE"'}


def commented(live: Mapping[str, Plain], known: Sequence[Entry], units: Mapping[str, str]) -> str:
    """Return a scenario with the ``live`` values of dotted keys; other keys are commented out."""
    return _text(live, known, [one for one in known if _is_line(one, known, live)], units, HARMLESS)


def rest(data: Json, known: Sequence[Entry], units: Mapping[str, str]) -> str:
    """Return lines to append to a scenario: keys that it does not set, all commented out."""
    said = [key for key, _ in leaves(data)]
    listed = tuple(f"{key}.N." for key in ("motions", "windows") if data.get(key))
    left = [
        one
        for one in known
        if _is_line(one, known, {})
        and not one.key.startswith(listed)
        and not any(f"{key}.".startswith(f"{one.key}.") for key in said)
    ]
    return f"\n{NOT_SET}\n\n" + _text({}, known, left, units, ())


def explained(text: str, known: Sequence[Entry], units: Mapping[str, str]) -> str:
    """Return ``text`` of ``tomli_w`` with each meaning once, before its table or key."""
    lines, written_before, table = [], {""}, ""
    counts: dict[str, int] = {}
    for line in text.splitlines():
        if head := HEAD.fullmatch(line):
            table = head[1]
            if line.startswith("[["):
                counts[table] = counts.get(table, -1) + 1
        match = KEY.match(line)
        key = table if head else f"{table}.{match[1]}".strip(".") if match else ""
        first, _, below = key.partition(".")
        if first in counts:  # a list of tables: known keys have a number inside
            key = f"{first}.{counts[first]}.{below}".strip(".")
        one = entry_of(key, known) if key else None
        meaning = _line_of(one, units) if one else ""
        lines.append(("" if meaning in written_before else meaning) + line)
        written_before.add(meaning)
    return "\n".join(lines) + "\n"


def _text(
    live: Mapping[str, Plain],
    known: Sequence[Entry],
    rows: Sequence[Entry],
    units: Mapping[str, str],
    heads: Sequence[str],
) -> str:
    """Return lines for ``rows``: first the keys without a table, then table by table.

    The head of a table is commented out if no key in it is live and ``heads`` does not name it.
    """
    known_as = {one.key: one for one in known}
    tables: dict[str, list[Entry]] = {"": []}
    for row in rows:
        # A table with arbitrary names has no other rows: its own row belongs under its head.
        table = row.key if row.type.startswith("table of") else row.key.rpartition(".")[0]
        tables.setdefault(table, []).append(row)
    text = "".join(_line(one, False, live, units) for one in tables.pop(""))
    for table, entries in tables.items():
        alive = table in (*heads, *live) or any(one.key in live for one in entries)
        name = table.replace(".N", "")
        head = f"[[{name}]]" if table.endswith(".N") else f"[{name}]"
        meaning = _line_of(known_as[name], units) if name in known_as else ""
        text += f"\n{meaning}{head if alive else f'#{head}'}\n"
        for one in entries:
            text += _line(one, one.key == table, live, units)
    return text.lstrip("\n")


def _is_line(one: Entry, known: Iterable[Entry], live: Mapping[str, Plain]) -> bool:
    """True if an entry is a key with a value, not a table whose keys have lines themselves."""
    parts = one.key.split(".")
    if {"AXIS", "NAME"} & {*parts} or ("N" in parts and parts[0] not in LISTED):
        return False
    if one.type.startswith("list of tables"):
        return one.key not in LISTED
    below = (x.key.removeprefix(f"{one.key}.") for x in known if x.key.startswith(f"{one.key}."))
    inside = any(not {"AXIS", "NAME"} & {*key.split(".")} for key in below)
    return not (one.type.startswith("table") and inside) or (
        one.key in live and live[one.key] != {}
    )


def _line(one: Entry, head: bool, live: Mapping[str, Plain], units: Mapping[str, str]) -> str:
    """Return a key as a line after its meaning; it is commented out if it is not live.

    If ``head``, the entry is a table with arbitrary names: only its live values are returned.
    """
    if head:
        inside = live.get(one.key) or {}
        return "".join(f"{key} = {written(x)}\n" for key, x in inside.items())
    name = one.key.rpartition(".")[2]
    if one.key in live:
        return f"{_line_of(one, units)}{name} = {written(live[one.key])}\n"
    value = STANDS_FOR.get(one.type, "...") if one.default is None else written(one.default)
    return f"{_line_of(one, units)}#{name} = {value if len(value) < WIDTH else '...'}\n"


def _line_of(one: Entry, units: Mapping[str, str]) -> str:
    unit = in_units(one.unit, units)
    text = one.meaning + (f" [{unit}]" if unit not in ("", "1") else "")
    if one.allowed and one.allowed not in text:
        text += f"; {one.allowed}"
    lines = textwrap.wrap(text, WIDTH, break_on_hyphens=False, break_long_words=False)
    return "".join(f"# {line}\n" for line in lines)


def written(value: Plain) -> str:
    """Return a value in TOML, on one line."""
    if isinstance(value, Mapping):
        inside = ", ".join(f"{key} = {written(one)}" for key, one in value.items())
        return f"{{ {inside} }}" if inside else "{}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(written, value))}]"
    return tomli_w.dumps({"x": value}).removeprefix("x = ").rstrip("\n")
