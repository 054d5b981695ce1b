"""Decisions of the adaptive fuzzy controllers: how rules are judged, and what bounds a move.

JK04 is Jee & Koren 2004, JK95 Jee & Koren 1995. Written for one axis in scalars; ``xp`` as in
``core.numbers``. Never imports JAX.
"""

from collections.abc import Sequence

from hfc_design.controllers.neighbours import Degrees, Neighbours
from hfc_design.core.numbers import Scalar, Truth, Xp, clipped
from hfc_design.core.records import TERMS, ZR

#: Actions or degrees that differ by less count as equal, and a rule with smaller degrees has not
#: fired, so that rounding decides nothing.
ALIKE = 1e-4


def performance_index(before: int, now: int) -> int:
    """Performance index p(k) of a rule of error term E_before, the error now in E_now (-3 to 3).

    JK04 eq. 24 and 25 with the exceptions of Table 2: from E_3 to E_0 is good, and rules of E_0
    are not judged.
    """
    if before == 0 or (abs(before) == 3 and now == 0):
        return 0
    fall = before - now if before > 0 else now - before  # in terms, towards the other side
    return (fall - 2) // 2 if fall % 2 == 0 else (fall - 1) // 2


#: JK04 Table 2, [E(k-1)][E(k)], both NL to PL.
PERFORMANCE = tuple(
    tuple(float(performance_index(before, now)) for now in range(-3, 4)) for before in range(-3, 4)
)

#: ``PERFORMANCE`` as whole numbers.
INDICES = tuple(tuple(map(int, row)) for row in PERFORMANCE)


def highest_term(xp: Xp, in_error: Degrees) -> Scalar:
    """Return the term, -3 to 3, that an error with these degrees (7) is assigned to.

    It is the term of the highest degree; of two equal ones, the term nearer ZR.
    """
    if isinstance(in_error, Neighbours):
        return _higher_term(xp, in_error)
    highest: Scalar = in_error[ZR]
    place: Scalar = 0.0 * highest
    for k in (ZR - 1, ZR + 1, ZR - 2, ZR + 2, ZR - 3, ZR + 3):
        higher = in_error[k] > highest + ALIKE
        highest = xp.where(higher, in_error[k], highest)
        place = xp.where(higher, k - ZR, place)
    return place


def _higher_term(xp: Xp, in_error: Neighbours) -> Scalar:
    """Return the highest term of two neighbours; ZR if both degrees are zero."""
    lower, upper = in_error.first - ZR, in_error.first - (ZR - 1)
    below: Scalar = in_error.values[0]
    above: Scalar = in_error.values[1]
    beyond = lower >= 0  # the lower one is nearer ZR
    near, far = xp.where(beyond, lower, upper), xp.where(beyond, upper, lower)
    in_near, in_far = xp.where(beyond, below, above), xp.where(beyond, above, below)
    counts = (near == 0) | (in_near > ALIKE)
    farther = in_far > xp.where(counts, in_near, 0.0) + ALIKE
    return xp.where(farther, far, xp.where(counts, near, 0))


def performance_indices(xp: Xp, place: Scalar) -> Sequence[Scalar]:
    """Indices p(k) of the rules of each error term, the error being assigned to ``place``."""
    if xp.sparse:
        now = xp.whole(clipped(xp, place + ZR, 0, TERMS - 1))
        return xp.along(lambda row: row[now], xp.table(INDICES))
    indices = []
    for row in PERFORMANCE:
        index = 0.0 * place
        for k, value in enumerate(row):
            index = xp.where(place == k - ZR, value, index)
        indices.append(index)
    return indices


def blamed_aflc(xp: Xp, error: Scalar, index: Scalar, excess: Scalar) -> Truth:
    """True if a rule pulled the action the wrong way (JK04 Appendix B).

    ``error`` is e(k-1), ``index`` p(k), ``excess`` the rule's singleton less u_0(k-1). In
    cases I and IV the action was too large, and rules with excess >= 0 are to blame; in cases II
    and III it was too small, and rules with excess <= 0 are.
    """
    return xp.where(error * index > 0.0, -excess, excess) <= ALIKE


def blamed_soflc(xp: Xp, error: Scalar, index: Scalar, excess: Scalar) -> Truth:
    """True if a rule is contracted, as JK95 prints it: excess > 0, in its third case <= 0.

    Differs from JK04 for e > 0 with p < 0, where the opposite rules are contracted, and in the
    first and fourth case where a singleton equals the overall action.
    """
    third = xp.where(error < 0.0, index, 0.0) > 0.0
    return (excess <= ALIKE) == third


def joined(
    xp: Xp,
    between: Sequence[Scalar],
    joint: Sequence[Scalar],
    steps: Sequence[Scalar],
    size: Scalar,
    overlap: Scalar,
) -> tuple[Scalar, Scalar]:
    """Return a joint (right edge of the lower term, left edge of the upper one) after a sample.

    Each of the two terms is narrowed by its ``steps`` of ``size``. Both edges stay ``between`` the
    centres of the terms (JK04 section 4.1), and they overlap by at least ``overlap``: edges that
    would come closer are set half of it on either side of their mean. An error in a gap would
    have no command, and across a narrow overlap the command almost jumps. The papers print no such
    limit.
    """
    lower, upper = between
    right = clipped(xp, joint[0] - size * steps[0], lower, upper)
    left = clipped(xp, joint[1] + size * steps[1], lower, upper)
    half = 0.5 * overlap
    middle = clipped(xp, 0.5 * (left + right), lower + half, upper - half)
    tight = right - left < overlap
    return (
        xp.once(xp.where(tight, middle + half, right)),
        xp.once(xp.where(tight, middle - half, left)),
    )
