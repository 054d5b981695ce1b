"""Sectors of a fuzzy rule table: the gains K_1 and K_2 that confine its output (JK04 section 3).

The command is u(e, de) = u_1(e) + u_2(e, de) with u_1(e) = u(e, 0). K_1 bounds u_1/e, K_2 bounds
u_2/de. JK read both at the centres of the terms (eq. 13, 14), which is exact only where every
edge meets the neighbour's centre. ``hfc_design.true_sectors`` takes the edges as they are.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from hfc_design.core.records import UserError
from hfc_design.core.shapes import Floats

MIDDLE = 3  # the term around zero, of seven
TERMS = 7
LARGEST = 1e9  # of any number here [BLU, unit], far beyond every drive
SMALLEST = 1e-9  # distance of two centres [BLU]


class Sectors(NamedTuple):
    """Smallest and largest gain of u_1/e and of u_2/de [unit/BLU].

    The stability theorem asks for sectors [0, K]: both lower gains have to be at least 0.
    """

    k1_low: float
    k1: float
    k2_low: float
    k2: float

    @property
    def confined(self) -> bool:
        """Whether no gain is negative, as the theorem asks."""
        return self.k1_low >= 0.0 and self.k2_low >= 0.0


def sectors_at_centres(
    error_centres: Sequence[float], change_centres: Sequence[float], singletons: ArrayLike
) -> Sectors:
    """JK04 eq. 13 and 14, for any 7 x 7 table of singletons (rows error, columns change).

    Centres in BLU, ascending, the middle one 0; singletons in units.

    Raises:
        UserError: centres or singletons are not of that kind.
    """
    table = checked_table(singletons)
    errors = checked_centres("error", error_centres)
    changes = checked_centres("change of error", change_centres)
    kept = np.arange(TERMS) != MIDDLE
    first = table[kept, MIDDLE] / errors[kept]
    second = (table - table[:, [MIDDLE]])[:, kept] / changes[kept]
    bounds = (first.min(), first.max(), second.min(), second.max())
    return Sectors(*(float(bound) for bound in bounds))


def k2_of_rule_base_1(small: float, medium: float, large: float, spacing: float) -> float:
    """K_2 [unit/BLU] of rule base I from its positive centroids U_1, U_2, U_3 (JK04 eq. 23).

    ``spacing`` is the distance beta of the centres of the change of error [BLU], evenly spaced.
    """
    if 3.0 * medium - 2.0 * small - large >= 0.0:
        steepest, ahead = (medium - small) / spacing, 3.0 * medium - 4.0 * small
    else:
        steepest = (large - medium) / (2.0 * spacing)
        ahead = 3.0 * large - 3.0 * medium - 2.0 * small
    return steepest if ahead >= 0.0 else small / (3.0 * spacing)


def bilinear(
    error_centres: Sequence[float],
    change_centres: Sequence[float],
    singletons: ArrayLike,
    error: float,
    change: float,
) -> float:
    """The command where every edge meets the neighbour's centre: JK04 eq. 7 with its cross term.

    With s, t in [0, 1] the place between two centres of e and of de, the four rules fire at
    (1 - s)(1 - t), s(1 - t), (1 - s)t, st. Printed are the terms without s t, which alone give
    U_{i+1,j} + U_{i,j+1} - U_{i,j} instead of U_{i+1,j+1} at s = t = 1.

    Raises:
        UserError: as ``sectors_at_centres``.
    """
    table = checked_table(singletons)
    i, s = _place(checked_centres("error", error_centres), error)
    j, t = _place(checked_centres("change of error", change_centres), change)
    (low, right), (up, across) = table[i : i + 2, j : j + 2]
    cross = (across - up - right + low) * s * t
    return float(low + (up - low) * s + (right - low) * t + cross)


def checked_table(singletons: ArrayLike) -> Floats:
    """7 x 7 numbers, or UserError."""
    try:
        table = np.asarray(singletons, dtype=np.float64)
    except (TypeError, ValueError):
        raise UserError("singletons: 7 rows of 7 numbers are needed") from None
    if table.shape != (TERMS, TERMS):
        raise UserError(f"singletons of shape {table.shape}: 7 rows of 7 are needed")
    wrong = np.argwhere(~(np.abs(table) <= LARGEST))
    if len(wrong):
        row, column = wrong[0]
        raise UserError(
            f"singleton of row {row + 1}, column {column + 1} = {table[row, column]}: "
            f"has to lie within {-LARGEST:g} and {LARGEST:g}"
        )
    return table


def checked_centres(name: str, centres: Sequence[float]) -> Floats:
    """Seven ascending centres, the middle one 0, or UserError."""
    values = np.asarray(centres, dtype=np.float64)
    good = values.shape == (TERMS,) and (np.abs(values) <= LARGEST).all()
    if not (good and (np.diff(values) >= SMALLEST).all()):
        raise UserError(f"centres of the {name} = {list(centres)}: 7 ascending numbers are needed")
    if values[MIDDLE] != 0.0:
        raise UserError(f"middle centre of the {name} = {values[MIDDLE]:g}: has to be 0")
    return values


def _place(centres: Floats, value: float) -> tuple[int, float]:
    """The piece that ``value`` lies in, and where in it; outside, the nearest end."""
    k = int(np.clip(np.searchsorted(centres, value) - 1, 0, TERMS - 2))
    return k, float(np.clip((value - centres[k]) / (centres[k + 1] - centres[k]), 0.0, 1.0))
