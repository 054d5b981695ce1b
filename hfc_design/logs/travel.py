"""Motions that no machine makes: the unit of a column is another one than was said."""

from collections.abc import Sequence

import numpy as np

from hfc_design.core.numbers import SAME_SINGLE, Floats
from hfc_design.core.quantities import number
from hfc_design.logs.columns import Column, how, millimetres_of
from plants import Drive

#: Of lengths and angles the least travel, and the largest mean speed over a log. An atom is 1e-10 m
#: wide, trains reach 170 m/s and the smallest turbines 1e5 rad/s. No guess of the machine is in
#: them, so that no log of a real one is refused.
PLAUSIBLE = {"m": (1e-10, 1e3), "rad": (1e-10, 1e6)}


#: A place that goes round jumps back by a whole turn; between jumps it moves by no more than this
#: share of one in a sample, or nobody knows which way.
CLEAR = 0.25


def unwrapped(values: dict[str, Floats], places: Sequence[str], drive: Drive) -> list[str]:
    """Notes of what goes round in ``values``, which then goes on where it began again.

    Args:
        values: signals (rows,) by name, in the drive's units; changed.
        places: those that are places.
        drive: whose they are; one of lengths does not go round.

    Raises:
        ValueError: its position jumps, and not by a whole turn.
    """
    seen, unit = drive.seen[0], drive.units["error"]
    try:
        turn = number("1 turn", unit)
    except ValueError:
        return []
    notes, begun = list[str](), values.get(seen, np.zeros(1))[0]
    for name in sorted(places, key=seen.__ne__):  # the position first: only it cannot really jump
        jumps = np.diff(values[name])
        round_ = np.abs(jumps) > 0.5 * turn
        if np.ptp(values[name]) > turn * (1.0 + SAME_SINGLE) or not round_.any():
            continue
        turns = np.where(round_, -np.sign(jumps), 0.0)
        if np.abs(jumps + turn * turns).max() > CLEAR * turn:
            if name != seen:
                continue
            first = int(round_.argmax())
            raise ValueError(
                f"the {name} jumps by {jumps[first]:.3g} {unit} after sample {first + 1}: does it "
                "go round, or is a sample wrong?"
            )
        if name != "reference" or notes:
            values[name] = values[name] + turn * np.append([0.0], np.cumsum(turns))
            jumped = f"{round_.sum()} jumps of a whole turn"
            notes.append(f"{name} goes round ({jumped}), and is taken to go on")
    if notes and "reference" in values:
        values["reference"] -= turn * np.round((values["reference"][0] - begun) / turn)
    return notes


def check(one: Column, values: Floats, drive: Drive, duration: float) -> None:
    """ValueError: what a column with its unit says is no motion of a machine.

    Args:
        one: with the unit that was taken.
        values: (steps,) of it, in the unit of the drive's position.
        drive: whose position it is.
        duration: of the log [s].
    """
    unit = drive.units["error"]
    for base, (least, fastest) in PLAUSIBLE.items():
        try:
            size = number(f"1 {unit}", base, millimetres_of(drive))
        except ValueError:
            continue
        gone, most = size * float(np.ptp(values)), fastest * duration
        if gone > most or (one.name == drive.seen[0] and gone < least):
            raise ValueError(
                f"column {one.column} in {one.unit}: the {one.name} goes {gone:.3g} {base} in "
                f"{duration:.3g} s; plausible are {least:g} to {most:.3g} {base}: in which unit "
                f"is it? {how(one.name)}"
            )
