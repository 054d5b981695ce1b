"""Tables of ``hfc show``, which fit 60 columns and more."""

import re
from collections.abc import Iterable, Sequence
from itertools import groupby

from rich.table import Table

from hfc_design.core.console import plain_table, terminal
from hfc_design.core.numbers import Json, Plain
from hfc_design.core.overrides import flat
from hfc_design.reference.entries import Entry
from hfc_design.reference.values import FILE, Value

#: Part of a thing -> title of its table, in the order of the tables.
TITLES = {
    "fact": "",
    "parameter": "parameters",
    "setting": "keys in a scenario",
    "design": "keys in a design file",
    "signal": "signals that a controller can read, command and load",
    "metric": "metrics of a motion",
}
#: Parts that a user reads and never sets.
READ = "signal", "metric"
OF_PLANT = "error", "command", "load", "signal"
WORDS = "error, command, load and signal in a unit: those of the plant, see hfc show plant NAME"
#: Largest number of letters of a value in a table.
LONGEST = 24
#: Letters of a key in a line; a longer key is continued in the next line, after a dot.
KEY = 34


def say(text: str = "") -> None:
    """Print a line on stdout."""
    terminal().print(text, highlight=False)


def show_columns(title: str, names: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print a table whose last column takes the remaining width."""
    table = plain_table(title=title or None)
    for name in names:
        last = name == names[-1]
        table.add_column(
            name,
            overflow="fold",
            ratio=2 if last else None,
            no_wrap=name == "key",
            max_width=None if last else KEY,
        )
    table.padding = (0, 1, 0, 0)
    for row in rows:
        table.add_row(*row)
    terminal().print(table)


def show_list(kind: str, entries: Sequence[Entry]) -> None:
    """Print all things of a kind, a line each; keys as a table."""
    if kind == "key":
        _show_entries("", entries, "")
        return
    table = Table(box=None, show_header=False, padding=(0, 1, 0, 0))
    table.add_column(no_wrap=True)
    table.add_column()
    for one in entries:
        table.add_row(one.name, _with_unit(one))
    terminal().print(table)


def _with_unit(one: Entry) -> str:
    text = f"{one.meaning} [{one.unit}]" if one.unit else one.meaning
    return f"{text}; {one.allowed}" if one.allowed else text


def show_owners(entries: Iterable[Entry]) -> None:
    """Print the things that have more keys, and the commands that show these."""
    owners: dict[str, list[str]] = {}
    for kind, name in dict.fromkeys((one.kind, one.name) for one in entries):
        owners.setdefault(kind, []).append(name)
    for kind, names in owners.items():
        keys = f"Each {kind} has its own keys here, as in hfc show {kind} {names[0]}"
        say(f"\n{keys}: {', '.join(names)}")


def show_thing(every: Sequence[Entry]) -> None:
    """Print a thing and its parts."""
    head, *rest = every
    say(f"{head.kind} {head.name}: {_with_unit(head)}")
    if head.source:
        say(f"source: {head.source}")
    rest.sort(key=lambda one: [*TITLES].index(one.part))
    for part, entries in groupby(rest, key=lambda one: one.part):
        if part == "fact":
            for one in entries:
                say(f"{one.key}: {one.meaning}")
            continue
        for table, rows in groupby(entries, key=_table_of):
            say()
            title = f"{TITLES[part]}, [{table}]" if table else TITLES[part]
            _show_entries(title, list(rows), f"{table}." if table else "")


def _table_of(one: Entry) -> str:
    """The table of a file that contains a key; all settings of a thing are in one table."""
    if one.part not in ("parameter", "setting", "design"):
        return ""
    return one.key.rpartition(".")[0] if one.part == "parameter" else one.key.partition(".")[0]


def _show_entries(title: str, entries: Sequence[Entry], prefix: str) -> None:
    read = all(one.part in READ for one in entries)
    names = ("name", "unit", "meaning") if read else ("key", "default", "meaning")
    rows = []
    for one in entries:
        default = text_of(one.default, one.unit) if one.default is not None else _without(one)
        of = f" ({one.name})" if one.kind not in ("key", "design-key") and not title else ""
        meaning = [one.meaning, one.allowed if one.allowed not in one.meaning else ""]
        meant = "; ".join(filter(None, meaning)) + of
        rows.append((dotted(one.key.removeprefix(prefix)), default, meant))
    show_columns(title, names, rows)
    if any(word in one.unit for one in entries for word in OF_PLANT):
        say(WORDS)


def dotted(key: str) -> str:
    """A key in lines of at most ``KEY`` letters, broken after dots so that no word is cut."""
    lines = [""]
    for word in re.findall(r"[^.]+\.?|\.", key):
        if lines[-1].strip() and len(lines[-1] + word) > KEY:
            lines.append("  ")
        lines[-1] += word
    return "\n".join(lines)


def _without(one: Entry) -> str:
    """Text in place of a missing default."""
    if one.part in READ:
        return one.unit
    unit = f"[{one.unit}]" if one.unit and one.unit != "1" else ""
    return " ".join(filter(None, ("required" if one.required else "", unit)))


def text_of(value: Plain, unit: str = "") -> str:
    """A value with its unit, shortened."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | dict) and not value:
        return "none"
    if isinstance(value, list | tuple | dict) and len(str(value)) > LONGEST:
        return f"{len(value)} entries"
    text = f"{value:g}" if isinstance(value, float) else str(value)
    counted = unit not in ("", "1") and not isinstance(value, str)
    return f"{text} {unit}" if counted and not unit.startswith("of the ") else text


def show_scenario(
    name: str, data: Json, entries: Sequence[Value], motions: Sequence[tuple[str, list[Value]]]
) -> None:
    """Print the values of a scenario, its defaults, and the values in each of its motions."""
    say(f"scenario {name}: {data.get('description', '')}".rstrip(": "))
    here = [x for x in entries if x.where == FILE and not x.key.startswith("motions")]
    say()
    show_columns(
        "set in the file",
        ("key", "value", "default"),
        [
            (
                dotted(x.key),
                "all defaults" if x.value == {} else text_of(x.value, x.unit),
                "" if x.default is None else text_of(x.default, x.unit),
            )
            for x in here
            if x.key != "description"
        ],
    )
    if motions:
        say()
        rows = [
            ("" if k else motion, dotted(x.key), _brief(x.value), x.where)
            for motion, values in motions
            for k, x in enumerate(values)
        ]
        show_columns("motions", ("motion", "key", "value", "from"), rows)
    say()
    left = [x for x in entries if x.where != FILE]
    rest = [(dotted(x.key), text_of(x.value, x.unit), x.meaning) for x in left]
    show_columns("left at the default", ("key", "value", "meaning"), rest)


def _brief(value: Plain) -> str:
    """A table of a motion as its kind and its numbers."""
    if not isinstance(value, dict):
        return text_of(value)
    rest = ", ".join(f"{key} {text_of(x)}" for key, x in value.items() if key != "kind")
    return f"{value.get('kind', '')} {rest}".strip()


def show_design(record: Json) -> None:
    """Print the ``facts`` of a design."""
    axes = f", axes {', '.join(record['axes'])}" if record["axes"] else ""
    say(f"design {record['name']}: {record['kind']}, {record['summary']}")
    say(f"for the plant {record['plant']}{axes}, every {record['sample_time_s']:g} s")
    limits = ", ".join(f"{key} {text_of(x)}" for key, x in flat(record["limits"]).items() if x)
    score = ", ".join(f"{key} {text_of(x)}" for key, x in record["score"].items())
    for what, text in (("source", record["source"]), ("limits", limits), ("score", score)):
        if text:
            say(f"{what}: {text}")
    signals = [(one["name"], one["unit"], one["meaning"]) for one in record["signals"]]
    tree = [(f"unit-{x['id']}", x["column_input"], x["row_input"]) for x in record["units"]]
    keys = [(x["key"], text_of(x["value"], x["unit"]), x["meaning"]) for x in record["keys"]]
    for title, names, rows in (
        ("signals that it reads", ("signal", "unit", "meaning"), signals),
        ("fuzzy units, the root last", ("unit", "columns", "rows"), tree),
        ("controller", ("key", "value", "meaning"), keys),
    ):
        if rows:
            say()
            show_columns(title, names, rows)
