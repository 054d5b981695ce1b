"""The signals of a drive in a log: in its units, evenly sampled, with what is not to be trusted."""

import re
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Mask
from hfc_design.core.quantities import number
from hfc_design.logs.even import Even, even
from hfc_design.logs.log import Log
from plants import Drive, in_a_name

#: ``NAME=COLUMN`` of a user, with the unit of its numbers behind it: ``position=qm [m]``.
MAPPED = re.compile(
    r"\s*(?P<name>\w{1,64})\s*=\s*(?P<column>.+?)\s*(\[(?P<unit>[^\[\]]{1,40})\])?\s*"
)
#: A column whose own name tells the unit: ``x [mm]``, ``x (mm)``.
TOLD = re.compile(r"(?P<name>.+?)\s*[\[(](?P<unit>[^\[\]()]{1,40})[\])]")
#: A signal that changes by no more stands still, in any unit.
LEAST = 1e-30
#: Noise changes by 1.4 times its own size from sample to sample, a motion by far less.
TREMBLES = 0.7
#: Sample times of drives [s]; the most samples of which a fit keeps the slopes in memory.
FASTEST, SLOWEST, MOST = 1e-7, 0.5, 200_000
#: Names beside those of the drive's own signals.
BESIDE = ("time", "command", "reference", "load", "added")


class Column(NamedTuple):
    """Which column of a log a signal is, and what its numbers count in."""

    name: str  # of the signal
    column: str
    unit: str | None = None  # of one count, "5 um" say; None: that of the drive


class Signals(NamedTuple):
    """One recorded motion of one axis, (steps,) each."""

    time: Floats  # [s], from 0
    sample_time: float  # [s]
    values: dict[str, Floats]  # by name, in units of the drive
    usable: Mask  # what is neither filled in nor cut off
    notes: tuple[str, ...]  # what was found, for the user


def mapped(text: str) -> Column:
    """What a user says of a column; ValueError: it cannot be understood."""
    found = MAPPED.fullmatch(text)
    if not found:
        raise ValueError(f"{text[:60]!r}: has to be NAME=COLUMN, as in 'position=qm [m]'")
    return Column(found["name"], found["column"], found["unit"])


def signals(
    log: Log, drive: Drive, columns: Sequence[Column], sample_time: float | None
) -> Signals:
    """The signals of ``drive`` in a log.

    Args:
        log: as its file has it.
        drive: whose units are wanted.
        columns: what the user says of them; others are taken by their names, ``position`` or
            ``position_mm`` or ``position [mm]``.
        sample_time: [s], where neither the file nor a column of times has it.

    Raises:
        ValueError: a column is missing or has another kind of unit; nothing moves.
    """
    chosen = {one.name: one for one in columns}
    chosen |= _by_name(log, drive, [*chosen])
    millimetres = None if drive.millimetres is None else drive.millimetres(drive.parameters())
    units, values = units_of(drive), dict[str, Floats]()
    for name, one in chosen.items():
        if name not in units:
            known = ", ".join(units)
            raise ValueError(f"{name}: is no signal of {drive.name}; there is {known}")
        if one.column not in log.columns:
            there = ", ".join(log.columns)
            raise ValueError(f"has no column {one.column[:60]!r}; there is {there[:300]}")
        unit = one.unit or units[name]
        scale = number(
            unit if unit[0] in "+-.0123456789" else f"1 {unit}", units[name], millimetres
        )
        values[name] = scale * log.columns[one.column]
    _check(values, drive, log)
    told = log.sample_time or sample_time
    found = even(values.pop("time", None), told, values, log.breaks)
    if not FASTEST <= found.sample_time <= SLOWEST:
        raise ValueError(
            f"is sampled every {found.sample_time:.3g} s; a drive's log every {FASTEST:g} to "
            f"{SLOWEST:g} s: which unit has its time? say time=COLUMN [UNIT]"
        )
    return _signals(_first(found), drive)


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


def _by_name(log: Log, drive: Drive, said: Collection[str]) -> dict[str, Column]:
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


def _check(values: Mapping[str, Floats], drive: Drive, log: Log) -> None:
    """ValueError: something that is needed is missing, or stands."""
    position = drive.seen[0]
    needed = [
        name for name in ("command", position) if name != "command" or "reference" not in values
    ]
    for name in needed:
        if name not in values:
            there = ", ".join(log.columns)
            raise ValueError(
                f"which column is the {name}? say {name}=COLUMN [UNIT]; there is {there[:300]}"
            )
    for name in ("command", position):
        if name in values and np.ptp(values[name]) <= LEAST:
            raise ValueError(f"the {name} is {values[name][0]:.6g} throughout: nothing moves")
    size, change = np.std(values[position]), np.std(np.diff(values[position]))
    if change > TREMBLES * size:
        raise ValueError(
            f"the {position} only trembles by {size:.2g} {drive.units['error']} (rms), from sample "
            "to sample: nothing moves"
        )


def _first(found: Even) -> Even:
    """The first samples, if there are too many."""
    if len(found.usable) <= MOST:
        return found
    values = {name: column[:MOST] for name, column in found.values.items()}
    note = f"only the first {MOST * found.sample_time:.4g} s are used ({MOST} samples)"
    return found._replace(values=values, usable=found.usable[:MOST], notes=[*found.notes, note])


def _signals(found: Even, drive: Drive) -> Signals:
    """With what of it is at an end of its scale marked."""
    notes, usable = [*found.notes], found.usable.copy()
    position = found.values[drive.seen[0]]
    clipped = at_an_end(position)
    if clipped.any():
        usable &= ~clipped
        notes.append(
            f"{100 * clipped.mean():.2g} % of the samples of {drive.seen[0]} are at an end of its "
            "scale and left out"
        )
    time = found.sample_time * np.arange(len(usable), dtype=float)
    return Signals(time, found.sample_time, found.values, usable, tuple(notes))


#: So many samples in a row exactly at the largest or the smallest value are an end of a scale,
#: if it comes there faster than by this share of its usual change in a sample.
STAYS, ARRIVES = 5, 0.25


def at_an_end(values: Floats) -> Mask:
    """(steps,) where a measured signal that was still moving is held at its extreme.

    One that comes to rest there slows down before; one that is cut off does not.
    """
    found = np.zeros(len(values), bool)
    change = np.abs(np.diff(values))
    typical = np.median(change[change > 0]) if (change > 0).any() else 0.0
    for extreme in (values.max(), values.min()):
        held = np.flatnonzero(np.diff(np.r_[0, values == extreme, 0]))
        for begin, end in zip(held[::2], held[1::2], strict=True):
            arrives = change[max(begin - 2, 0) : begin].max(initial=0.0)
            if end - begin >= STAYS and arrives > ARRIVES * typical:
                found[begin:end] = True
    return found
