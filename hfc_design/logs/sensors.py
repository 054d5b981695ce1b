"""Properties of a sensor found in its signal: step, noise, wrong samples, turns, a wrong unit."""

from collections.abc import Mapping

import numpy as np

from hfc_design.core.numbers import SAME, Floats, Mask
from hfc_design.core.quantities import number
from hfc_design.logs.columns import Column, column_hint, converted, scale
from plants import Drive

#: Largest multiple of the smallest difference that counts as one step; share of the values that
#: must be within ``ROUNDED`` steps of whole steps; least visible noise, as a share of a step.
SINGLE, MOST, ROUNDED, SEEN = 1.6, 0.99, 0.26, 0.1
#: Least deviation of a wrong sample, as a multiple of the ``USUAL`` quantile of all bends.
WRONG, USUAL = 20.0, 0.97
#: Share of the samples, the slowest ones, that is searched for noise: where an axis is fast, jitter
#: of the time stamps looks like noise of its position.
SLOW = 0.2
#: Least travel of lengths and angles, and largest mean speed over a log. An atom is 1e-10 m
#: wide, trains reach 170 m/s and the smallest turbines 1e5 rad/s. The limits assume nothing about
#: the machine, so that no log of a real machine is refused.
PLAUSIBLE = {"m": (1e-10, 1e3), "rad": (1e-10, 1e6)}
#: A rotary position jumps back by a whole turn; between jumps it moves by no more than this
#: share of a turn in a sample, since otherwise its direction is unknown.
CLEAR = 0.25
#: Most consecutive missing samples that are interpolated; at longer gaps the log is cut.
FILLED = 5


def encoder_step(values: Floats) -> float | None:
    """Return the step of an encoder if its ``values`` are whole steps but for rounding, or None."""
    gaps = np.diff(np.unique(np.round(values, 15)))
    gaps = gaps[gaps > 1e-12 * max(np.abs(values).max(), 1e-300)]
    if not len(gaps):
        return None
    places = np.append(0.0, np.cumsum(gaps))
    least = np.quantile(gaps, 1.0 - MOST, method="lower")
    step = float(gaps[gaps <= SINGLE * least].mean())
    # First short gaps, so that no long one is miscounted; then sums of gaps, past wrong values.
    for width, every in (*((4.0**k, 1) for k in range(1, 12)), (np.inf, 3), (np.inf, 7)):
        some = np.diff(places[::every])
        some = some[some <= width * step]
        step = float(some.sum() / np.round(some / step).sum()) if some.size else step
    counts = np.round(places / step)
    step, start = np.polyfit(counts, places, 1).tolist()
    off = np.quantile(np.abs(places - start - step * counts), MOST)
    ramp = np.ptp(np.round(np.diff(values) / step)) == 0.0
    return None if ramp or off > ROUNDED * step else float(f"{step:.4g}")


def without_outliers(values: Floats) -> tuple[Floats, Mask]:
    """Return ``values`` (steps,) with wrong samples interpolated, and the mask of these samples.

    A wrong sample is far off its neighbours, and the signal bends back at both by half as much.
    """
    bend, changes = np.diff(values, 2), np.abs(np.diff(values))
    least = changes[changes > 0].min(initial=np.inf)
    usual = max(float(np.quantile(np.abs(bend), USUAL)), least)
    back = np.pad(bend, 1)
    both = np.maximum(back[:-2] * np.sign(bend), back[2:] * np.sign(bend))
    wrong = (0.5 * np.abs(bend) > WRONG * usual) & (both < -0.25 * np.abs(bend))
    wrong, steps = np.pad(wrong, 1), np.arange(len(values))
    return np.interp(steps, steps[~wrong], values[~wrong]) if wrong.any() else values, wrong


def noise_level(off: Floats, place: Floats, step: float | None) -> float | None:
    """Return the standard deviation of white noise in a residual (steps,) ``off``; None: invisible.

    Only samples count in which the axis with the position ``place`` (steps,) is slow, and in which
    the replay counts (``off`` is not 0). Second differences isolate white noise: they have six
    times its variance. The largest ones, at reversals, are left out. The variance step^2 / 12 that
    comes from rounding to a ``step`` is subtracted.
    """
    counts = (off[2:] != 0) & (off[1:-1] != 0) & (off[:-2] != 0)
    speed = np.abs(place[2:] - place[:-2])
    slow = speed <= np.quantile(speed, SLOW) + SAME * speed.max() if counts.any() else counts
    bend = np.diff(off, 2)[counts & slow]
    if not bend.size:
        return None
    usual = max(float(np.median(np.abs(bend))) / 0.6745, step or 0.0)  # of a normal distribution
    size = float(np.mean(bend[np.abs(bend) <= 4.0 * usual] ** 2))
    left = size / 6.0 - (step or 0.0) ** 2 / 12.0
    least = SEEN * step if step else 1e-30
    return float(f"{np.sqrt(left):.2g}") if left > least**2 else None


def unwrap(
    values: dict[str, Floats], places: Mapping[str, Column], drive: Drive, apart: Floats
) -> list[str]:
    """Continue positions that wrap around in ``values``, in place; return notes on them.

    Args:
        values: signals (rows,) by name, in the drive's units; they are changed.
        places: the positions among these signals, with the moduli that a user has given.
        drive: drive of the signals; without a modulus, a position that is an angle wraps at a turn.
        apart: (rows - 1,) samples from a row to the next; a short gap is crossed at constant speed.

    Raises:
        ValueError: the position that is fed back jumps by no turn, or goes beyond its modulus.
    """
    seen, unit = drive.seen[0], drive.units["error"]
    notes, crossed = list[str](), (apart > 1) & (apart <= FILLED + 1)
    for name in sorted(places, key=seen.__ne__):  # first the one fed back, which cannot jump
        if not (turn := _turn(places[name], drive)):
            continue
        moves = np.diff(values[name])
        if np.ptp(values[name]) > turn * (1.0 + CLEAR):  # it counts turns, or is no angle
            if places[name].modulus:
                raise ValueError(f"the {name} goes beyond its modulus, {turn:.6g} {unit}")
            continue
        before = np.append(0.0, moves - turn * np.round(moves / turn))[:-1]
        likely = np.where(crossed, before * np.where(crossed, apart, 0.0), 0.0)
        turns = np.round((likely - moves) / turn)
        off = np.abs(moves + turn * turns - likely) * (apart <= FILLED + 1)
        if not turns.any():
            continue
        if off.max() > CLEAR * turn:
            if name != seen:
                continue
            first = int((off > CLEAR * turn).argmax())
            jump = f"jumps by {moves[first]:.3g} {unit} after sample {first + 1}"
            which = "is it a rotation beyond one turn, or a wrong sample?"
            raise ValueError(f"the {name} {jump}: {which}")
        whole = values[name] + turn * np.append([0.0], np.cumsum(turns))
        if name == "reference" and not notes:  # a step of a turn is none
            lead = turn * np.round((whole - values[seen])[0] / turn)
            if np.abs(whole - lead - values[seen]).max() > 0.5 * turn:
                continue
        values[name] = whole
        jumps = f"{np.count_nonzero(turns)} jumps of {turn:.6g} {unit}"
        notes.append(f"{name} wraps around ({jumps}), and is unwrapped")
    if notes and "reference" in values and (turn := _turn(places["reference"], drive)):
        values["reference"] -= turn * np.round((values["reference"][0] - values[seen][0]) / turn)
    return notes


def _turn(one: Column, drive: Drive) -> float | None:
    """Return where a position wraps around, in the drive's unit; None: it does not."""
    if one.modulus:
        return abs(scale(one, drive)) * one.modulus
    try:
        return number("1 turn", drive.units["error"])
    except ValueError:
        return None


def check_travel(one: Column, values: Floats, drive: Drive, duration: float) -> None:
    """Check that a column in its unit is a possible motion of a machine; ValueError: it is not.

    Args:
        one: the column with the assumed unit.
        values: (steps,) of the column, in the unit of the drive's position.
        drive: drive of the position.
        duration: duration of the log [s].
    """
    unit = drive.units["error"]
    for base, (least, fastest) in PLAUSIBLE.items():
        try:
            size = converted(f"1 {unit}", base, drive)
        except ValueError:
            continue
        gone, most = size * float(np.ptp(values)), fastest * duration
        if gone > most or (one.name == drive.seen[0] and gone < least):
            moves = f"moves {gone:.3g} {base} in {duration:.3g} s"
            plausible = f"{least:g} to {most:.3g} {base} are plausible"
            what = f"column {one.column} in {one.unit}: the {one.name} {moves}, but {plausible}"
            raise ValueError(f"{what}; check the unit and {column_hint(one.name)}")
