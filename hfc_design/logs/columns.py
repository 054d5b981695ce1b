"""Which column of a log is which signal of a drive, and what its numbers count in."""

import re
from collections.abc import Collection
from typing import NamedTuple

from hfc_design.core.quantities import number
from hfc_design.logs.log import Log
from plants import Drive, in_a_name

#: ``NAME=COLUMN`` of a user, with the unit of its numbers behind it: ``position=qm [m]``.
MAPPED = re.compile(
    r"\s*(?P<name>\w{1,64})\s*=\s*(?P<column>.+?)\s*(\[(?P<unit>[^\[\]]{1,40})\])?\s*"
)
#: A column whose own name tells the unit: ``x [mm]``, ``x (mm)``.
TOLD = re.compile(r"(?P<name>.+?)\s*[\[(](?P<unit>[^\[\]()]{1,40})[\])]")


class Column(NamedTuple):
    """Which column of a log a signal is, and what its numbers count in."""

    name: str  # of the signal
    column: str
    unit: str | None = None  # of one count, "5 um" say; None: that of the drive


def mapped(text: str) -> Column:
    """What a user says of a column; ValueError: it cannot be understood."""
    found = MAPPED.fullmatch(text)
    if not found:
        raise ValueError(f"{text[:60]!r}: has to be NAME=COLUMN, as in 'position=qm [m]'")
    return Column(found["name"], found["column"], found["unit"])


def looked_up(one: Column, log: Log, unit: str, millimetres: float | None) -> Column:
    """The column of a user in a log, with the unit that its name tells where the user says none.

    Raises:
        ValueError: there is no such column.
    """
    if one.column not in log.columns and f"{one.column} [{one.unit}]" in log.columns:
        return one._replace(column=f"{one.column} [{one.unit}]")
    if one.column not in log.columns:
        there = ", ".join(log.columns)
        raise ValueError(f"has no column {one.column[:60]!r}; there is {there[:300]}")
    if one.unit is not None:
        return one
    told = TOLD.fullmatch(one.column)
    parts = one.column.split("_")[1:]  # of speed_mm_s it is mm/s
    ends = [told["unit"]] if told else ["/".join(parts[k:]) for k in range(len(parts))]
    return one._replace(unit=next((end for end in ends if _counts(end, unit, millimetres)), None))


def _counts(text: str, unit: str, millimetres: float | None) -> bool:
    """Whether a text is a unit that can be counted in another one."""
    try:
        number(f"1 {text}", unit, millimetres)
    except ValueError:
        return False
    return True


def units_of(drive: Drive) -> dict[str, str]:
    """Everything that a log may hold of a drive, and what it counts in.

    ``added`` is what came to the command after the controller, and is in the recorded one.
    """
    place, rate, command = (drive.units[name] for name in ("error", "error_rate", "command"))
    pairs = {drive.seen[0]: drive.seen[1], drive.position: drive.velocity, **drive.encoders}
    units = {"time": "s", "command": command, "reference": place, "load": drive.units["load"]}
    units |= {
        "added": command,
        **dict.fromkeys(pairs, place),
        **dict.fromkeys(pairs.values(), rate),
    }
    return units | {
        x: u for x, u in drive.units.items() if x not in ("error", "error_rate", *units)
    }


def by_name(log: Log, drive: Drive, said: Collection[str]) -> dict[str, Column]:
    """Columns that are called like a signal, with or without a unit; not of those ``said``."""
    found: dict[str, Column] = {}
    others = {"command": drive.command_name, "load": drive.load_name}
    for name, unit in units_of(drive).items():
        if name in said:
            continue
        names = {name, others.get(name, name)}
        own = names | {f"{one}_{in_a_name(unit)}" for one in names}
        for column in log.columns:
            told = TOLD.fullmatch(column)
            if column not in own and not (told and told["name"] in names):
                continue
            if name in found:
                both = f"{found[name].column} and {column}"
                raise ValueError(f"{both} may be the {name}: which one? say {name}=COLUMN [UNIT]")
            found[name] = Column(name, column, None if column in own or not told else told["unit"])
    return found
