"""The tables of ``hfc show``, which fit 60 columns and more."""

import re
from collections.abc import Iterable, Sequence
from itertools import groupby

from rich.table import Table

from hfc_design.core.console import plain_table, terminal
from hfc_design.core.numbers import Json, Plain
from hfc_design.reference.entries import Entry
from hfc_design.reference.told import FILE, Value

#: Part of a thing -> what stands above its table.
TITLES = {
    "parameter": "parameters",
    "setting": "keys in a scenario",
    "design": "keys in a design file",
    "signal": "signals that a controller can read, command and load",
    "metric": "metrics of a motion",
    "fact": "",
}
#: Parts that a user reads and never sets.
READ = "signal", "metric"
WORDS = "error, command, load and signal in a unit: those of the plant, see hfc show plant NAME"
#: Letters of a value in a table.
LONGEST = 24
#: Letters of a key in a line; one that is longer goes on in the next, behind a dot.
KEY = 34


def show_list(kind: str, found: Sequence[Entry]) -> None:
    """All of a kind, a line each; of keys a table."""
    if kind == "key":
        _table("", found, "")
        return
    table = Table(box=None, show_header=False, padding=(0, 1, 0, 0))
    table.add_column(no_wrap=True)
    table.add_column()
    for one in found:
        unit = f" [{one.unit}]" if one.unit else ""
        table.add_row(one.name, one.meaning + unit)
    terminal().print(table)


def show_owners(found: Iterable[Entry]) -> None:
    """Of which things there are more keys, and how they are shown."""
    owners: dict[str, list[str]] = {}
    for kind, name in dict.fromkeys((one.kind, one.name) for one in found):
        owners.setdefault(kind, []).append(name)
    for kind, names in owners.items():
        own = f"Each {kind} has keys of its own here, as in hfc show {kind} {names[0]}"
        terminal().print(f"\n{own}: {', '.join(names)}", highlight=False)


def show_thing(every: Sequence[Entry]) -> None:
    """A thing and its parts."""
    head, *rest = every
    out = terminal()
    unit = f" [{head.unit}]" if head.unit else ""
    out.print(f"{head.kind} {head.name}: {head.meaning}{unit}", highlight=False)
    if head.source:
        out.print(f"source: {head.source}", highlight=False)
    order = ["fact", *(name for name in TITLES if name != "fact")]
    rest.sort(key=lambda one: order.index(one.part))
    for part, own in groupby(rest, key=lambda one: one.part):
        if part == "fact":
            for one in own:
                out.print(f"{one.key}: {one.meaning}", highlight=False)
            continue
        for table, rows in groupby(own, key=_table_of):
            out.print()
            title = f"{TITLES[part]}, [{table}]" if table else TITLES[part]
            _table(title, list(rows), f"{table}." if table else "")


def _table_of(one: Entry) -> str:
    """The table of a file in which a key stands: the whole of a thing's settings in one."""
    if one.part not in ("parameter", "setting", "design"):
        return ""
    return one.key.rpartition(".")[0] if one.part == "parameter" else one.key.partition(".")[0]


def _table(title: str, found: Sequence[Entry], prefix: str) -> None:
    read = all(one.part in READ for one in found)
    table = columns(title, "name" if read else "key", "unit" if read else "default", "meaning")
    for one in found:
        default = told(one.default, one.unit) if one.default is not None else _without(one)
        of = f" ({one.name})" if one.kind not in ("key", "design-key") and not title else ""
        meaning = [one.meaning, one.allowed if one.allowed not in one.meaning else ""]
        meant = "; ".join(filter(None, meaning)) + of
        table.add_row(dotted(one.key.removeprefix(prefix)), default, meant)
    terminal().print(table)
    if any(word in one.unit for one in found for word in ("error", "command", "load", "signal")):
        terminal().print(WORDS, highlight=False)


def columns(title: str, *names: str) -> Table:
    """A table whose last column takes what is left."""
    table = plain_table(title=title or None)
    for name in names:
        last = name == names[-1]
        table.add_column(name, overflow="fold", ratio=2 if last else None, no_wrap=name == "key")
    for column in table.columns[:-1]:
        column.max_width = KEY
    table.padding = (0, 1, 0, 0)
    return table


def dotted(key: str) -> str:
    """A key in lines of at most ``KEY`` letters, that break behind dots: no word is cut."""
    lines = [""]
    for word in re.findall(r"[^.]+\.?|\.", key):
        if lines[-1].strip() and len(lines[-1] + word) > KEY:
            lines.append("  ")
        lines[-1] += word
    return "\n".join(lines)


def _without(one: Entry) -> str:
    """What stands for a default where there is none."""
    if one.part in READ:
        return one.unit
    unit = f"[{one.unit}]" if one.unit and one.unit != "1" else ""
    return " ".join(filter(None, ("required" if one.required else "", unit)))


def told(value: Plain, unit: str = "") -> str:
    """A value with its unit, not long."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple | dict) and len(str(value)) > LONGEST:
        return f"{len(value)} entries"
    if isinstance(value, str) or unit.startswith("of the "):
        unit = ""
    text = f"{value:g}" if isinstance(value, float) else str(value)
    if isinstance(value, dict | list) and not value:
        text = "none"
        unit = ""
    return f"{text} {unit}" if unit and unit != "1" else text


def show_scenario(
    name: str, data: Json, found: Sequence[Value], motions: Sequence[tuple[str, list[Value]]]
) -> None:
    """What a scenario says, what it leaves, and what holds in each of its motions."""
    out = terminal()
    out.print(f"scenario {name}: {data.get('description', '')}".rstrip(": "), highlight=False)
    out.print()
    here = columns("set in the file", "key", "value", "default")
    for one in found:
        if one.where == FILE and not one.key.startswith("motions") and one.key != "description":
            default = "" if one.default is None else told(one.default, one.unit)
            here.add_row(dotted(one.key), told(one.value, one.unit), default)
    out.print(here)
    if motions:
        out.print()
        table = columns("motions", "motion", "key", "value", "from")
        for motion, rows in motions:
            for k, one in enumerate(rows):
                table.add_row("" if k else motion, dotted(one.key), _brief(one.value), one.where)
        out.print(table)
    out.print()
    rest = columns("left at its default", "key", "value", "meaning")
    for one in found:
        if one.where != FILE:
            rest.add_row(dotted(one.key), told(one.value, one.unit), one.meaning)
    out.print(rest)


def _brief(value: Plain) -> str:
    """A table of a motion by its kind and its numbers."""
    if not isinstance(value, dict):
        return told(value)
    kind = value.get("kind", "")
    rest = ", ".join(f"{key} {told(x)}" for key, x in value.items() if key != "kind")
    return f"{kind} {rest}".strip()
