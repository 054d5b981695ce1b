"""Sectors of a fuzzy rule table: the gains K_1 and K_2 that confine its output (JK04 section 3).

The command is u(e, de) = u_1(e) + u_2(e, de) with u_1(e) = u(e, 0). K_1 bounds u_1/e, K_2 bounds
u_2/de. JK04 reads both at the centres of the terms (eq. 13, 14). This is exact only if every edge
of a term lies on the centre of its neighbour. Otherwise the command rises in steps, and its gain
between the centres exceeds that at the centres: with table 3 the command at e = 19 BLU is already
32 units, the value at the centre 21. ``true_sectors`` takes the edges as they are, and ``bounded``
moves a table into its sectors. Terms (n, 3) are left edge, centre, right edge [BLU]; on the side
of an infinite edge the degree of a term is 1 (JK04 eq. 1). Never imports JAX.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from functools import reduce
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial

from hfc_design.core.numbers import Floats, RuleTable, Scalar, Triangles, Truth, Xp, clipped
from hfc_design.core.records import UserError

LARGEST = 1e9  # of any number here [BLU, unit], far beyond every drive
SMALLEST = 1e-9  # distance of two centres [BLU]
ROUNDING = 1e-12  # a level this much smaller than the others is a 0 that was rounded
DIGITS = 9  # decimals to which edges [BLU] are rounded, so that no two are extremely close


class Sectors(NamedTuple):
    """Smallest and largest gain of u_1/e and of u_2/de [unit/BLU].

    The stability theorem asks for sectors [0, K]: both lower gains have to be at least 0.
    """

    k1_low: float
    k1: float
    k2_low: float
    k2: float


def sectors_at_centres(
    error_terms: Triangles, change_terms: Triangles, singletons: RuleTable
) -> Sectors:
    """Return sectors by JK04 eq. 13 and 14, for any table [unit] (rows: error, columns: change).

    Raises:
        UserError: as ``true_sectors``, or an input has no middle term on 0.
    """
    table, *_ = _checked(error_terms, change_terms, singletons)
    inputs = {"error": error_terms, "change of error": change_terms}
    for name, terms in inputs.items():
        if not centred(terms):
            centre = terms[middle(terms)][1]
            raise UserError(f"middle centre of the {name} = {centre:g}: must be 0")
    row, column = middle(error_terms), middle(change_terms)
    errors: Floats = np.delete(np.array(error_terms)[:, 1], row)
    changes: Floats = np.delete(np.array(change_terms)[:, 1], column)
    first = np.delete(table[:, column], row) / errors
    second = np.delete(table - table[:, [column]], column, axis=1) / changes
    bounds = (first.min(), first.max(), second.min(), second.max())
    return Sectors(*(float(bound) for bound in bounds))


def true_sectors(error_terms: Triangles, change_terms: Triangles, singletons: RuleTable) -> Sectors:
    """Return infimum and supremum of u_1/e and u_2/de over all e and de, for terms with any edges.

    The command is a centre average of products, and 0 where no rule fires (also where two terms
    only touch). The lower bounds are never above 0, since the command saturates. A command that
    jumps at 0 has an infinite gain. Memberships of the error are weights in u_2 that sum to 1, so
    u_2/de lies between its values where a single error term is active: only those rows are
    searched. A term whose centre is beyond a neighbour's edge is never active alone; then K_2 may
    be too large, on the safe side.

    Raises:
        UserError: a number is too large, the centres do not ascend, or not left < centre < right.
    """
    table, error_terms, change_terms = _checked(error_terms, change_terms, singletons)
    weights = np.array([membership(term, 0.0) for term in change_terms])
    outputs = table @ weights / (weights.sum() or 1.0)
    first = _gains(error_terms, outputs, 0.0)
    rows = [_gains(change_terms, row, output) for row, output in zip(table, outputs, strict=True)]
    return Sectors(*first, min(low for low, _ in rows), max(high for _, high in rows))


def middle(terms: Triangles) -> int:
    """Return the index of the middle term; of an even number that of the upper of two."""
    return len(terms) // 2


def centred(terms: Triangles) -> bool:
    """Whether there is a middle term, centred on 0."""
    return len(terms) % 2 == 1 and bool(terms[middle(terms)][1] == 0.0)


def membership(term: Sequence[float], value: float) -> float:
    """Return the degree, 0 to 1, to which ``value`` belongs to ``term`` (JK04 eq. 1)."""
    left, centre, right = term
    if value < centre:
        return 1.0 if math.isinf(left) else max((value - left) / (centre - left), 0.0)
    return 1.0 if math.isinf(right) else max((right - value) / (right - centre), 0.0)


def _gains(terms: Triangles, values: Iterable[float], offset: float) -> tuple[float, float]:
    """Return infimum and supremum of (f(x) - offset)/x; f is the centre average of ``values``.

    Between neighbouring edges and centres every membership is linear, so f - offset is a
    quotient p/q of two linear functions.
    """
    levels = np.fromiter(values, dtype=np.float64) - offset
    levels[np.abs(levels) < ROUNDING * np.abs(levels).max()] = 0.0
    finite = {x for term in terms for x in term if math.isfinite(x)}
    ratios = [0.0]  # at infinity
    for ends in pairwise(sorted(finite | {0.0})):
        degrees = np.array([[membership(term, x) for term in terms] for x in ends])
        p, q = degrees @ levels, degrees.sum(axis=1)
        p[np.abs(p) <= ROUNDING * (degrees @ np.abs(levels))] = 0.0  # at x = 0 it would be infinite
        ratios += _ratio_piece(ends, p, q) if q.all() else _flat_piece(ends, p, q, offset)
    for x in (min(finite), max(finite)):  # and all the way from there to infinity
        degree = np.array([membership(term, x) for term in terms])
        ratios.append((degree @ levels / degree.sum() if degree.any() else -offset) / x)
    return float(min(ratios)), float(max(ratios))


def _flat_piece(ends: tuple[float, float], p: Floats, q: Floats, offset: float) -> list[float]:
    """Return the extremes of (f - offset)/x in a piece of which no term reaches an end, or both.

    At such an end f is 0; inside it is constant, because only terms that end together fire.
    """
    level = p.sum() / q.sum() if q.any() else -offset
    bare = [_quotient(-offset, x, ends) for x, weight in zip(ends, q, strict=True) if not weight]
    return [*bare, *(_quotient(level, x, ends) for x in ends)]


def _ratio_piece(ends: tuple[float, float], p: Floats, q: Floats) -> list[float]:
    """Return the extremes of p/(x q); p, q and x are linear in t, which goes from 0 to 1."""
    if 0.0 in ends:
        zero = ends.index(0.0)
        if p[zero] == 0.0:  # x divides out, what is left is monotone
            return [float(p[1 - zero] / (ends[1 - zero] * weight)) for weight in q]
    above, weight, x = (Polynomial((u, v - u)) for u, v in (p, q, ends))
    places = [0.0, *stationary(above, weight * x, 1.0), 1.0]
    return [_quotient(float(above(t) / weight(t)), float(x(t)), ends) for t in places]


def stationary(numerator: Polynomial, denominator: Polynomial, end: float) -> list[float]:
    """Return every place between 0 and ``end`` where the quotient is stationary.

    Real parts of complex roots may be among them; one more place never spoils an extremum.
    """
    slope = numerator.deriv() * denominator - numerator * denominator.deriv()
    return [float(t) for t in slope.roots().real if 0.0 < t < end]


def _quotient(level: float, x: float, ends: tuple[float, float]) -> float:
    """Return level/x; at x = 0 the limit from inside the piece."""
    if level == 0.0:
        return 0.0
    if x == 0.0:
        return math.copysign(math.inf, level if x == ends[0] else -level)
    return float(level / x)


def _checked(
    error_terms: Triangles, change_terms: Triangles, singletons: RuleTable
) -> tuple[Floats, Triangles, Triangles]:
    """Return the checked table, and the checked terms with edges rounded to ``DIGITS``."""
    table = np.array(singletons, dtype=np.float64)
    wrong = np.argwhere(~(np.abs(table) <= LARGEST))
    if len(wrong):
        row, column = wrong[0]
        place = f"row {row + 1}, column {column + 1} = {table[row, column]}"
        raise UserError(f"singleton of {place}: must be between {-LARGEST:g} and {LARGEST:g}")
    inputs = {"error": error_terms, "change of error": change_terms}
    for name, terms in inputs.items():
        centres = np.array([term[1] for term in terms])
        if not ((np.abs(centres) <= LARGEST).all() and (np.diff(centres) >= SMALLEST).all()):
            raise UserError(f"centres of the {name} = {centres.tolist()}: must be ascending")
    rounded = []
    for name, terms in inputs.items():
        rounded.append([[round(x, DIGITS) for x in term] for term in terms])
        for k, (left, centre, right) in enumerate(rounded[-1], 1):
            huge = any(LARGEST < abs(x) < math.inf for x in (left, right))
            if huge or not left < centre < right:
                edges = f"left {left}, centre {centre}, right {right} must ascend within"
                raise UserError(f"term {k} of the {name}: {edges} {-LARGEST:g} and {LARGEST:g}")
    return table, rounded[0], rounded[1]


class Rectangle(NamedTuple):
    """The sectors in the stable range that the table may not leave (JK04 eq. 12-14)."""

    k1_max: Scalar  # 0 <= u_1 / e <= k1_max [units/BLU]
    k2_max: Scalar  # 0 <= u_2 / de <= k2_max [units/BLU]

    def k2(self, xp: Xp, slopes: Iterable[Scalar]) -> Scalar:
        """Return the largest K_2, whatever the ``slopes`` u_1 / e of the table are."""
        return self.k2_max


class Curve(NamedTuple):
    """Sectors whose largest K_2 depends on the K_1 of the table (JK04 fig. 4)."""

    k1_max: Scalar  # [units/BLU]
    k2_max: Scalar  # [units/BLU]
    points: Sequence[Sequence[Scalar]]  # (n, 2) K_1 rising, and the largest K_2 there

    def k2(self, xp: Xp, slopes: Iterable[Scalar]) -> Scalar:
        """Return the largest K_2 at the steepest of ``slopes``, linear between the points."""
        k1, k2 = xp.once(reduce(xp.maximum, slopes)), self.points[0][1]
        for (a, b), (c, d) in pairwise(self.points):
            k2 = k2 + (d - b) * clipped(xp, (k1 - a) / (c - a), 0.0, 1.0)
        return xp.once(xp.minimum(self.k2_max, k2))


def inner_edges(rights: Sequence[Scalar], lefts: Sequence[Scalar]) -> list[Scalar]:
    """Return for each term the edge of its neighbour on the side of the middle; 0 for the middle.

    From there outwards the singleton is the whole output, so there its slope is steepest.
    ``rights`` and ``lefts`` (n - 1) have for each two neighbours the right edge of the lower term
    and the left edge of the upper term.
    """
    half = (len(rights) + 1) // 2
    return [*lefts[:half], 0.0, *rights[half:]]


def bounded(
    xp: Xp,
    sectors: Rectangle | Curve,
    row_edges: Sequence[Scalar],
    column_edges: Sequence[Scalar],
    singletons: RuleTable,
    signs: RuleTable,
) -> Callable[[Scalar], Any]:
    """Return a function of a row's number: the row, moved to the nearest values in ``sectors``.

    Between the points of ``inner_edges`` the output of the product rule stays below the chord. The
    column de = ZR makes u_1, the other columns minus this one make u_2 (JK04 eq. 13, 14). No
    singleton gets another sign than in ``signs``, unless its sector demands it; where that is 0 it
    may get the sign of its row. The row e = ZR has no bound. ``xp`` as in ``core.numbers``.
    """
    zero, none = len(row_edges) // 2, len(column_edges) // 2  # terms of no error, of no change
    rows = range(len(row_edges))

    def resting(i: Scalar, edge: Scalar) -> Scalar:
        most = sectors.k1_max * edge
        if isinstance(i, int):
            low, high = (0.0, most) if i > zero else (most, 0.0)
        else:
            low, high = xp.minimum(most, 0.0), xp.maximum(most, 0.0)
        return xp.once(clipped(xp, singletons[i][none], low, high))

    at_rest = xp.stored(xp.along(resting, rows, xp.table(row_edges)))
    k2_max = sectors.k2(xp, (at_rest[i] / row_edges[i] for i in rows if i != zero))
    reaches = [k2_max * edge for edge in column_edges]
    lows = xp.table([reaches[j] if j < none else 0.0 for j in range(len(reaches))])
    highs = xp.table([reaches[j] if j > none else 0.0 for j in range(len(reaches))])
    above = xp.table(
        [[sign >= 0.0 if i > zero else sign > 0.0 for sign in signs[i]] for i in range(len(signs))]
    )

    def row(i: Scalar) -> Any:
        base = at_rest[i]

        def bound(
            j: Scalar, singleton: Scalar, positive: Truth, low: Scalar, high: Scalar
        ) -> Scalar:
            if isinstance(j, int) and j == none:
                return base
            signed = xp.where(positive, xp.maximum(singleton, 0.0), xp.minimum(singleton, 0.0))
            return clipped(xp, signed, _off(base, low), _off(base, high))

        return xp.along(bound, range(len(lows)), singletons[i], above[i], lows, highs)

    return row


def _off(value: Scalar, by: Scalar) -> Scalar:
    """Return the sum; for the constant 0 the value itself, which costs a population no time."""
    return value if isinstance(by, float) and not by else value + by
