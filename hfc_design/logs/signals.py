"""The signals of a drive in a log: in its units, evenly sampled, with what is not to be trusted."""

from collections.abc import Mapping, Sequence

import numpy as np

from hfc_design.core.numbers import SAME_SINGLE, Floats, Mask
from hfc_design.logs.columns import (
    Column,
    by_name,
    gaps,
    how,
    looked_up,
    scale,
    units_of,
)
from hfc_design.logs.even import Even, even
from hfc_design.logs.log import Log
from hfc_design.logs.sensors import checked_travel, righted, step_of, unwrapped
from plants import Drive

#: A signal that changes by no more stands still, in any unit.
LEAST = 1e-30
#: Noise changes by 1.4 times its own size from sample to sample, a motion by far less.
TREMBLES = 0.7
#: Sample times of drives [s]; the most samples of which a fit keeps the slopes in memory.
FASTEST, SLOWEST, MOST = 1e-7, 0.5, 100_000


def signals(log: Log, drive: Drive, columns: Sequence[Column], sample_time: float | None) -> Even:
    """The signals of ``drive`` in a log, in its units.

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
    units = units_of(drive)
    named = by_name(log, drive, [*chosen])
    timed = {"time"} if log.sample_time or sample_time else set()
    known = chosen | named
    needed = ["time", drive.seen[0], *(["command"] if "reference" not in known else [])]
    if missing := [name for name in needed if name not in known.keys() | timed]:
        raise ValueError(gaps(log, drive, missing, known))
    taken, values, places = list[str](), dict[str, Floats](), dict[str, Column]()
    for name, own in known.items():
        one = looked_up(own, log, drive)
        unit = one.unit or units[name]
        if own.unit is None or (name in named and unit != units[name]):
            taken.append(f"{name} is {one.column} in {unit}")
        values[name] = scale(one, drive) * log.columns[one.column]
        if units[name] == drive.units["error"]:
            places[name] = one._replace(unit=unit)
    turned = unwrapped(values, [*places], drive)
    _check(values, drive)
    told, step = log.sample_time or sample_time, step_of(values[drive.seen[0]])
    found = even(values.pop("time", None), told, values, log.breaks)
    if not FASTEST <= found.sample_time <= SLOWEST:
        raise ValueError(
            f"is sampled every {found.sample_time:.3g} s; a drive's log every {FASTEST:g} to "
            f"{SLOWEST:g} s: which unit has its time? {how('time')}"
        )
    duration = found.sample_time * len(found.usable)
    for name, one in places.items():
        checked_travel(one, found.values[name], drive, duration)
    found.notes.extend(turned)
    if taken:
        found.notes.insert(0, f"{', '.join(taken)}; another unit: NAME=COLUMN [UNIT]")
    return _trusted(found, drive)._replace(step=step)


def _check(values: Mapping[str, Floats], drive: Drive) -> None:
    """ValueError: something that is needed stands."""
    position = drive.seen[0]
    for name in ("command", position):
        if name in values and np.ptp(values[name]) <= LEAST:
            raise ValueError(f"the {name} is {values[name][0]:.6g} throughout: nothing moves")
    place, _ = righted(values[position])
    size, change = np.std(place), np.std(np.diff(place))
    if change > TREMBLES * size:
        raise ValueError(
            f"the {position} only trembles by {size:.2g} {drive.units['error']} (rms), from sample "
            "to sample: nothing moves"
        )


def _trusted(found: Even, drive: Drive) -> Even:
    """The first samples, if there are too many; what is wrong or at an end of a scale marked."""
    if len(found.usable) > MOST:
        told = f"only the first {MOST * found.sample_time:.4g} s are used ({MOST} samples)"
        found.notes.append(told)
        values = {name: column[:MOST] for name, column in found.values.items()}
        found = found._replace(values=values, usable=found.usable[:MOST])
    notes, usable = [*found.notes], found.usable.copy()
    position = found.values[drive.seen[0]]
    right, wrong = righted(position)
    if wrong.any():
        k, unit = int(np.flatnonzero(wrong)[0]), drive.units["error"]
        off = position[k] - 0.5 * (position[k - 1] + position[k + 1])
        found.values[drive.seen[0]], usable = right, usable & ~wrong
        notes.append(
            f"{wrong.sum()} wrong samples of {drive.seen[0]} are left out: the one at "
            f"{k * found.sample_time:.4g} s is {off:.3g} {unit} off those before and after it"
        )
    clipped = at_an_end(right)
    if clipped.any():
        usable &= ~clipped
        notes.append(
            f"{100 * clipped.mean():.2g} % of the samples of {drive.seen[0]} are at an end of its "
            "scale and left out"
        )
    return found._replace(usable=usable, notes=notes)


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
            # In whole steps of an encoder one of them may be just that share of four.
            if end - begin >= STAYS and arrives > ARRIVES * typical * (1.0 + SAME_SINGLE):
                found[begin:end] = True
    return found
