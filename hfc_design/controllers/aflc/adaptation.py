"""What the adaptive fuzzy controllers decide: which rules are judged how, and what bounds a move.

JK04 is Jee & Koren 2004, JK95 Jee & Koren 1995. Written for one axis in scalars; ``xp`` as in
``core.numbers``. Never imports JAX.
"""

from collections.abc import Sequence

from hfc_design.core.numbers import Degrees, Scalar, Triangles, Truth, Xp, clipped
from hfc_design.core.records import ZR

#: Two actions or two degrees that differ by less are the same, and a rule whose degrees are less
#: has not fired: rounding decides nothing.
ALIKE = 1e-4


def performance_index(before: int, now: int) -> int:
    """p(k) of a rule of the error term E_before when the error is now in E_now (-3 to 3).

    JK04 eq. 24 and 25 with the exceptions of Table 2: from E_3 to E_0 is good, and what a rule of
    E_0 did is not considered.
    """
    if before == 0 or (abs(before) == 3 and now == 0):
        return 0
    fall = before - now if before > 0 else now - before  # in terms, towards the other side
    return (fall - 2) // 2 if fall % 2 == 0 else (fall - 1) // 2


#: JK04 Table 2, [E(k-1)][E(k)], both NL to PL.
PERFORMANCE = tuple(
    tuple(float(performance_index(before, now)) for now in range(-3, 4)) for before in range(-3, 4)
)


def highest_term(xp: Xp, in_error: Degrees) -> Scalar:
    """The term for which an error of degrees (7) counts, -3 to 3.

    That of the highest degree, of two equal ones that nearer ZR.
    """
    highest, place = in_error[ZR], 0.0 * in_error[ZR]
    for k in (ZR - 1, ZR + 1, ZR - 2, ZR + 2, ZR - 3, ZR + 3):
        higher = in_error[k] > highest + ALIKE
        highest = xp.where(higher, in_error[k], highest)
        place = xp.where(higher, k - ZR, place)
    return place


def performance_indices(xp: Xp, place: Scalar) -> list[Scalar]:
    """p(k) of the rules of each error term, when the error counts for the term ``place``."""
    found = []
    for row in PERFORMANCE:
        index = 0.0 * place
        for k, value in enumerate(row):
            index = xp.where(place == k - ZR, value, index)
        found.append(index)
    return found


def blamed_aflc(xp: Xp, error: Scalar, index: Scalar, excess: Scalar) -> Truth:
    """Whether a rule pulled the action the wrong way (JK04 Appendix B).

    ``error`` is e(k-1), ``index`` p(k), ``excess`` the rule's singleton less u_0(k-1). In the
    cases I and IV the action was too large and rules with excess >= 0 are to blame, in II and III
    it was too small and those with excess <= 0 are.
    """
    return xp.where(error * index > 0.0, -excess, excess) <= ALIKE


def blamed_soflc(xp: Xp, error: Scalar, index: Scalar, excess: Scalar) -> Truth:
    """Whether a rule is contracted, as JK95 prints it: excess > 0, in its third case <= 0.

    Differs from JK04 for e > 0 with p < 0, where the rules change places, and in the first and
    fourth case where a singleton equals the overall action.
    """
    third = xp.where(error < 0.0, index, 0.0) > 0.0
    return (excess <= ALIKE) == third


def joined(
    xp: Xp, terms: Triangles, steps: Sequence[Scalar], size: Scalar, overlap: Scalar
) -> list[tuple[Scalar, Scalar, Scalar]]:
    """Terms (7, 3) after each was narrowed by ``steps`` (7) of ``size`` on both sides.

    Where two terms overlap, both edges stay between the two centres (JK04 section 4.1), and they
    overlap by ``overlap`` or more: edges that would come closer are set half of it to either side
    of their middle. An error in a gap would have no command, and across a narrow overlap the
    command almost jumps. The papers print no such limit.
    """
    lefts, rights = [terms[0][0]], []
    for k in range(len(terms) - 1):
        lower, upper = terms[k][1], terms[k + 1][1]
        right = clipped(xp, terms[k][2] - size * steps[k], lower, upper)
        left = clipped(xp, terms[k + 1][0] + size * steps[k + 1], lower, upper)
        half = 0.5 * overlap
        middle = clipped(xp, 0.5 * (left + right), lower + half, upper - half)
        tight = right - left < overlap
        rights.append(xp.once(xp.where(tight, middle + half, right)))
        lefts.append(xp.once(xp.where(tight, middle - half, left)))
    rights.append(terms[-1][2])
    return [(lefts[k], terms[k][1], rights[k]) for k in range(len(terms))]
