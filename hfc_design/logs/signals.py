"""Signals of a drive from a log: in its units, evenly sampled, with unreliable samples marked."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import SAME_SINGLE, Floats, Indices, Mask
from hfc_design.logs.columns import (
    FEWEST,
    Column,
    Log,
    check_log,
    column_hint,
    columns_by_name,
    find_column,
    missing_columns,
    named_like,
    scale,
    units_of,
)
from hfc_design.logs.sensors import FILLED, check_travel, encoder_step, unwrap, without_outliers
from plants import Drive

#: Largest change of a signal that counts as constant, in any unit.
LEAST = 1e-30
#: Noise changes by 1.4 times its rms from sample to sample (rms), a motion by less than this share.
TREMBLES = 0.7
#: Shortest and longest sample time [s]; the most samples for which a fit can store the slopes.
FASTEST, SLOWEST, MOST = 1e-7, 0.5, 100_000
#: rms deviation of time stamps from even times above which they jitter, as a share of a sample.
TREMBLE = 0.02
#: Share of samples with repeated stamps above which the clock is coarser than the samples.
SHARED = 0.1
#: Signals that stay constant until the next sample.
HELD = ("command", "added")
#: Share of its deviation from each time stamp by which the even clock of ``_places`` is corrected.
FOLLOWS = 0.1


class EvenLog(NamedTuple):
    """Evenly sampled signals of a log."""

    sample_time: float  # [s]
    values: dict[str, Floats]  # (steps,) each, by name
    usable: Mask  # (steps,) True for samples that were recorded, and are neither wrong nor clipped
    notes: list[str]  # for the user: what was found and changed
    step: float | None = None  # of the position's encoder; None: the log does not show it


def signals(
    log: Log, drive: Drive, columns: Sequence[Column], sample_time: float | None
) -> EvenLog:
    """Return the signals of ``drive`` in a log, evenly sampled and in its units.

    Args:
        log: log as read from its file.
        drive: drive whose units are used.
        columns: assignments by the user; other columns are assigned by their names, ``position`` or
            ``position_mm`` or ``position [mm]``.
        sample_time: [s]; needed if neither the file nor a column of times contains it.

    Of signals with different times, those are used that have most of the needed ones.

    Raises:
        ValueError: a column is missing, has another kind of unit, or does not move plausibly.
    """
    chosen, units = {one.name: one for one in columns}, units_of(drive)
    log = check_log(_with_most(log, drive, chosen))
    named = columns_by_name(log, drive, [*chosen])
    known = chosen | named
    timed = {"time"} if log.sample_time or sample_time else set()
    needed = ["time", drive.seen[0], *(["command"] if "reference" not in known else [])]
    if missing := [name for name in needed if name not in known.keys() | timed]:
        raise ValueError(missing_columns(log, drive, missing, known))
    taken, values, places = list[str](), dict[str, Floats](), dict[str, Column]()
    for name, wanted in known.items():
        column = find_column(wanted, log, drive)
        unit = column.unit or units[name]
        if wanted.unit is None or (name in named and unit != units[name]):
            taken.append(f"{name} is {column.column} in {unit}")
        values[name] = scale(column, drive) * log.columns[column.column]
        if units[name] == drive.units["error"]:
            places[name] = column._replace(unit=unit)
    turned = unwrap(values, places, drive, _apart(values.get("time"), log))
    _check(values, drive)
    step = encoder_step(values[drive.seen[0]])
    even = resampled(values.pop("time", None), log.sample_time or sample_time, values, log.breaks)
    if not FASTEST <= (every := even.sample_time) <= SLOWEST:
        allowed = f"must be {FASTEST:g} to {SLOWEST:g} s for the log of a drive"
        advice = f"check the unit of its time and {column_hint('time')}"
        raise ValueError(f"is sampled every {every:.3g} s; {allowed}: {advice}")
    for name, column in places.items():
        check_travel(column, even.values[name], drive, every * len(even.usable))
    notes = [f"{', '.join(taken)}; another unit: NAME=COLUMN [UNIT]"] if taken else []
    notes = [*log.notes, *notes, *even.notes, *turned]
    return _trusted(even._replace(notes=notes, step=step), drive)


def _with_most(log: Log, drive: Drive, chosen: Mapping[str, Column]) -> Log:
    """Return that of a log's groups of signals that has most of the needed ones, with a note."""
    groups, position = [log._replace(others=()), *log.others], drive.seen[0]

    def score(group: Log) -> tuple[int, bool, int]:
        assigned = {x for x, one in chosen.items() if len(named_like(one.column, group)) == 1}
        known = assigned | {*columns_by_name(group, drive, [*chosen])}
        return len(known & {position, "command"}), position in known, len(known)

    most = max(groups, key=score) if log.others else log
    others = tuple(group for group in groups if log.others and group is not most)
    left = ", ".join(name for one in others for name in one.columns)[:120]
    note = (f"signals with other times are left out: {left}",) if others else ()
    return most._replace(others=others, notes=most.notes + note)


def _apart(time: Floats | None, log: Log) -> Floats:
    """Return the distance of each row to the next one, in samples; inf at a gap of unknown size."""
    breaks = np.zeros(log.rows, bool) if log.breaks is None else log.breaks
    distance = np.ones(log.rows - 1) if time is None else np.diff(time)
    usual = np.median(distance[distance > 0]) if (distance > 0).any() else 1.0
    return np.where(breaks[1:], np.inf, np.maximum(np.round(distance / usual), 1.0))


def _check(values: Mapping[str, Floats], drive: Drive) -> None:
    """Check that command and position vary; ValueError: one is constant, or only noise."""
    position = drive.seen[0]
    for name in ("command", position):
        if name in values and np.ptp(values[name]) <= LEAST:
            raise ValueError(f"the {name} is {values[name][0]:.6g} throughout; the axis must move")
    place, _ = without_outliers(values[position])
    size, change = np.std(place), np.std(np.diff(place))
    if change > TREMBLES * size:
        only = f"only varies by {size:.2g} {drive.units['error']} (rms) from sample to sample"
        raise ValueError(f"the {position} {only}; the axis must move")


def _trusted(log: EvenLog, drive: Drive) -> EvenLog:
    """Return the log, at most ``MOST`` samples, with wrong and saturated samples marked."""
    name, unit, every, notes = drive.seen[0], drive.units["error"], log.sample_time, [*log.notes]
    if len(log.usable) > MOST:
        notes.append(f"only the first {MOST * every:.4g} s are used ({MOST} samples)")
    values = {signal: column[:MOST] for signal, column in log.values.items()}
    place, usable = values[name], log.usable[:MOST]
    right, wrong = without_outliers(place)
    if wrong.any():
        k = int(np.flatnonzero(wrong)[0])
        off = place[k] - 0.5 * (place[k - 1] + place[k + 1])
        one = f"the one at {k * every:.4g} s is {off:.3g} {unit} off those before and after it"
        notes.append(f"{wrong.sum()} wrong samples of {name} are left out: {one}")
    jumps = np.abs(np.diff(right))
    if jumps.max(initial=0.0) > max(0.5 * np.ptp(right), 1.5 * (log.step or 0.0)):
        jump = f"jumps by {jumps.max():.4g} {unit} after {jumps.argmax() * every:.4g} s"
        wraps = f"wraps around at a number N of its column, give {name}=COLUMN [UNIT] mod N"
        raise ValueError(f"the {name} {jump}: if it {wraps}")
    clipped = saturated(right)
    if clipped.any():
        share = f"{100 * clipped.mean():.2g} % of the samples of {name}"
        extreme = "at its largest or smallest value, as if the sensor saturates"
        notes.append(f"{share} are {extreme}, and are left out")
    usable = usable & ~wrong & ~clipped
    return log._replace(values=values | {name: right}, usable=usable, notes=notes)


#: Saturation: at least so many consecutive samples exactly at the largest or the smallest value.
#: The change before them exceeds this share of the usual change per sample, and so many steps of
#: the encoder. (At a reversal that is constant for as long, the change is at most two steps.)
STAYS, ARRIVES, STEPS = 5, 0.25, 2.5


def saturated(values: Floats) -> Mask:
    """Return (steps,) True where a measured signal stops at its extreme during a motion.

    A signal that comes to rest slows down before; a saturated signal does not.
    """
    mask = np.zeros(len(values), bool)
    change = np.abs(np.diff(values))
    moves = change[change > 0] if (change > 0).any() else np.zeros(1)
    least = max(ARRIVES * np.median(moves), STEPS * moves.min())
    for extreme in (values.max(), values.min()):
        ends = np.flatnonzero(np.diff(np.r_[0, values == extreme, 0]))
        for begin, end in zip(ends[::2], ends[1::2], strict=True):
            arrives = change[max(begin - 2, 0) : begin].max(initial=0.0)
            # One step of an encoder may be exactly that share of the usual change of four steps.
            if end - begin >= STAYS and arrives > least * (1.0 + SAME_SINGLE):
                mask[begin:end] = True
    return mask


def resampled(
    time: Floats | None, sample_time: float | None, values: dict[str, Floats], breaks: Mask | None
) -> EvenLog:
    """Return signals (rows,) at even times, in the longest part without a long gap.

    Args:
        time: time stamps [s] of the rows; None: rows are ``sample_time`` apart.
        sample_time: [s]; None: it is found from the time stamps.
        values: the signals by name.
        breaks: (rows,) True where an unknown number of samples is missing before a row.

    Raises:
        ValueError: there is no time; stamps decrease; too few samples are left.
    """
    rows = len(next(iter(values.values())))
    broken = np.zeros(rows, bool) if breaks is None else breaks
    notes: list[str] = []
    if time is None:
        if sample_time is None:
            raise ValueError("must have a time")
        part = _longest(sample_time * np.arange(rows, dtype=float), np.flatnonzero(broken), notes)
        values = {name: value[part] for name, value in values.items()}
        return EvenLog(sample_time, values, np.ones(part.stop - part.start, bool), notes)
    time = time - time[0]  # seconds since 1970 would leave few digits for a period
    distance = np.diff(time)
    if (falls := np.flatnonzero(distance < 0)).size:
        raise ValueError(f"its time must not fall (does after sample {falls[0] + 1})")
    if not (distance > 0).any():
        raise ValueError("its time does not advance: check the column and its unit")
    twice = np.append([False], distance == 0)
    usual = float(np.median(distance[distance > 0]))
    if twice.mean() > SHARED and any(np.diff(x)[twice[1:]].any() for x in values.values()):
        mean = _shared(time[~twice], np.flatnonzero(~twice), usual)
        log = resampled(None, sample_time or mean, values, broken)
        of = f"{rows / (rows - twice.sum()):.3g} samples share a time stamp each"
        message = f"{of}; the sample time is {log.sample_time:g} s, that of their mean"
        return log._replace(notes=[message, *log.notes])
    if twice.any():
        notes.append(f"{twice.sum()} samples have the time of the one before, and are left out")
    time, broken = time[~twice], broken[~twice]
    place = _places(time, sample_time or usual)
    cuts = np.append([False], np.diff(place) > FILLED + 1) | broken
    part = _longest(time, np.flatnonzero(cuts), notes)
    time, place = time[part], place[part] - place[part.start]
    values = {name: value[~twice][part] for name, value in values.items()}
    return _filled(time, sample_time or _period(place, time), place, values, notes)


def _shared(stamps: Floats, rows: Indices, usual: float) -> float:
    """Return the sample time [s] of a log whose coarse clock changes to ``stamps`` [s] at ``rows``.

    Raises:
        ValueError: there are too few stamps, or the samples are not even because some are missing.
    """
    stamps, first = stamps[1:], rows[1:].astype(float)  # the first may begin before the log
    if len(first) < FEWEST:
        few = f"{FEWEST + 1} different time stamps (got {len(first) + 1})"
        raise ValueError(f"must have at least {few}")
    period, start = np.polyfit(first, stamps, 1)
    off = np.abs(stamps - start - period * first)
    if off.max() > usual:
        unevenly = f"unevenly after {stamps[off.argmax()]:.6g} s: samples are missing there"
        raise ValueError(f"its time stamps are each shared by several samples, {unevenly}")
    return _period(first, stamps)


def _places(time: Floats, period: float) -> Floats:
    """Return for each time stamp (rows,) the number of its sample on an even clock, from 0.

    The clock is corrected by a share of its difference from each stamp, so that neither jitter nor
    a slightly wrong ``period`` leads to a miscount. A gap is a whole number of periods.
    """
    places, now, clock = [0.0], 0.0, float(time[0])
    for stamp in time[1:].tolist():
        steps = max(round((stamp - clock) / period), 1)
        now, clock = now + steps, clock + steps * period
        clock += FOLLOWS * (stamp - clock)
        places.append(now)
    return np.array(places)


def _period(place: Floats, time: Floats) -> float:
    """Return the sample time with the fewest digits that agrees with the time stamps.

    It may differ from the slope of a line through the stamps by three standard errors, or by a
    hundredth of a sample over the log: controls run every 0.5 ms, and not every 0.499999988 ms.
    """
    period, start = np.polyfit(place, time, 1)
    off = time - start - period * place
    error = np.sqrt(np.mean(off**2) / len(time)) / np.std(place)
    within = max(3.0 * error, 0.01 * period / len(time))
    shorter = (float(f"{period:.{digits}g}") for digits in range(1, 9))
    return next((one for one in shorter if abs(one - period) <= within), float(f"{period:.9g}"))


def _filled(
    time: Floats, period: float, place: Floats, values: dict[str, Floats], notes: list[str]
) -> EvenLog:
    """Return the signals at all samples; missing ones are interpolated, of ``HELD`` repeated."""
    start = float(np.mean(time - period * place))  # of the clock, from all stamps
    off = (time - start) / period - place
    tremble = float(np.sqrt(np.mean(off**2)))
    if tremble > TREMBLE:
        jitter = f"time stamps jitter by {100 * tremble:.2g} % of the sample time (rms)"
        notes.append(f"{jitter}; the signals are interpolated to even times")
    where = (time - start) / period if tremble > TREMBLE else place
    steps = np.arange(int(place[-1]) + 1)
    recorded = np.zeros(len(steps), bool)
    recorded[place.astype(int)] = True
    before = np.searchsorted(place, steps, side="right") - 1
    filled = {
        name: value[before] if name in HELD else np.interp(steps, where, value)
        for name, value in values.items()
    }
    if missing := int((~recorded).sum()):
        notes.append(f"{missing} of {len(steps)} samples are missing")
    return EvenLog(period, filled, recorded, notes)


def _longest(time: Floats, cuts: Indices, notes: list[str]) -> slice:
    """Return the longest part between ``cuts`` (rows after a gap); ValueError: it is too short."""
    ends = [0, *cuts.tolist(), len(time)]
    parts = [slice(a, b) for a, b in pairwise(ends) if b > a]
    part = max(parts, key=lambda one: one.stop - one.start)
    if len(parts) > 1:
        begin, end = time[part.start], time[part.stop - 1]
        used = f"the longest part without a gap is used, {begin:.4g} to {end:.4g} s"
        notes.append(f"samples are missing in {len(parts) - 1} places; {used}")
    if part.stop - part.start < FEWEST:
        raise ValueError(f"a part without a gap must have at least {FEWEST} samples")
    return part
