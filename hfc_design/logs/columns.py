"""Columns of a recording by the names that stand in its file, and which signal each is, in what."""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import LARGEST_NUMBER, Floats, Mask
from hfc_design.core.quantities import number
from plants import Drive, in_a_name

#: The largest file [MB]; an hour of four columns at 1 kHz has some 150.
LARGEST_LOG = 512
#: The most numbers that arrays may have in all, and columns that a table may have.
MOST_NUMBERS, MOST_COLUMNS = 30_000_000, 1000
#: The most that a packed file may unpack to [bytes].
MOST_BYTES = 8 * MOST_NUMBERS
#: The fewest samples that something can be learnt from.
FEWEST = 20
#: ``NAME=COLUMN`` of a user, with the unit of its numbers behind it: ``position=qm [m]``.
MAPPED = re.compile(
    r"\s*(?P<name>\w{1,64})\s*=\s*(?P<column>.+?)\s*(\[(?P<unit>[^\[\]]{1,40})\])?\s*"
)
#: A column whose own name tells the unit: ``x [mm]``, ``x (mm)``.
TOLD = re.compile(r"(?P<name>.+?)\s*[\[(](?P<unit>[^\[\]()]{1,40})[\])]")


class Log(NamedTuple):
    """Columns of one length, all finite."""

    columns: dict[str, Floats]  # (rows,) each, by name
    sample_time: float | None = None  # [s], where the file says it
    breaks: Mask | None = None  # (rows,) samples are missing before this one; None: none are
    format: str = "CSV"
    texts: tuple[str, ...] = ()  # names of columns that hold no numbers, and are left out

    @property
    def rows(self) -> int:
        """How many samples it has."""
        return len(next(iter(self.columns.values())))


def check_log(log: Log) -> Log:
    """The same log; ValueError: it is too short, ragged, or has what is no number."""
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
            raise ValueError(
                f"column {name}: must have numbers up to {LARGEST_NUMBER:g} "
                f"(not in {bad.size} of {log.rows} samples, the first is sample {bad[0] + 1})"
            )
    return log


class Column(NamedTuple):
    """Which column of a log a signal is, and what its numbers count in."""

    name: str  # of the signal
    column: str
    unit: str | None = None  # of one count, "5 um" say; None: that of the drive


def parse_columns(texts: Iterable[str], drive: Drive) -> list[Column]:
    """Parse a user's assignment of signals to the columns of a drive's log.

    Raises:
        ValueError: one is not of the form NAME=COLUMN, names no signal or one twice, or its unit is
            of another kind.
    """
    columns, units = dict[str, Column](), units_of(drive)
    for text in texts:
        if not (said := MAPPED.fullmatch(text)):
            raise ValueError(f"{text[:60]!r}: must be NAME=COLUMN, as in 'position=qm [m]'")
        one = Column(said["name"], said["column"], said["unit"])
        if other := columns.get(one.name):
            both = f"{other.column[:60]!r} and {one.column[:60]!r}"
            raise ValueError(f"{one.name}: must be one column (got {both})")
        if one.name not in units:
            known = ", ".join(units)
            raise ValueError(f"{one.name}: unknown signal of {drive.name}; available: {known}")
        scale(one, drive)
        columns[one.name] = one
    return [*columns.values()]


def scale(one: Column, drive: Drive) -> float:
    """What a count of the column is in the unit of its signal; ValueError: of another kind."""
    unit = units_of(drive)[one.name]
    count = one.unit or unit
    try:
        return converted(count if count[0] in "+-.0123456789" else f"1 {count}", unit, drive)
    except ValueError:
        raise ValueError(
            f"column {one.column[:60]} for the {one.name}: {count!r} must be "
            f"a unit like [{unit}], or a count as in [0.05 {unit}]"
        ) from None


def converted(quantity: str, unit: str, drive: Drive) -> float:
    """A quantity in ``unit``, by the units of a nominal machine; ValueError: it is no such one."""
    millimetres = None if drive.millimetres is None else drive.millimetres(drive.parameters())
    return number(quantity, unit, millimetres)


def column_hint(name: str) -> str:
    """How a user says which column a signal is."""
    return f"give {name}=COLUMN [UNIT] with --column"


#: Words in the names of columns that may be a signal, those of a reference first.
HINTS = {
    "reference": ("set", "ref", "demand", "target", "nominal"),
    "time": ("time", "stamp"),
    "command": ("torque", "voltage", "current", "force", "command", "output", "control"),
    "": ("actual", "pos", "angle", "feedback", "encoder"),
}


def missing_columns(
    log: Log, drive: Drive, missing: Sequence[str], known: dict[str, Column]
) -> str:
    """What is missing, all of it, with the options that say it; guesses by names of columns."""
    used = {one.column for one in known.values()}
    free = [x for x in log.columns if x not in used]
    options = dict[str, None]()
    for name in (*missing, *({"reference"} - {*known})):
        words = HINTS.get(name, (name, *name.split("_"), *HINTS[""]))
        hinted = (x for word in words for x in free if word in x.casefold())
        others = () if name in HINTS else HINTS["reference"]
        column = next((x for x in hinted if not any(w in x.casefold() for w in others)), None)
        if column:
            options[f'--column "{name}={_with_unit(name, column, drive)}"'] = None
        elif name in missing:
            options[f'--column "{"NAME" if missing[1:] else name}=COLUMN [UNIT]"'] = None
    several = f"s are the {', '.join(missing[:-1])} and {missing[-1]}"
    which = several if missing[1:] else f" is the {missing[0]}"
    other = ", or --sample-time" if "time" in missing else ""
    rest = "" if "COLUMN" not in " ".join(options) and not log.texts else f"; {listed_columns(log)}"
    return f"which column{which}? Give {' '.join(options)}{other}{rest}"


def _with_unit(name: str, column: str, drive: Drive) -> str:
    """A column as an option says it: with a unit where its own name does not tell one."""
    unit, named = units_of(drive)[name], TOLD.fullmatch(column)
    if named and unit_of(named["unit"], unit, drive):
        return column
    if not (named and named["unit"] == "%" and name == "command"):
        return f"{column} [UNIT]"
    highest = drive.largest_commands(drive.parameters())[1]
    return f"{column} [{highest / 100:g} {unit}]" if highest < inf else f"{column} [UNIT]"


def listed_columns(log: Log) -> str:
    """The columns that a log has."""
    texts = f"; without numbers: {', '.join(log.texts)[:80]}" if log.texts else ""
    return f"available: {', '.join(log.columns)[:120]}{texts}"


def parts_of(column: str) -> list[tuple[str, str]]:
    """Names and units that the name of a column may consist of: ``x [mm]``, ``x_mm``."""
    if named := TOLD.fullmatch(column):
        return [(named["name"], named["unit"])]
    words = column.split("_")
    return [("_".join(words[:k]), "_".join(words[k:])) for k in range(1, len(words))]


def find_column(one: Column, log: Log, drive: Drive) -> Column:
    """The column of a user in a log, with the unit that its name tells where the user says none.

    Raises:
        ValueError: there is no such column.
    """
    wanted, unit = one.column.casefold(), units_of(drive)[one.name]
    if one.column not in log.columns:
        named = {x: TOLD.fullmatch(x) for x in log.columns}
        whole = [x for x in log.columns if x.casefold() == wanted] or [
            x for x, parts in named.items() if parts and parts["name"].casefold() == wanted
        ]
        if len(whole) != 1:
            raise ValueError(f"unknown column {one.column[:60]!r}; {listed_columns(log)}")
        one = one._replace(column=whole[0])
    if one.unit is not None:
        return one
    units = [end for _, end in parts_of(one.column)]
    if units == ["%"] and TOLD.fullmatch(one.column):
        raise ValueError(
            f"column {one.column[:60]}: needs the unit of a per cent; "
            f"{column_hint(one.name)}, as [0.1 {unit}]"
        )
    return one._replace(unit=next(filter(None, (unit_of(x, unit, drive) for x in units)), None))


#: Ends of names that a library of units knows, and that mean something else there.
NO_UNIT = frozenset({"c", "pi", "au", "count", "counts", "bit", "bits", "point", "points"})


def is_unit(text: str) -> bool:
    """Whether it is a unit of anything."""
    try:
        return number(f"1 {text}", text) == 1.0
    except ValueError:
        return False


def unit_of(end: str, unit: str, drive: Drive) -> str | None:
    """The unit that the end of a name is, mm_s for mm/s; None: none that counts in ``unit``."""
    if end == in_a_name(unit):
        return unit
    written = end.replace("_", "/")
    try:
        converted(f"1 {written}", unit, drive)
    except ValueError:
        return None
    return None if end in NO_UNIT else written


def units_of(drive: Drive) -> dict[str, str]:
    """Everything that a log may hold of a drive, and what it counts in.

    ``added`` is what came to the command after the controller, and is in the recorded one.
    """
    place, rate, command = (drive.units[name] for name in ("error", "error_rate", "command"))
    rates = rates_of(drive)
    units = {"time": "s", "command": command, "reference": place, "load": drive.units["load"]}
    units |= {"added": command} | dict.fromkeys(rates, place) | dict.fromkeys(rates.values(), rate)
    return units | {
        x: u for x, u in drive.units.items() if x not in ("error", "error_rate", *units)
    }


def rates_of(drive: Drive) -> dict[str, str]:
    """The velocity of each position of a drive, that of its feedback first."""
    return {drive.seen[0]: drive.seen[1], drive.position: drive.velocity, **drive.encoders}


def columns_by_name(log: Log, drive: Drive, said: Collection[str]) -> dict[str, Column]:
    """Columns that are called like a signal, with or without a unit; not of those ``said``."""
    by_name = dict[str, Column]()
    others = {"command": drive.command_name, "load": drive.load_name}
    for name, unit in units_of(drive).items():
        if name in said:
            continue
        names = {name.casefold(), others.get(name, name).casefold()}
        units = {x: _unit_after(x, names, unit, drive) for x in log.columns}
        columns = [Column(name, x, end) for x, end in units.items() if end]
        if len(columns) > 1:
            both = " and ".join(one.column for one in columns[:2])
            raise ValueError(f"{both} may both be the {name}; {column_hint(name)}")
        if columns:
            by_name[name] = columns[0]
    return by_name


def _unit_after(column: str, names: Collection[str], unit: str, drive: Drive) -> str | None:
    """The unit of a column that is called like one of ``names``; None: it is not."""
    if column.casefold() in names:
        return unit
    ends = [end for name, end in parts_of(column) if name.casefold() in names]
    if TOLD.fullmatch(column):
        return ends[0] if ends else None
    return next(filter(None, (unit_of(end, unit, drive) for end in ends)), None)


def longest(vectors: Mapping[str, np.ndarray]) -> dict[str, Floats]:
    """The longest ones as columns; ValueError: they have too many numbers."""
    most = max((vector.size for vector in vectors.values()), default=0)
    columns = {name: vector for name, vector in vectors.items() if vector.size == most}
    if most * len(columns) > MOST_NUMBERS:
        raise ValueError(f"it has more than {MOST_NUMBERS} numbers")
    with np.errstate(all="ignore"):  # what is no number is told
        return {name: np.asarray(vector, float).ravel() for name, vector in columns.items()}
