"""One fuzzy unit: linguistic terms, singleton rule table, centre-average defuzzification.

Written for scalars and unrolled: inside the closed loop an array of seven memberships would cost
a factor of five. ``xp`` as in ``core.scalars``. Never imports JAX.
"""

from collections.abc import Callable, Sequence
from typing import TypeAlias

from hfc_design.core.records import Finite, Label, NotNegative, Positive, Record
from hfc_design.core.scalars import Xp, total
from hfc_design.core.shapes import Degrees, RuleTable, Scalar


class Term(Record):
    """A linguistic term on the normalised universe: a Gaussian with a flat top.

    Lin & Lee 1999, eq. 3. It is MATLAB's ``gauss2mf`` and fuzzylite's ``GaussianProduct`` with
    shoulders at ``centre -/+ half_width`` and sigma = 1/sqrt(2 rate).
    """

    label: Label
    centre: Finite
    half_width: NotNegative
    rate: Positive


#: The seven terms of every input in Lin & Lee 1999 (eq. 3a-3g).
LIN_LEE_TERMS: tuple[Term, ...] = (
    Term(label="f1", centre=-1.0, half_width=0.1, rate=4.0),
    Term(label="f2", centre=-0.6, half_width=0.05, rate=8.0),
    Term(label="f3", centre=-0.2, half_width=0.0, rate=32.0),
    Term(label="f4", centre=0.0, half_width=0.0, rate=32.0),
    Term(label="f5", centre=0.2, half_width=0.0, rate=32.0),
    Term(label="f6", centre=0.6, half_width=0.05, rate=8.0),
    Term(label="f7", centre=1.0, half_width=0.1, rate=4.0),
)

#: What gives the degrees of a scalar in the terms.
Graded: TypeAlias = Callable[[Scalar], list[Scalar]]


def membership(xp: Xp, term: Term, u: Scalar) -> Scalar:
    """Degree in (0, 1] to which scalar ``u`` belongs to ``term``."""
    distance = u - term.centre
    if term.half_width:
        outside = abs(distance) - term.half_width
        distance = xp.where(outside > 0.0, outside, 0.0)
    return xp.decay((-term.rate * distance) * distance)


def memberships(xp: Xp, terms: Sequence[Term], u: Scalar) -> list[Scalar]:
    """Degrees of scalar ``u`` in every term."""
    return [membership(xp, term, u) for term in terms]


def averaged(xp: Xp, consequents: RuleTable, in_column: Degrees, in_row: Degrees) -> Scalar:
    """Output of one unit from the degrees of its two inputs (LL eq. 4).

    ``consequents[i][j]`` is the singleton of the rule "row is term i and column is term j".
    Singleton fuzzifier, product, centre average. Where no rule fires (an input so far outside
    the universe that every membership underflows) the output is 0.
    """
    weighted = 0.0
    for degree, singletons in zip(in_row, consequents, strict=True):
        inner = total(d * s for d, s in zip(in_column, singletons, strict=True))
        weighted = weighted + degree * inner
    firing = total(in_column) * total(in_row)
    # The division comes last: what ends in a division the compiler computes once, what ends in
    # a selection it would repeat in everything that uses it.
    return xp.ratio(weighted, xp.where(firing > 0.0, firing, 1.0))
