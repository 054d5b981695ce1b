"""What a two-input rule base of another program computes, Mamdani's too: the original to sample.

Integrals are sums over the same places of the output's range as in the program that the file is
for, so that they are its own to rounding.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Mask
from hfc_design.formats.reading.shapes import Curve
from hfc_design.formats.reading.system import Token

#: What divides by how much all rules fire; other sums of conclusions do not.
AVERAGES = ("wtaver", "WeightedAverage")
#: Degrees at places of the output that are worked on together.
AT_ONCE = 2_000_000

Norm = Callable[[Floats, Floats], Floats]
#: Norms under the names of .fis and of FLL.
NORMS: dict[str, Norm] = {
    **dict.fromkeys(("min", "Minimum"), np.minimum),
    **dict.fromkeys(("prod", "AlgebraicProduct"), np.multiply),
    "BoundedDifference": lambda a, b: np.maximum(a + b - 1.0, 0.0),
    **dict.fromkeys(("max", "Maximum"), np.maximum),
    **dict.fromkeys(("probor", "algebraic_sum", "AlgebraicSum"), lambda a, b: a + b - a * b),
    "BoundedSum": lambda a, b: np.minimum(a + b, 1.0),
    **dict.fromkeys(("sum", "UnboundedSum"), np.add),
}
#: What stands before a term in FLL -> the degree of it.
HEDGES: dict[str, Callable[[Floats], Floats]] = {
    "not": lambda degree: 1.0 - degree,
    "very": np.square,
    "somewhat": np.sqrt,
    "any": np.ones_like,
}


class Term(NamedTuple):
    """A term: its degree at values, and the places at which its shape begins, bends and ends."""

    label: Token
    degree: Callable[[Floats], Floats]
    places: list[float]


def term_of(label: Token, curve: Curve, numbers: Sequence[float]) -> Term:
    """A term of a shape; ValueError: its places fall, or it has a width that is none."""
    places = [numbers[k] for k in curve.places]
    widths = [number for k, number in enumerate(numbers) if k not in curve.places]
    rising = all(a <= b for a, b in pairwise(places)) or curve.falls
    if not rising or not all(widths):
        raise label.fault(f"term {label.text}: its corners have to rise, its widths not to be 0")
    return Term(label, lambda x: curve.degree(x, *numbers), places)


def plane(a: float, b: float, c: float) -> Callable[[Floats, Floats], Floats]:
    """a x + b y + c."""
    return lambda x, y: a * x + b * y + c


class Variable(NamedTuple):
    """An input, or the output."""

    name: Token
    low: float
    high: float
    terms: list[Term]


class Clause(NamedTuple):
    """An input is a term; ``hedges`` from the nearest to the term on."""

    input: int
    term: int
    hedges: Sequence[str] = ()


class Rule(NamedTuple):
    """If all ``clauses`` hold, or one of them, then the output is a term."""

    clauses: list[Clause]
    every: bool
    term: int
    hedges: Sequence[str]
    weight: float

    def speaks_of(self, terms: tuple[int, int]) -> bool:
        """Whether it is made for these terms of the inputs, that is fires where they are 1."""
        holds = (
            "any" in clause.hedges
            or (terms[clause.input] == clause.term) != (clause.hedges.count("not") % 2 == 1)
            for clause in self.clauses
        )
        return self.weight > 0.0 and (all(holds) if self.every else any(holds))


class Methods(NamedTuple):
    """How rules make an output."""

    conjunction: str
    disjunction: str
    implication: str
    aggregation: str
    defuzzifier: str
    places: Floats  # of the output's range
    shares: Floats  # of each place in an integral
    default: float  # the output where no rule fires; nan: it has none


class RuleBase(NamedTuple):
    """A rule base of two inputs and one output, as a file has it."""

    name: str  # of the whole; "": none
    inputs: tuple[Variable, Variable]
    output: Variable
    rules: list[Rule]
    methods: Methods
    #: Where the output's terms are functions of the inputs, Sugeno's: one a term.
    conclusions: Sequence[Callable[[Floats, Floats], Floats]] = ()

    def left_out(self) -> list[str]:
        """Pairs of terms for which there is no rule, in words."""
        first, second = self.inputs
        return [
            f"{first.name.text} is {a.label.text} and {second.name.text} is {b.label.text}"
            for i, a in enumerate(first.terms)
            for j, b in enumerate(second.terms)
            if not any(rule.speaks_of((i, j)) for rule in self.rules)
        ]

    def outputs(self, first: Floats, second: Floats) -> Floats:
        """(n,) output at inputs (n,); nan where no rule fires and there is no default."""
        step = max(1, AT_ONCE // max(1, len(self.methods.places)))
        parts = [slice(k, k + step) for k in range(0, len(first), step)]
        return np.concatenate([self._outputs((first[part], second[part])) for part in parts])

    def _outputs(self, values: tuple[Floats, Floats]) -> Floats:
        firing = [self._firing(rule, values) for rule in self.rules]
        methods = self.methods
        if self.conclusions:
            told = [self.conclusions[rule.term](*values) for rule in self.rules]
            return self._averaged(np.stack(firing), np.stack(told))
        norm, implied = NORMS[methods.aggregation], NORMS[methods.implication]
        whole = np.zeros((len(values[0]), len(methods.places)))
        for rule, degree in self._grouped(firing):
            shape = hedged(self.output.terms[rule.term].degree(methods.places), rule.hedges)
            whole = norm(whole, implied(degree[:, None], shape))
        fires = (whole > 0.0).any(axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            found = DEFUZZIFIERS[methods.defuzzifier](whole, methods.places, methods.shares)
        return np.where(fires, found, methods.default)

    def _averaged(self, firing: Floats, conclusions: Floats) -> Floats:
        total = firing.sum(axis=0)
        share = total if self.methods.defuzzifier in AVERAGES else np.ones_like(total)
        with np.errstate(invalid="ignore", divide="ignore"):
            found = (firing * conclusions).sum(axis=0) / share
        return np.where(total > 0.0, found, self.methods.default)

    def _grouped(self, firing: list[Floats]) -> list[tuple[Rule, Floats]]:
        """Rules with what they fire at; with a maximum, one rule a conclusion is enough."""
        if self.methods.aggregation not in ("max", "Maximum"):
            return list(zip(self.rules, firing, strict=True))
        found: dict[tuple[int, tuple[str, ...]], tuple[Rule, Floats]] = {}
        for rule, degree in zip(self.rules, firing, strict=True):
            key = rule.term, tuple(rule.hedges)
            highest = found[key][1] if key in found else degree
            found[key] = rule, np.maximum(highest, degree)
        return list(found.values())

    def _firing(self, rule: Rule, values: tuple[Floats, Floats]) -> Floats:
        name = self.methods.conjunction if rule.every else self.methods.disjunction
        found: Floats | None = None
        for clause in rule.clauses:
            term = self.inputs[clause.input].terms[clause.term]
            degree = hedged(term.degree(values[clause.input]), clause.hedges)
            found = degree if found is None else NORMS[name](found, degree)
        if found is None:
            raise ValueError("a rule without a clause")
        return rule.weight * found


def hedged(degree: Floats, hedges: Sequence[str]) -> Floats:
    """The degree after its hedges."""
    for hedge in hedges:
        degree = HEDGES[hedge](degree)
    return degree


def _centroid(degrees: Floats, places: Floats, shares: Floats) -> Floats:
    weighted = degrees * shares
    return np.asarray(weighted @ places / weighted.sum(axis=1))


def _bisector(degrees: Floats, places: Floats, shares: Floats) -> Floats:
    """The place up to which the area is nearest to half of it, of several their mean."""
    area = np.cumsum(degrees * shares, axis=1)
    off = np.abs(area / area[:, -1:] - 0.5)
    return _mean(off == off.min(axis=1, keepdims=True), places)


def _mean(chosen: Mask, places: Floats) -> Floats:
    return np.asarray(chosen @ places / chosen.sum(axis=1))


def _highest(degrees: Floats) -> Mask:
    return np.asarray(degrees == degrees.max(axis=1, keepdims=True))


#: (degrees (n, places), places, their shares) -> (n,) output, under the names of .fis and FLL.
DEFUZZIFIERS: dict[str, Callable[[Floats, Floats, Floats], Floats]] = {
    **dict.fromkeys(("centroid", "Centroid"), _centroid),
    "Bisector": _bisector,
    **dict.fromkeys(
        ("mom", "MeanOfMaximum"), lambda degrees, places, _: _mean(_highest(degrees), places)
    ),
    "SmallestOfMaximum": lambda degrees, places, _: places[_highest(degrees).argmax(axis=1)],
    "LargestOfMaximum": lambda degrees, places, _: places[
        len(places) - 1 - _highest(degrees)[:, ::-1].argmax(axis=1)
    ],
}
