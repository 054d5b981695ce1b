"""Decisions of the adaptive fuzzy controllers: how rules are judged, and what bounds a move.

JK04 is Jee & Koren 2004, JK95 Jee & Koren 1995. The functions compute with scalars of one axis;
``xp`` is explained in ``core.numbers``. Never imports JAX.
"""

from collections.abc import Sequence

from hfc_design.controllers.neighbours import Degrees, Neighbours
from hfc_design.core.numbers import Scalar, Truth, Xp, clipped
from hfc_design.core.records import TERMS, ZR

#: Actions or degrees that differ by less than this count as equal, and a rule with a degree of up
#: to this counts as not fired, so that rounding decides nothing.
ALIKE = 1e-4


def performance_index(before: int, now: int) -> int:
    """Return the performance index p(k) of rules of term ``before`` if the error is in ``now``.

    Error terms are -3 to 3. JK04 eq. 24 and 25 with two exceptions of Table 2: the index is 0 from
    E_3 or E_-3 to E_0, and for the rules of E_0.
    """
    if before == 0 or (abs(before) == 3 and now == 0):
        return 0
    fall = before - now if before > 0 else now - before  # by how many terms
    return (fall - 2) // 2 if fall % 2 == 0 else (fall - 1) // 2


#: JK04 Table 2: performance indices [term of e(k-1)][term of e(k)], both from NL to PL.
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
    """Return ``highest_term`` of two neighbours; ZR if both degrees are 0."""
    lower, upper = in_error.first - ZR, in_error.first - (ZR - 1)
    below: Scalar = in_error.values[0]
    above: Scalar = in_error.values[1]
    beyond = lower >= 0  # the lower term is nearer ZR
    near, far = xp.where(beyond, lower, upper), xp.where(beyond, upper, lower)
    in_near, in_far = xp.where(beyond, below, above), xp.where(beyond, above, below)
    counts = (near == 0) | (in_near > ALIKE)
    farther = in_far > xp.where(counts, in_near, 0.0) + ALIKE
    return xp.where(farther, far, xp.where(counts, near, 0))


def performance_indices(xp: Xp, place: Scalar) -> Sequence[Scalar]:
    """Return p(k) of the rules of each error term (7,) if the error is in ``place`` (-3 to 3)."""
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

    ``error`` is e(k-1), ``index`` p(k), ``excess`` the rule's singleton less u_0(k-1). In cases I
    and IV (error x index > 0) the action was too large, and rules with excess >= 0 are to blame;
    in cases II and III it was too small, and rules with excess <= 0 are to blame.
    """
    return xp.where(error * index > 0.0, -excess, excess) <= ALIKE


def blamed_soflc(xp: Xp, error: Scalar, index: Scalar, excess: Scalar) -> Truth:
    """True if JK95 narrows a rule: excess > 0, or, in case III (e < 0, p > 0), excess <= 0.

    The arguments are those of ``blamed_aflc``. JK04 differs in case II (e > 0, p < 0), in which it
    blames the opposite rules, and in cases I and IV for a singleton that equals the overall action.
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
    """Return a joint (right edge of the lower term, left edge of the upper term) after a sample.

    Each of the two terms is narrowed by ``steps`` (2,) times ``size``. Both edges stay ``between``
    the centres of the terms (JK04 section 4.1). The terms overlap by at least ``overlap``: closer
    edges are set to half of ``overlap`` on either side of their mean. Otherwise an error in a gap
    would have no command, and the command would almost jump across a narrow overlap. The papers
    print no such limit.
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
