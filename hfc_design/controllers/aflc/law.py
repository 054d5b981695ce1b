"""Adaptive fuzzy controllers of a feed drive: AFLC and SOFLC. Never imports JAX.

AFLC is Jee & Koren 2004 (JK04), section 4 and Appendix B; SOFLC its ancestor, Jee & Koren 1995
(JK95), section 3. At sample k the rules that fired at k - 1 are judged by how the error has
changed since; their terms and singletons move, and the new table gives the command. The functions
compute with scalars of one axis; ``xp`` is explained in ``core.numbers``.
"""

from collections.abc import Callable, Sequence
from functools import reduce
from itertools import pairwise
from operator import or_
from typing import NamedTuple

from hfc_design.controllers.aflc.adaptation import (
    ALIKE,
    blamed_aflc,
    highest_term,
    joined,
    performance_indices,
)
from hfc_design.controllers.controller import AxisLaw, Signals, outside
from hfc_design.controllers.flc import law as flc
from hfc_design.controllers.flc.law import FlcGains, FlcMemory, Parts, RuleBase
from hfc_design.controllers.neighbours import (
    Degrees,
    Neighbours,
    Partition,
    alike,
    fired,
    memberships,
    number_of,
)
from hfc_design.core.numbers import RuleTable, Scalar, Truth, Xp, total
from hfc_design.core.records import TERMS, ZR
from hfc_design.stability.sectors import Curve, Rectangle, bounded, inner_edges


class Rates(NamedTuple):
    """Steps of the adaptation for a performance index of 1 or -1, and the smallest overlaps."""

    k_a: Scalar  # step of an edge of an error term [BLU]
    k_b: Scalar  # step of an edge of a change term [BLU]
    k_c: Scalar  # step of a singleton, in units of the command
    a_overlap: Scalar  # smallest overlap of two neighbouring error terms [BLU]
    b_overlap: Scalar  # smallest overlap of two neighbouring change terms [BLU]


class AdaptiveGains(NamedTuple):
    """Initial table, steps and bounds of the adaptation."""

    flc: FlcGains
    rates: Rates
    sectors: Rectangle | Curve | None  # limits of the table's gains; None: none, as in JK95


class AdaptiveMemory(NamedTuple):
    """Memory of the controller; before the first sample the designed rule base, all else zero."""

    singletons: RuleTable  # (7, 7)
    error_rights: Sequence[Scalar]  # (6,) ``Partition.rights`` of the error terms
    error_lefts: Sequence[Scalar]  # (6,) ``Partition.lefts`` of the error terms
    change_rights: Sequence[Scalar]  # (6,) of the change terms
    change_lefts: Sequence[Scalar]  # (6,) of the change terms
    error: Scalar  # e(k-1) [BLU]
    change: Scalar  # e(k-1) - e(k-2) [BLU]
    action: Scalar  # u_0(k-1)
    integral: Scalar
    judges: Truth | None = None  # false: no rule of k - 1 is judged; None: they are

    def base(self, gains: AdaptiveGains) -> RuleBase:
        """Return the rule base as last adapted."""
        error = Partition.of(gains.flc.error_terms)
        change = Partition.of(gains.flc.change_terms)
        return RuleBase(
            error._replace(rights=self.error_rights, lefts=self.error_lefts),
            change._replace(rights=self.change_rights, lefts=self.change_lefts),
            self.singletons,
        )


#: Function (xp, e(k-1), p(k), singleton less action) -> true if a rule is to blame.
Blame = Callable[[Xp, Scalar, Scalar, Scalar], Truth]


class Judge(NamedTuple):
    """Functions and options that decide which rules are to blame; it contains no numbers."""

    blamed: Blame = blamed_aflc
    #: If true, rules of ZR are narrowed by a step when the error leaves ZR (JK04 section 4.1, end).
    narrows_zero: bool = False


#: Judgement of JK04 by its Table 2 alone.
JK04 = Judge()


def aflc(sample_time: float, limit: float | None = None, judge: Judge = JK04) -> AxisLaw:
    """Return the law of kind ``aflc``; with ``adaptation.blamed_soflc`` that of ``soflc``."""
    law = AxisLaw(sample, initial_memory, sample_time, limit, judge, tells=True)
    return law._replace(prime=primed, begin=begun)


def initial_memory(law: AxisLaw, zero: Scalar) -> AdaptiveMemory:
    """Return the memory of an axis at rest on its reference; ``begun`` adds the rule base."""
    table, edges = [[zero] * TERMS for _ in range(TERMS)], [zero] * (TERMS - 1)
    return AdaptiveMemory(table, edges, edges, edges, edges, zero, zero, zero, zero)


def begun(xp: Xp, law: AxisLaw, gains: AdaptiveGains, memory: AdaptiveMemory) -> AdaptiveMemory:
    """Return the memory with the designed rule base.

    If ``xp.sparse``, the bounds of the rule base are applied here, because then a sample in which
    no rule is judged does not apply them.
    """
    base, zero = RuleBase.of(gains.flc), memory.error
    if xp.sparse:
        still, rates = [0.0] * TERMS, gains.rates
        error_terms = _narrowed(xp, base.error, still, 0.0, rates.a_overlap)
        change_terms = _narrowed(xp, base.change, still, 0.0, rates.b_overlap)
        base = _bounded(xp, gains, RuleBase(error_terms, change_terms, base.singletons))

    def row(numbers: Sequence[Scalar]) -> list[Scalar]:
        return [zero + x for x in numbers]

    return memory._replace(
        singletons=[*map(row, base.singletons)],
        error_rights=row(base.error.rights),
        error_lefts=row(base.error.lefts),
        change_rights=row(base.change.rights),
        change_lefts=row(base.change.lefts),
    )


def primed(
    xp: Xp, law: AxisLaw, gains: AdaptiveGains, memory: AdaptiveMemory, signals: Signals
) -> AdaptiveMemory:
    """Return the memory with this sample's error as the previous one; no rule will be judged."""
    error = outside(xp, gains.flc.dead_zone, signals["error"])
    return memory._replace(error=error, judges=False)


def sample(
    xp: Xp, law: AxisLaw, gains: AdaptiveGains, memory: AdaptiveMemory, signals: Signals
) -> tuple[Scalar, AdaptiveMemory, Parts]:
    """Return the command of one sample like ``flc.sample``, with the table as adapted so far."""
    error = outside(xp, gains.flc.dead_zone, signals["error"])
    base, in_error = adapted(xp, law.structure, gains, memory, error)
    before = FlcMemory(memory.error, 0.0, memory.integral)
    as_pd = law._replace(structure="PD")
    inference_args = base, in_error
    command, after, parts = flc.commanded(xp, as_pd, gains.flc, *inference_args, before, signals)
    remembered = AdaptiveMemory(
        base.singletons,
        base.error.rights,
        base.error.lefts,
        base.change.rights,
        base.change.lefts,
        parts.error,
        parts.change,
        parts.inferred,
        after.integral,
    )
    return command, remembered, parts


def adapted(
    xp: Xp, judge: Judge, gains: AdaptiveGains, memory: AdaptiveMemory, error: Scalar
) -> tuple[RuleBase, Degrees]:
    """Judge the rules of sample k - 1 by the ``error`` of sample k.

    For a rule that is to blame, both terms are narrowed and the singleton moves; for any other rule
    that fired, both terms are widened; all by |p| steps. The moves of a term by several rules add
    up; then edges are limited to the neighbours' centres. If e(k-1) was 0, no rule is judged.
    Returns the new rule base, and the degrees of ``error`` in its terms.
    """
    base, rates = memory.base(gains), gains.rates
    judged = memory.error
    if memory.judges is not None:
        judged = xp.where(memory.judges, judged, 0.0)
    in_error = memberships(xp, base.error, judged)
    in_change = memberships(xp, base.change, memory.change)
    now = memberships(xp, base.error, error)
    place = highest_term(xp, now)
    indices = performance_indices(xp, place)
    rows, leaves = [], False
    for i, degree in fired(in_error):
        judges = (degree > ALIKE) & (judged != 0.0)
        index = xp.once(indices[i])
        size = xp.once(xp.where(judges, abs(index), 0))
        shift = rates.k_c * size
        # Down if a positive error fell too far, or if a negative error rose too slowly.
        shift = xp.once(xp.where(judged * index > 0.0, -shift, shift))
        rows.append((i, index, size, shift))
        if judge.narrows_zero and (at_zero := i == ZR) is not False:
            leaves = leaves | (at_zero & judges & (place != 0.0))

    def moved() -> tuple[RuleBase, Degrees]:
        narrowed, singletons = [], []  # (rows, columns) steps; (row, column, number)
        columns, degrees = zip(*fired(in_change), strict=True)
        for i, index, size, shift in rows:
            rules = tuple(base.singletons[i][j] for j in columns), memory.action, degrees
            judgement = judge.blamed, judged, index, size, shift
            steps, after = xp.call(_judged, xp, *judgement, *rules)
            if judge.narrows_zero and (at_zero := i == ZR) is not False:
                narrows = (xp.where(leaves & (degree > ALIKE), 1, 0) for degree in degrees)
                pairs = zip(narrows, steps, strict=True)
                steps = tuple(xp.where(at_zero, *pair) for pair in pairs)
            singletons += [(i, j, x) for j, x in zip(columns, after, strict=True)]
            narrowed.append(steps)
        by_row = [xp.once(total(steps)) for steps in narrowed]
        by_column = [xp.once(total(steps)) for steps in zip(*narrowed, strict=True)]
        error_steps, change_steps = alike(in_error, by_row), alike(in_change, by_column)
        error_terms = _narrowed(xp, base.error, error_steps, rates.k_a, rates.a_overlap)
        change_terms = _narrowed(xp, base.change, change_steps, rates.k_b, rates.b_overlap)
        table = xp.put(base.singletons, singletons)
        new_base = _bounded(xp, gains, RuleBase(error_terms, change_terms, table))
        return new_base, memberships(xp, error_terms, error)

    if not xp.sparse:
        return moved()
    acts = reduce(or_, (size > 0 for _, _, size, _ in rows), leaves)
    updated: tuple[RuleBase, Degrees] = xp.when(acts, moved, (base, now))
    return updated


def _bounded(xp: Xp, gains: AdaptiveGains, base: RuleBase) -> RuleBase:
    """Return the rule base with singletons moved so that the table obeys ``gains.sectors``."""
    if gains.sectors is None:
        return base
    ends = inner_edges(*base.error[1:]), inner_edges(*base.change[1:])
    row = bounded(xp, gains.sectors, *ends, base.singletons, gains.flc.singletons)
    # The row ZR has no bound.
    (table,) = xp.between((base.singletons,), 0, TERMS, lambda i, _: (row(i),), ZR)
    return base._replace(singletons=table)


def _judged(
    xp: Xp,
    blamed: Blame,
    error: Scalar,
    index: Scalar,
    size: Scalar,
    shift: Scalar,
    singletons: Sequence[Scalar],
    action: Scalar,
    degrees: Sequence[Scalar],
) -> tuple[tuple[Scalar, ...], tuple[Scalar, ...]]:
    """Return for each rule of a row by how many steps it narrows terms, and its new singleton."""
    steps, moved = [], []
    for singleton, degree in zip(singletons, degrees, strict=True):
        guilty = blamed(xp, error, index, singleton - action)
        fires = degree > ALIKE
        steps.append(xp.where(fires, xp.where(guilty, size, -size), 0))
        moved.append(singleton + xp.where(fires & guilty, shift, 0.0))
    return tuple(steps), tuple(moved)


def _narrowed(xp: Xp, terms: Partition, steps: Degrees, size: Scalar, overlap: Scalar) -> Partition:
    """Return the terms narrowed by ``steps`` of ``size``; they overlap by at least ``overlap``."""
    if isinstance(steps, Neighbours):
        term_tables = map(xp.table, terms)
        edges = xp.call(_neighbours, xp, *term_tables, steps.first, *steps.values, size, overlap)
        return Partition(terms.centres, *edges)
    each = zip(pairwise(terms.centres), terms.rights, terms.lefts, pairwise(steps), strict=True)
    new_edges = [
        joined(xp, pair, edges, step_pair, size, overlap) for pair, *edges, step_pair in each
    ]
    return Partition(terms.centres, *map(list, zip(*new_edges, strict=True)))


def _neighbours(
    xp: Xp,
    centres: Sequence[Scalar],
    rights: Sequence[Scalar],
    lefts: Sequence[Scalar],
    first: Scalar,
    lower: Scalar,
    upper: Scalar,
    size: Scalar,
    overlap: Scalar,
) -> tuple[Sequence[Scalar], ...]:
    """Return all edges, with two neighbours narrowed by ``lower`` and ``upper`` steps."""
    steps = Neighbours(first, (lower, upper))

    def moved(k: Scalar, right: Scalar, left: Scalar) -> tuple[Scalar, Scalar]:
        both = number_of(xp, steps, k), number_of(xp, steps, k + 1)
        return joined(xp, (centres[k], centres[k + 1]), (right, left), both, size, overlap)

    return tuple(xp.between((rights, lefts), first - 1, first + 2, moved))
