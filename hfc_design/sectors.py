"""Sectors of a fuzzy rule table: the gains K_1 and K_2 that confine its output (JK04 section 3).

The command is u(e, de) = u_1(e) + u_2(e, de) with u_1(e) = u(e, 0). K_1 bounds u_1/e, K_2 bounds
u_2/de. JK read both at the centres of the terms (eq. 13, 14), which is exact only where every
edge meets the neighbour's centre. ``true_sectors`` takes the edges as they are.
"""

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike, NDArray

from hfc_design.records import UserError

Floats = NDArray[np.float64]
MIDDLE = 3  # the term around zero, of seven
TERMS = 7
ROUNDING = 1e-12  # a level this much smaller than the others is a 0 that was rounded


class Triangle(NamedTuple):
    """A linguistic term of JK04 eq. 1; an edge ``None`` is infinite, and 1 from the centre on."""

    left: float | None
    centre: float
    right: float | None


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
    table = _checked_table(singletons)
    errors = _checked_centres("error", error_centres)
    changes = _checked_centres("change of error", change_centres)
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


def true_sectors(
    error_terms: Sequence[Triangle], change_terms: Sequence[Triangle], singletons: ArrayLike
) -> Sectors:
    """Infimum and supremum of u_1/e and u_2/de over all e and de, for terms with any edges.

    Product, centre average, 0 where no rule fires. The lower bounds are never above 0, since the
    command saturates. A command that jumps at 0 has an infinite gain. Memberships of the error
    enter u_2 as weights that sum to 1, so that u_2/de lies between its values where one error
    term rules alone: those rows are searched. If an edge passes the neighbour's centre that term
    never rules alone, and K_2 may come out too large, on the safe side.

    Raises:
        UserError: seven terms with ascending centres and left < centre < right are not given, or
            the singletons are not 7 x 7 finite numbers.
    """
    table = _checked_table(singletons)
    _check_terms("error", error_terms)
    _check_terms("change of error", change_terms)
    weights = np.array([membership(term, 0.0) for term in change_terms])
    outputs = table @ weights / (weights.sum() or 1.0)
    first = _gains(error_terms, outputs, 0.0)
    rows = [_gains(change_terms, row, output) for row, output in zip(table, outputs, strict=True)]
    return Sectors(*first, min(low for low, _ in rows), max(high for _, high in rows))


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
    table = _checked_table(singletons)
    i, s = _place(_checked_centres("error", error_centres), error)
    j, t = _place(_checked_centres("change of error", change_centres), change)
    (low, right), (up, across) = table[i : i + 2, j : j + 2]
    cross = (across - up - right + low) * s * t
    return float(low + (up - low) * s + (right - low) * t + cross)


def membership(term: Triangle, value: float) -> float:
    """Degree in [0, 1] to which ``value`` belongs to ``term`` (JK04 eq. 1)."""
    left, centre, right = term
    if value < centre:
        return 1.0 if left is None else max((value - left) / (centre - left), 0.0)
    return 1.0 if right is None else max((right - value) / (right - centre), 0.0)


def _gains(
    terms: Sequence[Triangle], values: Iterable[float], offset: float
) -> tuple[float, float]:
    """Infimum and supremum of (f(x) - offset)/x, f the centre average of ``values``.

    Between neighbouring edges and centres every membership is linear, so f - offset is a
    quotient p/q of two linear functions.
    """
    levels = np.fromiter(values, dtype=np.float64) - offset
    levels[np.abs(levels) < ROUNDING * np.abs(levels).max()] = 0.0
    finite = {x for term in terms for x in term if x is not None}
    found = [0.0]  # at infinity
    for ends in pairwise(sorted(finite | {0.0})):
        degrees = np.array([[membership(term, x) for term in terms] for x in ends])
        p, q = degrees @ levels, degrees.sum(axis=1)
        found += _ratio_piece(ends, p, q) if q.all() else _flat_piece(ends, p, q, offset)
    for x in (min(finite), max(finite)):  # and all the way from there to infinity
        degree = np.array([membership(term, x) for term in terms])
        found.append((degree @ levels / degree.sum() if degree.any() else -offset) / x)
    return float(min(found)), float(max(found))


def _flat_piece(ends: tuple[float, float], p: Floats, q: Floats, offset: float) -> list[float]:
    """Extremes of (f - offset)/x where no term reaches one end or both.

    f is 0 there, and constant inside: only terms that end together fire.
    """
    level = p.sum() / q.sum() if q.any() else -offset
    bare = [_quotient(-offset, x, ends) for x, weight in zip(ends, q, strict=True) if not weight]
    return [*bare, *(_quotient(level, x, ends) for x in ends)]


def _ratio_piece(ends: tuple[float, float], p: Floats, q: Floats) -> list[float]:
    """Extremes of p/(x q) with p, q, x linear in t, from 0 to 1 between the ends."""
    if 0.0 in ends:
        zero = ends.index(0.0)
        if p[zero] == 0.0:  # x divides out, what is left is monotone
            return [float(p[1 - zero] / (ends[1 - zero] * weight)) for weight in q]
    above, below, place = (Polynomial([u, v - u]) for u, v in (p, q, ends))
    product = place * below
    slope = above.deriv() * product - above * product.deriv()
    inner = [t for t in slope.roots().real if 0.0 < t < 1.0]
    outer = [_quotient(p[k] / q[k], ends[k], ends) for k in (0, 1)]
    return [*outer, *(float(above(t) / product(t)) for t in inner)]


def _quotient(level: float, x: float, ends: tuple[float, float]) -> float:
    """level/x; at x = 0 the limit from inside the piece."""
    if level == 0.0:
        return 0.0
    if x == 0.0:
        return math.copysign(math.inf, level if x == ends[0] else -level)
    return float(level / x)


def _checked_table(singletons: ArrayLike) -> Floats:
    try:
        table = np.asarray(singletons, dtype=np.float64)
    except (TypeError, ValueError):
        raise UserError("singletons: 7 rows of 7 numbers are needed") from None
    if table.shape != (TERMS, TERMS):
        raise UserError(f"singletons of shape {table.shape}: 7 rows of 7 are needed")
    wrong = np.argwhere(~np.isfinite(table))
    if len(wrong):
        row, column = wrong[0]
        raise UserError(
            f"singleton of row {row + 1}, column {column + 1} = {table[row, column]}: "
            "has to be a finite number"
        )
    return table


def _checked_centres(name: str, centres: Sequence[float]) -> Floats:
    values = np.asarray(centres, dtype=np.float64)
    if values.shape != (TERMS,) or not (np.isfinite(values).all() and (np.diff(values) > 0).all()):
        raise UserError(f"centres of the {name} = {list(centres)}: 7 ascending numbers are needed")
    if values[MIDDLE] != 0.0:
        raise UserError(f"middle centre of the {name} = {values[MIDDLE]:g}: has to be 0")
    return values


def _check_terms(name: str, terms: Sequence[Triangle]) -> None:
    _checked_centres(name, [term.centre for term in terms])
    for k, (left, centre, right) in enumerate(terms, 1):
        low = -math.inf if left is None else left
        high = math.inf if right is None else right
        if not low < centre < high:
            raise UserError(
                f"term {k} of the {name}: left {left}, centre {centre}, right {right} "
                "have to ascend"
            )


def _place(centres: Floats, value: float) -> tuple[int, float]:
    """The piece that ``value`` lies in, and where in it; outside, the nearest end."""
    k = int(np.clip(np.searchsorted(centres, value) - 1, 0, TERMS - 2))
    return k, float(np.clip((value - centres[k]) / (centres[k + 1] - centres[k]), 0.0, 1.0))
