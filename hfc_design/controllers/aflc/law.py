"""The adaptive fuzzy controllers of a feed drive: AFLC and SOFLC. Never imports JAX.

AFLC is Jee & Koren 2004 (JK04), section 4 and Appendix B; SOFLC its ancestor, Jee & Koren 1995
(JK95), section 3. At sample k the rules that fired at k - 1 are judged by what became of the
error, terms and singletons are moved, and the moved table gives the command. Written for one
axis in scalars; ``xp`` as in ``core.scalars``.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

from hfc_design.controllers.aflc.adaptation import (
    ALIKE,
    blamed_aflc,
    joined,
    performance,
)
from hfc_design.controllers.controller import AxisLaw, Signals
from hfc_design.controllers.flc import law as flc
from hfc_design.controllers.flc.law import FlcGains, FlcMemory, Parts, memberships
from hfc_design.controllers.flc.sectors import Sectors, bounded
from hfc_design.core.scalars import Xp, total
from hfc_design.core.shapes import Scalar


class Rates(NamedTuple):
    """Steps of the adaptation for a performance index of 1 or -1, and how narrow terms get."""

    k_a: Any  # of an edge of an error term [BLU]
    k_b: Any  # of an edge of a change term [BLU]
    k_c: Any  # of a singleton, units of the command
    a_overlap: Any  # the least that two neighbouring error terms overlap [BLU]
    b_overlap: Any  # the same of two change terms [BLU]


class AdaptiveGains(NamedTuple):
    """The table that the adaptation starts from, its steps and its bounds."""

    flc: FlcGains
    rates: Rates
    sectors: Sectors | None  # None: no bound, as in JK95


class AdaptiveMemory(NamedTuple):
    """What the controller remembers; all zero before the first sample.

    The moves are counted from the gains. A joint is where two neighbours overlap: the right edge
    of the lower term and the left edge of the upper one.
    """

    error: Any  # e(k-1) [BLU]
    change: Any  # e(k-1) - e(k-2) [BLU]
    action: Any  # u_0(k-1)
    integral: Any
    error_moves: Any  # (6, 2) of the joints between the error terms
    change_moves: Any  # (6, 2)
    singleton_moves: Any  # (7, 7)


#: Whether a rule is to blame: (xp, e(k-1), p(k), its singleton less the action) -> bool.
Blame = Callable[[Xp, Any, Any, Any], Any]


def aflc(sample_time: float, limit: float | None = None, blamed: Blame = blamed_aflc) -> AxisLaw:
    """The law of kind ``aflc``; with ``adaptation.blamed_soflc`` that of ``soflc``."""
    return AxisLaw(parts, initial_memory, sample_time, limit, blamed)


def initial_memory(law: AxisLaw, zero: Scalar) -> AdaptiveMemory:
    """Memory before the first sample: the axis stood on its reference, nothing has moved."""
    joints = ((zero,) * 2,) * 6
    return AdaptiveMemory(zero, zero, zero, zero, joints, joints, ((zero,) * 7,) * 7)


def parts(
    xp: Xp, law: AxisLaw, gains: AdaptiveGains, memory: AdaptiveMemory, signals: Signals
) -> tuple[Parts, AdaptiveMemory]:
    """What one sample commands, in its parts, and what to remember; signals as in ``flc.parts``."""
    table = gains.flc
    terms = adapted(xp, law.structure, gains, memory, signals["error"])
    error_terms, change_terms, singletons = terms
    moved = FlcGains(*terms, table.k_i, table.compensation)
    before = FlcMemory(memory.error, memory.action, memory.integral)
    found, after = flc.parts(xp, law._replace(structure="PD"), moved, before, signals)
    return found, AdaptiveMemory(
        found.error,
        found.change,
        found.inferred,
        after.integral,
        _difference(_joints(error_terms), _joints(table.error_terms)),
        _difference(_joints(change_terms), _joints(table.change_terms)),
        _difference(singletons, table.singletons),
    )


def current(gains: AdaptiveGains, memory: AdaptiveMemory) -> tuple[list[Any], list[Any], list[Any]]:
    """Error terms (7, 3), change terms (7, 3) and singletons (7, 7) as last adapted."""
    table = gains.flc
    singletons = [
        [u + move for u, move in zip(row, moves, strict=True)]
        for row, moves in zip(table.singletons, memory.singleton_moves, strict=True)
    ]
    return (
        _moved(table.error_terms, memory.error_moves),
        _moved(table.change_terms, memory.change_moves),
        singletons,
    )


def adapted(
    xp: Xp, blamed: Blame, gains: AdaptiveGains, memory: AdaptiveMemory, error: Any
) -> tuple[list[Any], list[Any], list[Any]]:
    """Terms and singletons after the sample k - 1 is judged by the ``error`` of sample k.

    Of a rule that is to blame both terms are narrowed and the singleton moves, of another both
    terms are widened, |p| steps each. Several rules that move the same term add up, so their
    order does not matter; only then the edges are held between the neighbours' centres.
    """
    error_terms, change_terms, singletons = current(gains, memory)
    in_error = memberships(xp, error_terms, memory.error)
    in_change = memberships(xp, change_terms, memory.change)
    indices = [xp.once(p) for p in performance(xp, memberships(xp, error_terms, error))]
    narrowed = []  # by each rule, in steps
    for i, row in enumerate(singletons):
        judged = (in_error[i] > ALIKE) & (memory.error != 0.0)
        size = xp.once(xp.where(judged, abs(indices[i]), 0.0))
        shift = gains.rates.k_c * size
        # Down where a positive error fell too far or a negative one too slowly.
        shift = xp.once(xp.where(memory.error * indices[i] > 0.0, -shift, shift))
        steps = []
        for j, singleton in enumerate(row):
            guilty = blamed(xp, memory.error, indices[i], singleton - memory.action)
            fired = in_change[j] > ALIKE
            steps.append(xp.where(fired, xp.where(guilty, size, -size), 0.0))
            row[j] = singleton + xp.where(fired & guilty, shift, 0.0)
        narrowed.append(steps)
    by_row = [xp.once(total(steps)) for steps in narrowed]
    by_column = [xp.once(total(steps)) for steps in zip(*narrowed, strict=True)]
    error_terms = joined(xp, error_terms, by_row, gains.rates.k_a, gains.rates.a_overlap)
    change_terms = joined(xp, change_terms, by_column, gains.rates.k_b, gains.rates.b_overlap)
    if gains.sectors is not None:
        signs = gains.flc.singletons
        singletons = bounded(xp, gains.sectors, error_terms, change_terms, singletons, signs)
    return error_terms, change_terms, singletons


def _joints(terms: Any) -> Any:
    """(right edge of the lower term, left edge of the upper one) of each pair of neighbours."""
    return tuple((lower[2], upper[0]) for lower, upper in pairwise(terms))


def _moved(terms: Any, moves: Any) -> list[Any]:
    """Terms (7, 3) with the edges of their joints moved."""
    lefts = [terms[0][0], *(t[0] + move[1] for t, move in zip(terms[1:], moves, strict=True))]
    rights = [*(t[2] + move[0] for t, move in zip(terms, moves, strict=False)), terms[-1][2]]
    return [(left, t[1], right) for left, t, right in zip(lefts, terms, rights, strict=True)]


def _difference(table: Any, start: Any) -> Any:
    """How far the numbers of a table of rows are from those it started from."""
    return tuple(
        tuple(now - then for now, then in zip(row, first, strict=True))
        for row, first in zip(table, start, strict=True)
    )
