"""The adaptive fuzzy controllers of a feed drive: AFLC and SOFLC. Never imports JAX.

AFLC is Jee & Koren 2004 (JK04), section 4 and Appendix B; SOFLC its ancestor, Jee & Koren 1995
(JK95), section 3. At sample k the rules that fired at k - 1 are judged by what became of the
error, terms and singletons are moved, and the moved table gives the command. Written for one
axis in scalars; ``xp`` as in ``core.numbers``.
"""

from collections.abc import Callable, Sequence
from operator import add, sub
from typing import NamedTuple, TypeAlias

from hfc_design.controllers.aflc.adaptation import (
    ALIKE,
    blamed_aflc,
    highest_term,
    joined,
    performance_indices,
)
from hfc_design.controllers.controller import AxisLaw, Signals, outside
from hfc_design.controllers.flc import law as flc
from hfc_design.controllers.flc.law import FlcGains, FlcMemory, Parts, joints, memberships
from hfc_design.core.numbers import Scalar, Triangles, Truth, Xp, each, total
from hfc_design.core.records import ZR
from hfc_design.stability.sectors import Curve, Rectangle, bounded

#: Rows of numbers: terms (7, 3), singletons (7, 7), or how far they have moved.
Table: TypeAlias = Sequence[Sequence[Scalar]]


class Rates(NamedTuple):
    """Steps of the adaptation for a performance index of 1 or -1, and how narrow terms get."""

    k_a: Scalar  # of an edge of an error term [BLU]
    k_b: Scalar  # of an edge of a change term [BLU]
    k_c: Scalar  # of a singleton, units of the command
    a_overlap: Scalar  # the least that two neighbouring error terms overlap [BLU]
    b_overlap: Scalar  # the same of two change terms [BLU]


class AdaptiveGains(NamedTuple):
    """The table that the adaptation starts from, its steps and its bounds."""

    flc: FlcGains
    rates: Rates
    sectors: Rectangle | Curve | None  # None: no bound, as in JK95


class AdaptiveMemory(NamedTuple):
    """What the controller remembers; all zero before the first sample.

    The moves are counted from the gains. A joint is where two neighbours overlap: the right edge
    of the lower term and the left edge of the upper one.
    """

    error: Scalar  # e(k-1) [BLU]
    change: Scalar  # e(k-1) - e(k-2) [BLU]
    action: Scalar | None  # u_0(k-1); None: no rule has fired yet, so that none is judged
    integral: Scalar
    error_moves: Table  # (6, 2) of the joints between the error terms
    change_moves: Table  # (6, 2)
    singleton_moves: Table  # (7, 7)


#: Whether a rule is to blame: (xp, e(k-1), p(k), its singleton less the action) -> bool.
Blame = Callable[[Xp, Scalar, Scalar, Scalar], Truth]


class Judge(NamedTuple):
    """How rules are judged: code, and no numbers."""

    blamed: Blame = blamed_aflc
    #: Rules of ZR are narrowed by a step when the error leaves it (JK04 section 4.1, its end).
    narrows_zero: bool = False


#: As JK04 judges by its Table 2 alone.
JK04 = Judge()


def aflc(sample_time: float, limit: float | None = None, judge: Judge = JK04) -> AxisLaw:
    """The law of kind ``aflc``; with ``adaptation.blamed_soflc`` that of ``soflc``."""
    return AxisLaw(sample, initial_memory, sample_time, limit, judge, tells=True, prime=primed)


def initial_memory(law: AxisLaw, zero: Scalar) -> AdaptiveMemory:
    """Memory before the first sample: the axis stood on its reference, nothing has moved."""
    still = [[zero] * 2] * 6
    return AdaptiveMemory(zero, zero, zero, zero, still, still, [[zero] * 7] * 7)


def primed(
    xp: Xp, law: AxisLaw, gains: AdaptiveGains, memory: AdaptiveMemory, signals: Signals
) -> AdaptiveMemory:
    """The error of the sample before was that of this one; no rule had a part in it."""
    error = outside(xp, gains.flc.dead_zone, signals["error"])
    return memory._replace(error=error, action=None)


def sample(
    xp: Xp, law: AxisLaw, gains: AdaptiveGains, memory: AdaptiveMemory, signals: Signals
) -> tuple[Scalar, AdaptiveMemory, Parts]:
    """As ``flc.sample``, with the table as it is by now."""
    error = outside(xp, gains.flc.dead_zone, signals["error"])
    start, moved = gains.flc, adapted(xp, law.structure, gains, memory, error)
    before = FlcMemory(memory.error, 0.0, memory.integral)
    command, after, parts = flc.sample(xp, law._replace(structure="PD"), moved, before, signals)
    remembered = AdaptiveMemory(
        parts.error,
        parts.change,
        parts.inferred,
        after.integral,
        each(sub, joints(moved.error_terms), joints(start.error_terms)),
        each(sub, joints(moved.change_terms), joints(start.change_terms)),
        each(sub, moved.singletons, start.singletons),
    )
    return command, remembered, parts


def current(gains: AdaptiveGains, memory: AdaptiveMemory) -> FlcGains:
    """The table as last adapted."""
    table = gains.flc
    return table._replace(
        singletons=each(add, table.singletons, memory.singleton_moves),
        error_terms=_moved(table.error_terms, memory.error_moves),
        change_terms=_moved(table.change_terms, memory.change_moves),
    )


def adapted(
    xp: Xp, judge: Judge, gains: AdaptiveGains, memory: AdaptiveMemory, error: Scalar
) -> FlcGains:
    """The table after the sample k - 1 is judged by the ``error`` of sample k.

    Of a rule that is to blame both terms are narrowed and the singleton moves, of another both
    terms are widened, |p| steps each. Several rules that move the same term add up, so their
    order does not matter; only then the edges are held between the neighbours' centres. An error
    of 0 judges nothing.
    """
    table, rates = current(gains, memory), gains.rates
    if memory.action is None:
        memory = memory._replace(error=0.0 * error, action=0.0 * error)
    in_error = memberships(xp, table.error_terms, memory.error)
    in_change = memberships(xp, table.change_terms, memory.change)
    place = highest_term(xp, memberships(xp, table.error_terms, error))
    indices = [xp.once(p) for p in performance_indices(xp, place)]
    narrowed, singletons = [], []  # by each rule, in steps; what it moves to
    for i, row in enumerate(table.singletons):
        judged = (in_error[i] > ALIKE) & (memory.error != 0.0)
        size = xp.once(xp.where(judged, abs(indices[i]), 0.0))
        if i == ZR and judge.narrows_zero:
            leaves = judged & (place != 0.0)
            narrowed.append([xp.where(leaves & (d > ALIKE), 1.0, 0.0) for d in in_change])
            singletons.append(list(row))
            continue
        shift = rates.k_c * size
        # Down where a positive error fell too far or a negative one too slowly.
        shift = xp.once(xp.where(memory.error * indices[i] > 0.0, -shift, shift))
        steps, shifted = [], []
        for j, singleton in enumerate(row):
            guilty = judge.blamed(xp, memory.error, indices[i], singleton - memory.action)
            fired = in_change[j] > ALIKE
            steps.append(xp.where(fired, xp.where(guilty, size, -size), 0.0))
            shifted.append(singleton + xp.where(fired & guilty, shift, 0.0))
        narrowed.append(steps)
        singletons.append(shifted)
    by_row = [xp.once(total(steps)) for steps in narrowed]
    by_column = [xp.once(total(steps)) for steps in zip(*narrowed, strict=True)]
    error_terms = joined(xp, table.error_terms, by_row, rates.k_a, rates.a_overlap)
    change_terms = joined(xp, table.change_terms, by_column, rates.k_b, rates.b_overlap)
    if gains.sectors is not None:
        signs = gains.flc.singletons
        singletons = bounded(xp, gains.sectors, error_terms, change_terms, singletons, signs)
    return table._replace(error_terms=error_terms, change_terms=change_terms, singletons=singletons)


def _moved(terms: Triangles, moves: Table) -> Triangles:
    """Terms (7, 3) with the edges of their joints moved."""
    lefts = [terms[0][0], *(t[0] + move[1] for t, move in zip(terms[1:], moves, strict=True))]
    rights = [*(t[2] + move[0] for t, move in zip(terms, moves, strict=False)), terms[-1][2]]
    return [(left, t[1], right) for left, t, right in zip(lefts, terms, rights, strict=True)]
