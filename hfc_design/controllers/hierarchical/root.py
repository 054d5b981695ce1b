"""Root unit of a hierarchy with consequents that adapt while the loop runs.

The method is that of the adaptive controller of feed drives (JK04 section 4.2 and Appendix B): at
sample k, the rules that fired at k - 1 are judged by how the error has changed since, and the
consequents of the rules to blame move. The terms (LL eq. 3) stay as they are: they have tails
without end and so no edges that could move. No stability theorem applies to the C-axis; only
``largest_move`` bounds how far a consequent moves from the designed one. The functions compute
with scalars of one axis; ``xp`` is explained in ``core.numbers``. Never imports JAX.
"""

from collections.abc import Sequence
from functools import partial
from operator import add, mul, not_
from typing import NamedTuple

from pydantic import Field

from hfc_design.controllers.aflc.adaptation import blamed_aflc, highest_term, performance_indices
from hfc_design.core.numbers import Degrees, RuleTable, Scalar, Xp, clipped
from hfc_design.core.records import TERMS, ZR, NotNegative, Positive, Record, Rules

#: A rule counts as fired if its share of the sum of all weights is above that of 49 equal rules.
FIRED = 1.0 / 49.0


class Adaptation(Record):
    """Adaptation of the root's consequents."""

    #: step of a consequent in a sample at a performance index of 1 or -1 [1]
    k_c: NotNegative = 3e-4
    largest_move: Positive  # largest move of a consequent from its start [1]
    #: factor on the error before it is judged [1/error]; left out: scale of the input error
    error_scale: Positive | None = Field(None, exclude_if=not_)
    #: moves of the consequents so far [1]; left out: none
    moves: Rules | None = Field(None, exclude_if=not_)


class RootMemory(NamedTuple):
    """Memory of the root; before the first sample all zero, except for moves of an earlier run."""

    term: Scalar  # number of the error's term at k - 1, from -3 to 3
    in_column: Degrees  # (7,) degrees of the column input at k - 1
    in_row: Degrees  # (7,) degrees of the row input at k - 1
    moves: RuleTable  # (7, 7) moves of the consequents from the designed ones


def initial_memory(zero: Scalar, moves: RuleTable | None = None) -> RootMemory:
    """Return the memory before the first sample: all zero, except for ``moves`` if given (7, 7)."""
    start = [[zero + move for move in row] for row in moves or ((0.0,) * TERMS,) * TERMS]
    return RootMemory(zero, [zero] * TERMS, [zero] * TERMS, start)


def step(
    xp: Xp,
    law: Adaptation,
    memory: RootMemory,
    in_error: Degrees,
    consequents: RuleTable,
    in_column: Degrees,
    in_row: Degrees,
) -> tuple[RuleTable, RootMemory]:
    """Return the adapted consequents (7, 7) for this sample, and the memory after it.

    ``consequents`` are the designed ones. ``in_error``, ``in_column`` and ``in_row`` (7 each) are
    the degrees of the scaled error and of the root's two inputs at this sample.
    """
    term = highest_term(xp, in_error)
    index = xp.once(_index(xp, memory.term, term))
    size, largest = law.k_c * abs(index), law.largest_move
    # Down if a positive error fell too far, or if a negative error rose too slowly.
    shift = xp.once(xp.where(memory.term * index > 0.0, -size, size))
    table = xp.each(add, consequents, memory.moves)
    firing = _firing(xp, memory)
    action = _action(xp, firing, table)

    def row(i: Scalar, moves: Sequence[Scalar]) -> tuple[Sequence[Scalar]]:
        def moved(weight: Scalar, singleton: Scalar, move: Scalar) -> Scalar:
            guilty = blamed_aflc(xp, memory.term, index, singleton - action)
            by = xp.where((weight > 0.0) & guilty, shift, 0.0)
            return clipped(xp, move + by, -largest, largest)

        return (xp.along(moved, firing[i], table[i], moves),)

    (moves,) = xp.between((memory.moves,), 0, TERMS, row)
    return xp.each(add, consequents, moves), RootMemory(term, in_column, in_row, moves)


def _index(xp: Xp, before: Scalar, now: Scalar) -> Scalar:
    """Return the performance index p(k) of rules of term ``before`` if the error is in ``now``."""
    indices = performance_indices(xp, now)
    if xp.sparse:
        return indices[xp.whole(clipped(xp, before + ZR, 0, TERMS - 1))]
    index = 0.0 * now
    for k, value in enumerate(indices):
        index = xp.where(before == k - ZR, value, index)
    return index


def _firing(xp: Xp, memory: RootMemory) -> Sequence[Sequence[Scalar]]:
    """Return the weights (7, 7) of the rules at k - 1; 0 for rules that count as not fired."""
    least = xp.once(FIRED * xp.total(memory.in_row) * xp.total(memory.in_column))

    def weight(row: Scalar, column: Scalar) -> Scalar:
        return xp.where(row * column > least, row * column, 0.0)

    strengths: Sequence[Sequence[Scalar]] = xp.along(
        lambda row: xp.along(partial(weight, row), memory.in_column), memory.in_row
    )
    return strengths


def _action(xp: Xp, firing: Sequence[Sequence[Scalar]], table: RuleTable) -> Scalar:
    """Return the weighted mean of the consequents that fired at k - 1; 0 if none did.

    Consequents are compared with this mean, not with the root's output. That output also contains
    rules that count as not fired and do not move: if all fired consequents had moved past it, they
    would be on the same side of it, and none would move any more.
    """
    weighted = xp.total(
        xp.along(lambda weights, row: xp.total(xp.along(mul, weights, row)), firing, table)
    )
    weight = xp.total(xp.along(xp.total, firing))
    return xp.once(weighted / xp.where(weight > 0.0, weight, 1.0))
