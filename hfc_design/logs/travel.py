"""Motions that no machine makes: the unit of a column is another one than was said."""

import numpy as np

from hfc_design.core.numbers import Floats
from hfc_design.core.quantities import number
from hfc_design.logs.columns import Column, how, millimetres_of
from plants import Drive

#: Of lengths and angles the least travel, and the largest mean speed over a log. An atom is 1e-10 m
#: wide, trains reach 170 m/s and the smallest turbines 1e5 rad/s. No guess of the machine is in
#: them, so that no log of a real one is refused.
PLAUSIBLE = {"m": (1e-10, 1e3), "rad": (1e-10, 1e6)}


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
