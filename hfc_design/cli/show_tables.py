"""Tables of ``hfc show`` and ``hfc list``, for terminals of 60 columns or more."""

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby

from hfc_design.core.numbers import Json, Plain
from hfc_design.core.overrides import flat
from hfc_design.core.tables import Table, text
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
#: Parts whose values a user reads and cannot set.
READ = "signal", "metric"
OF_PLANT = "error", "command", "load", "signal"
WORDS = "error, command, load and signal in a unit: those of the plant, see hfc show plant NAME"
#: Most characters of a list or table of a file that is shown as a value.
LONGEST = 24
#: Most characters of a key in one line; a longer key continues in the next line, after a dot.
KEY = 34


def listed(kind: str, entries: Sequence[Entry]) -> Table:
    """Return the table of all things of a kind, with a row for each."""
    if kind == "key":
        return _entries("", entries, "")
    return Table("", ("", ""), [[one.name, _with_unit(one)] for one in entries])


def _with_unit(one: Entry) -> str:
    text = f"{one.meaning} [{one.unit}]" if one.unit else one.meaning
    return f"{text}; {one.allowed}" if one.allowed else text


def owners(entries: Iterable[Entry]) -> list[str]:
    """Return lines that name the things with keys of their own, and commands that show the keys."""
    named: dict[str, list[str]] = {}
    for kind, name in dict.fromkeys((one.kind, one.name) for one in entries):
        named.setdefault(kind, []).append(name)
    head = "Each {0} has its own keys here, as in hfc show {0} {1}: {2}"
    return [head.format(kind, names[0], ", ".join(names)) for kind, names in named.items()]


def thing(every: Sequence[Entry]) -> Iterator[Table]:
    """Yield the tables of a thing and its parts; ``every``: its entry, then those of its parts."""
    head, *rest = every
    source = [f"source: {head.source}"] if head.source else []
    facts = [f"{one.key}: {one.meaning}" for one in rest if one.part == "fact"]
    yield text(f"{head.kind} {head.name}: {_with_unit(head)}", *source, *facts)
    rest.sort(key=lambda one: [*TITLES].index(one.part))
    for part, entries in groupby(rest, key=lambda one: one.part):
        for table, rows in groupby(entries, key=_table_of) if part != "fact" else ():
            title = f"{TITLES[part]}, [{table}]" if table else TITLES[part]
            yield _entries(title, list(rows), f"{table}." if table else "")


def _table_of(one: Entry) -> str:
    """Return the table of a file that contains a key; all settings of a thing are in one table."""
    if one.part not in ("parameter", "setting", "design"):
        return ""
    return one.key.rpartition(".")[0] if one.part == "parameter" else one.key.partition(".")[0]


def _entries(title: str, entries: Sequence[Entry], prefix: str) -> Table:
    read = all(one.part in READ for one in entries)
    names = ("name", "unit", "meaning") if read else ("key", "default", "meaning")
    rows = []
    for one in entries:
        default = text_of(one.default, one.unit) if one.default is not None else _without(one)
        of = f" ({one.name})" if one.kind not in ("key", "design-key") and not title else ""
        meaning = [one.meaning, one.allowed if one.allowed not in one.meaning else ""]
        meant = "; ".join(filter(None, meaning)) + of
        rows.append((dotted(one.key.removeprefix(prefix)), default, meant))
    of_plant = any(word in one.unit for one in entries for word in OF_PLANT)
    return Table("", names, rows, title=title, lines=[WORDS] * of_plant)


def dotted(key: str) -> str:
    """Return a key in lines of at most ``KEY`` characters, broken only after dots."""
    lines = [""]
    for word in re.findall(r"[^.]+\.?|\.", key):
        if lines[-1].strip() and len(lines[-1] + word) > KEY:
            lines.append("  ")
        lines[-1] += word
    return "\n".join(lines)


def _without(one: Entry) -> str:
    """Return the text that stands in place of a missing default."""
    if one.part in READ:
        return one.unit
    unit = f"[{one.unit}]" if one.unit and one.unit != "1" else ""
    return " ".join(filter(None, ("required" if one.required else "", unit)))


def text_of(value: Plain, unit: str = "") -> str:
    """Return the text of a value with its unit, shortened."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | dict) and not value:
        return "none"
    if isinstance(value, list | tuple | dict) and len(str(value)) > LONGEST:
        return f"{len(value)} entries"
    text = f"{value:g}" if isinstance(value, float) else str(value)
    counted = unit not in ("", "1") and not isinstance(value, str)
    return f"{text} {unit}" if counted and not unit.startswith("of the ") else text


def scenario(
    name: str, data: Json, entries: Sequence[Value], motions: Sequence[tuple[str, list[Value]]]
) -> Iterator[Table]:
    """Yield the tables of a scenario: values in the file, values of each motion, defaults."""
    yield text(f"scenario {name}: {data.get('description', '')}".rstrip(": "))
    set_here = [
        (
            dotted(x.key),
            "all defaults" if x.value == {} else text_of(x.value, x.unit),
            "" if x.default is None else text_of(x.default, x.unit),
        )
        for x in entries
        if x.where == FILE and not x.key.startswith("motions") and x.key != "description"
    ]
    yield Table("", ("key", "value", "default"), set_here, title="set in the file")
    each = [
        ("" if k else motion, dotted(x.key), _brief(x.value), x.where)
        for motion, values in motions
        for k, x in enumerate(values)
    ]
    if each:
        yield Table("", ("motion", "key", "value", "from"), each, title="motions")
    left = [x for x in entries if x.where != FILE]
    rest = [(dotted(x.key), text_of(x.value, x.unit), x.meaning) for x in left]
    yield Table("", ("key", "value", "meaning"), rest, title="left at the default")


def _brief(value: Plain) -> str:
    """Return the text of a value of a motion; for a table its kind and its other values."""
    if not isinstance(value, dict):
        return text_of(value)
    rest = ", ".join(f"{key} {text_of(x)}" for key, x in value.items() if key != "kind")
    return f"{value.get('kind', '')} {rest}".strip()


def design(record: Json) -> Iterator[Table]:
    """Yield the tables of a design; ``record``: its ``show_design.facts``."""
    axes = f", axes {', '.join(record['axes'])}" if record["axes"] else ""
    limits = ", ".join(f"{key} {text_of(x)}" for key, x in flat(record["limits"]).items() if x)
    score = ", ".join(f"{key} {text_of(x)}" for key, x in record["score"].items())
    about = {"source": record["source"], "limits": limits, "score": score}
    yield text(
        f"design {record['name']}: {record['kind']}, {record['summary']}",
        f"for the plant {record['plant']}{axes}, every {record['sample_time_s']:g} s",
        *(f"{what}: {content}" for what, content in about.items() if content),
    )
    signals = [(one["name"], one["unit"], one["meaning"]) for one in record["signals"]]
    tree = [(f"unit-{x['id']}", x["column_input"], x["row_input"]) for x in record["units"]]
    keys = [(x["key"], text_of(x["value"], x["unit"]), x["meaning"]) for x in record["keys"]]
    for title, names, rows in (
        ("signals that it reads", ("signal", "unit", "meaning"), signals),
        ("fuzzy units, the root last", ("unit", "columns", "rows"), tree),
        ("controller", ("key", "value", "meaning"), keys),
    ):
        if rows:
            yield Table("", names, rows, title=title)


def plants() -> Iterator[Table]:
    """Yield texts and tables on all plants: signals and default parameters, once for each drive."""
    from hfc_design.files.machine import ALL_PLANTS
    from plants import Drive, machine_of  # which import JAX

    shown: set[Drive] = set()
    for name in ALL_PLANTS.names():
        machine, lines = machine_of(ALL_PLANTS.get(name)), [name]
        for drive in dict.fromkeys(machine.drives):
            each = zip(machine.axes, machine.drives, strict=True)
            added = [axis for axis, other in each if other is drive]
            if len(machine.axes) > 1:
                again = ", as above" if drive in shown else ""
                axes = f"{'axis' if len(added) == 1 else 'axes'} {', '.join(added)}"
                lines.append(f"{axes}: {drive.name}{again}")
            if drive not in shown:
                signals = ", ".join(f"{signal} [{unit}]" for signal, unit in drive.units.items())
                yield text(*lines, f"signals: {signals}")
                defaults, units = drive.parameters()._asdict(), drive.parameter_units
                rows = [(key, f"{value:g}", units.get(key, "")) for key, value in defaults.items()]
                yield Table("", ("parameter", "default", "unit"), rows)
                lines = []
            shown.add(drive)
        if lines:
            yield text(*lines)
