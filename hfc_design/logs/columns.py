"""Columns of a recording by their names in the file, and their assignment to signals with units."""

import re
from collections.abc import Collection, Iterable, Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import LARGEST_NUMBER, Floats, Mask, number_of
from hfc_design.core.quantities import number
from hfc_design.core.records import either, option
from plants import Drive, in_a_name

#: The largest file [MB]; an hour of four columns at 1 kHz has about 150 MB.
LARGEST_LOG = 512
#: Largest count of numbers in all arrays together, and of columns in a table.
MOST_NUMBERS, MOST_COLUMNS = 30_000_000, 1000
#: Smallest number of samples that allows an identification.
FEWEST = 20
#: A user's ``NAME=COLUMN``, with or without the unit of the column and the number at which it wraps
#: around: ``position=qm [m]``, ``position=count [5 um] mod 65536``.
MAPPED = re.compile(
    r"\s*(?P<name>\w{1,64})\s*=\s*(?P<column>.+?)\s*(\[(?P<unit>[^\[\]]{1,40})\])?"
    r"(\s+mod\s+(?P<modulus>[-+.0-9eE]{1,20}))?\s*"
)
#: A column whose own name contains the unit: ``x [mm]``, ``x (mm)``.
TOLD = re.compile(r"(?P<name>.+?)\s*[\[(](?P<unit>[^\[\]()]{1,40})[\])]")


class Log(NamedTuple):
    """A log as read from its file: columns of numbers."""

    columns: dict[str, Floats]  # (rows,) each, by name
    sample_time: float | None = None  # [s]; None: the file does not say it
    breaks: Mask | None = None  # (rows,) True if samples are missing before the row; None: nowhere
    format: str = "CSV"
    texts: tuple[str, ...] = ()  # names of columns that hold no numbers, and are left out
    notes: tuple[str, ...] = ()  # for the user
    others: tuple["Log", ...] = ()  # signals of the file that have other times

    @property
    def rows(self) -> int:
        """Number of samples."""
        return len(next(iter(self.columns.values())))


def joined(logs: Sequence[Log]) -> Log:
    """Return signals with different times as one log, without times that are too few."""
    first, *others = [log for log in logs if log.rows >= FEWEST] or logs
    return first._replace(others=tuple(others))


def check_log(log: Log) -> Log:
    """Return the log itself; ValueError: it is too short, ragged, or not all values are numbers."""
    if log.others:  # ``signals`` checks those that it chooses
        return log
    if not log.columns:
        raise ValueError("must have a column of numbers")
    lengths = {name: len(column) for name, column in log.columns.items()}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise ValueError(f"its columns must have one length (got {listed[:200]})")
    if log.rows < FEWEST:
        raise ValueError(f"must have at least {FEWEST} samples (got {log.rows})")
    for name, column in log.columns.items():
        if (bad := np.flatnonzero(~(np.abs(column) <= LARGEST_NUMBER))).size:
            others = f"not in {bad.size} of {log.rows} samples, the first is sample {bad[0] + 1}"
            allowed = f"must have numbers up to {LARGEST_NUMBER:g}"
            raise ValueError(f"column {name}: {allowed} ({others})")
    return log


class Column(NamedTuple):
    """Assignment of a signal to a column of a log, with the unit of its numbers."""

    name: str  # of the signal
    column: str  # its name in the file
    unit: str | None = None  # as "mm", or one count as "5 um"; None: the drive's unit
    modulus: float | None = None  # in this unit; None: a rotary position may wrap at a turn


def parse_columns(texts: Iterable[str], drive: Drive) -> list[Column]:
    """Parse a user's assignment of signals to the columns of a drive's log.

    Raises:
        ValueError: an assignment is not NAME=COLUMN, its signal is unknown or assigned twice, or
            its unit is of another kind than that of the signal.
    """
    columns, units = dict[str, Column](), units_of(drive)
    for text in texts:
        if not (said := MAPPED.fullmatch(text)):
            raise ValueError(f"{text[:60]!r}: must be NAME=COLUMN, as in 'position=qm [m]'")
        modulus = number_of(said["modulus"]) if said["modulus"] else None
        one = Column(said["name"], said["column"], said["unit"], modulus)
        if other := columns.get(one.name):
            both = f"{other.column[:60]!r} and {one.column[:60]!r}"
            raise ValueError(f"{one.name}: must be one column (got {both})")
        if one.name not in units:
            known = ", ".join(units)
            raise ValueError(f"{one.name}: unknown signal of {drive.name}; available: {known}")
        if modulus is not None and (modulus <= 0 or units[one.name] != drive.units["error"]):
            raise ValueError(f"{one.name}: mod must be a number above 0, for a position")
        scale(one, drive)
        columns[one.name] = one
    return [*columns.values()]


def scale(one: Column, drive: Drive) -> float:
    """Return the factor from a column's unit to its signal's; ValueError: they differ in kind."""
    unit = units_of(drive)[one.name]
    count = one.unit or unit
    try:
        return converted(count if count[0] in "+-.0123456789" else f"1 {count}", unit, drive)
    except ValueError:
        allowed = f"must be a unit like [{unit}], or a count as in [0.05 {unit}]"
        whole = f"column {one.column[:60]} for the {one.name}: {count!r} {allowed}"
        raise ValueError(whole) from None


def converted(quantity: str, unit: str, drive: Drive) -> float:
    """Return a quantity such as "5 um" in ``unit``, for a nominal drive; ValueError: wrong kind."""
    millimetres = None if drive.millimetres is None else drive.millimetres(drive.parameters())
    return number(quantity, unit, millimetres)


def column_hint(name: str) -> str:
    """Return a hint for users how to assign a column to the signal ``name``."""
    return f"give {name}=COLUMN [UNIT] with {option('column', ..., 'columns')}"


#: Words in the names of columns that suggest a signal; "" stands for any position.
HINTS = {
    "reference": ("set", "ref", "demand", "target", "nominal"),
    "time": ("time", "stamp"),
    "command": ("torque", "voltage", "current", "force", "command", "output", "control"),
    "": ("actual", "pos", "angle", "feedback", "encoder"),
}


def missing_columns(
    log: Log, drive: Drive, missing: Sequence[str], known: dict[str, Column]
) -> str:
    """Return a message on all ``missing`` signals, with options for columns guessed by name."""
    used = {one.column for one in known.values()}
    free = [x for x in log.columns if x not in used]
    columns = dict[str, None]()
    for name in (*missing, *({"reference"} - {*known})):
        words = HINTS.get(name, (name, *name.split("_"), *HINTS[""]))
        hinted = (x for word in words for x in free if word in x.casefold())
        others = () if name in HINTS else HINTS["reference"]
        column = next((x for x in hinted if not any(w in x.casefold() for w in others)), None)
        if column:
            columns[f"{name}={_with_unit(name, column, drive)}"] = None
        elif name in missing:
            columns[f"{'NAME' if missing[1:] else name}=COLUMN [UNIT]"] = None
    several = f"s are the {', '.join(missing[:-1])} and {missing[-1]}"
    which = several if missing[1:] else f" is the {missing[0]}"
    other = f", or {option('sample_time', ...)}" if "time" in missing else ""
    given = either(" ".join(f'--column "{text}"' for text in columns), f"columns={[*columns]}")
    rest = "" if "COLUMN" not in " ".join(columns) and not log.texts else f"; {listed_columns(log)}"
    return f"which column{which}? Give {given}{other}{rest}"


def _with_unit(name: str, column: str, drive: Drive) -> str:
    """Return a column as an option names it: with a unit, unless its own name contains one."""
    unit, named = units_of(drive)[name], TOLD.fullmatch(column)
    if named and unit_of(named["unit"], unit, drive):
        return column
    if not (named and named["unit"] == "%" and name == "command"):
        return f"{column} [UNIT]"
    highest = drive.largest_commands(drive.parameters())[1]
    return f"{column} [{highest / 100:g} {unit}]" if highest < inf else f"{column} [UNIT]"


def listed_columns(log: Log) -> str:
    """Return a text that lists the columns of a log."""
    texts = f"; without numbers: {', '.join(log.texts)[:80]}" if log.texts else ""
    others = ", ".join(x for one in log.others for x in one.columns)[:80]
    others = f"; at other times: {others}" if others else ""
    return f"available: {', '.join(log.columns)[:120]}{others}{texts}"


def parts_of(column: str) -> list[tuple[str, str]]:
    """Return possible splits of a column's name into name and unit: ``x [mm]``, ``x_mm``."""
    if named := TOLD.fullmatch(column):
        return [(named["name"], named["unit"])]
    words = column.split("_")
    return [("_".join(words[:k]), "_".join(words[k:])) for k in range(1, len(words))]


def named_like(name: str, log: Log) -> list[str]:
    """Return the columns of a log with a name: exactly, else in any case, else without a unit."""
    wanted, named = name.casefold(), {x: TOLD.fullmatch(x) for x in log.columns}
    return (
        [x for x in log.columns if x == name]
        or [x for x in log.columns if x.casefold() == wanted]
        or [x for x, parts in named.items() if parts and parts["name"].casefold() == wanted]
    )


def find_column(one: Column, log: Log, drive: Drive) -> Column:
    """Return an assignment as the log names the column, with the unit in its name if none is given.

    Raises:
        ValueError: there is no such column, or its unit is %, which needs a value from the user.
    """
    unit = units_of(drive)[one.name]
    if len(matching := named_like(one.column, log)) != 1:
        raise ValueError(f"unknown column {one.column[:60]!r}; {listed_columns(log)}")
    one = one._replace(column=matching[0])
    if one.unit is not None:
        return one
    units = [end for _, end in parts_of(one.column)]
    if units == ["%"] and TOLD.fullmatch(one.column):
        hint = f"{column_hint(one.name)}, as [0.1 {unit}]"
        raise ValueError(f"column {one.column[:60]}: needs the value of 1 %; {hint}")
    return one._replace(unit=next(filter(None, (unit_of(x, unit, drive) for x in units)), None))


#: Ends of column names that the library of units knows, but that mean something else there.
NO_UNIT = frozenset({"c", "pi", "au", "count", "counts", "bit", "bits", "point", "points"})


def is_unit(text: str) -> bool:
    """Return True if the text is a unit of any quantity."""
    try:
        return number(f"1 {text}", text) == 1.0
    except ValueError:
        return False


def unit_of(end: str, unit: str, drive: Drive) -> str | None:
    """Return the unit at the ``end`` of a name (mm_s: mm/s); None: not convertible to ``unit``."""
    if end == in_a_name(unit):
        return unit
    written = end.replace("_", "/")
    try:
        converted(f"1 {written}", unit, drive)
    except ValueError:
        return None
    return None if end in NO_UNIT else written


def units_of(drive: Drive) -> dict[str, str]:
    """Return the unit of every signal that a log of a drive may contain, by name.

    ``added`` is added to the command after the controller; the recorded command includes it.
    """
    place, rate, command = (drive.units[name] for name in ("error", "error_rate", "command"))
    rates = rates_of(drive)
    units = {"time": "s", "command": command, "reference": place, "load": drive.units["load"]}
    units |= {"added": command} | dict.fromkeys(rates, place) | dict.fromkeys(rates.values(), rate)
    return units | {
        x: u for x, u in drive.units.items() if x not in ("error", "error_rate", *units)
    }


def rates_of(drive: Drive) -> dict[str, str]:
    """Return position -> velocity, by names, for a drive; the position fed back is the first."""
    return {drive.seen[0]: drive.seen[1], drive.position: drive.velocity, **drive.encoders}


def columns_by_name(log: Log, drive: Drive, said: Collection[str]) -> dict[str, Column]:
    """Return columns named like signals other than ``said``; ValueError: two for one signal."""
    by_name = dict[str, Column]()
    others = {"command": drive.command_name, "load": drive.load_name}
    for name, unit in units_of(drive).items():
        if name in said:
            continue
        names = {name.casefold(), others.get(name, name).casefold()}
        units = {x: _unit_after(x, names, unit, drive) for x in log.columns}
        columns = [Column(name, x, end) for x, end in units.items() if end]
        if len(columns) > 1:
            both = " and ".join(repr(one.column) for one in columns[:2])
            raise ValueError(f"columns {both} may both be the {name}; {column_hint(name)}")
        if columns:
            by_name[name] = columns[0]
    return by_name


def _unit_after(column: str, names: Collection[str], unit: str, drive: Drive) -> str | None:
    """Return the unit of a column if it is named like one of ``names``, else None."""
    if column.casefold() in names:
        return unit
    ends = [end for name, end in parts_of(column) if name.casefold() in names]
    if TOLD.fullmatch(column):
        return ends[0] if ends else None
    return next(filter(None, (unit_of(end, unit, drive) for end in ends)), None)
