"""Evaluation of a two-input rule base of another program, Mamdani or Sugeno, to sample it.

Integrals are sums over the same points of the output's range as in that program, so the results
agree up to rounding.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import inf, isfinite
from typing import NamedTuple, TypeVar

import numpy as np

from hfc_design.core.numbers import Floats, Mask
from hfc_design.formats.reading.system import Token


class Curve(NamedTuple):
    """Shape of terms: degree as a function of values and parameters.

    Parameters are positions on the axis or widths, in the order of the language of the file.
    """

    degree: Callable[..., Floats]  # (values, *numbers) -> degrees
    needs: int  # number of parameters
    places: Sequence[int]  # indices of the parameters that are positions
    falls: bool = False  # whether positions may descend
    reaches: bool = False  # whether the outer positions may be infinite


def _rising(x: Floats, a: float, b: float) -> Floats:
    """Straight rise from 0 at a to 1 at b; a step at b where a and b are equal."""
    if a == -inf:
        return np.ones_like(x)
    return np.asarray(np.clip((x - a) / (b - a), 0.0, 1.0) if b > a else (x >= b) * 1.0)


def _falling(x: Floats, a: float, b: float) -> Floats:
    return _rising(-x, -b, -a)


def _trapezoid(x: Floats, a: float, b: float, c: float, d: float) -> Floats:
    return np.minimum(_rising(x, a, b), _falling(x, c, d))


def _gaussian(x: Floats, centre: float, sigma: float) -> Floats:
    return np.exp(-0.5 * ((x - centre) / sigma) ** 2)


def _two_gaussians(x: Floats, left: float, a: float, right: float, b: float) -> Floats:
    """Product of half Gaussians: one rises to 1 at ``left``, one falls from 1 at ``right``."""
    rising = np.where(x < left, _gaussian(x, left, a), 1.0)
    return rising * np.where(x > right, _gaussian(x, right, b), 1.0)


def _bell(x: Floats, centre: float, width: float, slope: float) -> Floats:
    with np.errstate(over="ignore", divide="ignore"):
        return 1.0 / (1.0 + np.abs((x - centre) / width) ** (2.0 * slope))


def sigmoid(x: Floats, inflection: float, slope: float) -> Floats:
    """Sigmoid from 0 to 1, or from 1 to 0 if the slope is negative."""
    with np.errstate(over="ignore"):
        return 1.0 / (1.0 + np.exp(-slope * (x - inflection)))


def _s(x: Floats, a: float, b: float) -> Floats:
    """Two parabolas from 0 at a to 1 at b."""
    share = np.where(x > a, _rising(x, a, b), 0.0)
    return np.where(share < 0.5, 2.0 * share**2, 1.0 - 2.0 * (1.0 - share) ** 2)


def _z(x: Floats, a: float, b: float) -> Floats:
    return np.where(x > a, _s(-x, -b, -a), 1.0)


#: Shapes of .fis, for MATLAB and Octave.
FIS = {
    "trimf": Curve(lambda x, a, b, c: _trapezoid(x, a, b, b, c), 3, (0, 1, 2), reaches=True),
    "trapmf": Curve(_trapezoid, 4, (0, 1, 2, 3), reaches=True),
    "linsmf": Curve(_rising, 2, (0, 1)),
    "linzmf": Curve(_falling, 2, (0, 1)),
    "gaussmf": Curve(lambda x, s, c: _gaussian(x, c, s), 2, (1,)),
    "gauss2mf": Curve(lambda x, s, c, r, d: _two_gaussians(x, c, s, d, r), 4, (1, 3)),
    "gbellmf": Curve(lambda x, a, b, c: _bell(x, c, a, b), 3, (2,)),
    "sigmf": Curve(lambda x, a, c: sigmoid(x, c, a), 2, (1,)),
    "dsigmf": Curve(
        lambda x, a, c, b, d: np.abs(sigmoid(x, c, a) - sigmoid(x, d, b)), 4, (1, 3), falls=True
    ),
    "psigmf": Curve(
        lambda x, a, c, b, d: sigmoid(x, c, a) * sigmoid(x, d, b), 4, (1, 3), falls=True
    ),
    "smf": Curve(_s, 2, (0, 1)),
    "zmf": Curve(_z, 2, (0, 1)),
    "pimf": Curve(lambda x, a, b, c, d: np.minimum(_s(x, a, b), _z(x, c, d)), 4, (0, 1, 2, 3)),
}
#: Shapes of FLL.
FLL = {
    "Triangle": FIS["trimf"],
    "Trapezoid": FIS["trapmf"],
    "Rectangle": Curve(lambda x, a, b: _trapezoid(x, a, a, b, b), 2, (0, 1), reaches=True),
    "Ramp": Curve(
        lambda x, a, b: (_rising if a <= b else _falling)(x, *sorted((a, b))), 2, (0, 1), falls=True
    ),
    "Gaussian": Curve(_gaussian, 2, (0,)),
    "GaussianProduct": Curve(_two_gaussians, 4, (0, 2)),
    "Bell": Curve(_bell, 3, (0,)),
    "Sigmoid": Curve(sigmoid, 2, (0,)),
    "SShape": FIS["smf"],
    "ZShape": FIS["zmf"],
    "PiShape": FIS["pimf"],
}


#: Weighted defuzzifiers that divide by the sum of firing strengths; the others do not.
AVERAGES = ("wtaver", "WeightedAverage")
#: Largest number of degrees, at all points of the output, that are computed together.
AT_ONCE = 2_000_000
#: Smaller differences of degrees, and of shares of an area, count as rounding errors.
TIE, AREA = 1e-14, 1e-12

T = TypeVar("T")
Norm = Callable[[Floats, Floats], Floats]
#: Norms by their names in .fis and FLL.
NORMS: dict[str, Norm] = {
    **dict.fromkeys(("min", "Minimum"), np.minimum),
    **dict.fromkeys(("prod", "AlgebraicProduct"), np.multiply),
    "BoundedDifference": lambda a, b: np.where(a + b - 1.0 > TIE, a + b - 1.0, 0.0),
    **dict.fromkeys(("max", "Maximum"), np.maximum),
    **dict.fromkeys(("probor", "algebraic_sum", "AlgebraicSum"), lambda a, b: a + b - a * b),
    "BoundedSum": lambda a, b: np.minimum(a + b, 1.0),
    **dict.fromkeys(("sum", "UnboundedSum", "none"), np.add),
}
#: Hedge before a term in FLL, or "any" in place of a term -> function of the degree.
HEDGES: dict[str, Callable[[Floats], Floats]] = {
    "not": lambda degree: 1.0 - degree,
    "very": np.square,
    "somewhat": np.sqrt,
    "extremely": lambda x: np.where(x <= 0.5, 2.0 * x**2, 1.0 - 2.0 * (1.0 - x) ** 2),
    "seldom": lambda x: np.where(x <= 0.5, np.sqrt(0.5 * x), 1.0 - np.sqrt(0.5 * np.abs(1.0 - x))),
    "any": np.ones_like,
}


class Term(NamedTuple):
    """Term: its degree as a function, and the positions where its shape begins, bends or ends."""

    label: Token
    degree: Callable[[Floats], Floats]
    places: list[float]


def term_of(label: Token, curve: Curve, numbers: Sequence[float]) -> Term:
    """Return a term of a shape; ValueError: positions descend, or a number is invalid."""
    places = [numbers[k] for k in curve.places]
    widths = [number for k, number in enumerate(numbers) if k not in curve.places]
    rising = all(a <= b for a, b in pairwise(places)) or curve.falls
    if not rising or not all(widths):
        raise label.fault(f"term {label.text}: its corners must rise, its widths must not be 0")
    begin, end = places[(len(places) - 1) // 2], places[len(places) // 2]  # of its top
    if not (all(map(isfinite, numbers)) or (curve.reaches and begin < inf and end > -inf)):
        raise label.fault(f"term {label.text}: only straight flanks may reach to -inf or inf")
    return Term(label, lambda x: curve.degree(x, *numbers), places)


#: (first input, second input, degree) -> number, for a Sugeno term.
Conclusion = Callable[[Floats, Floats, Floats], Floats]


def plane(a: float, b: float, c: float) -> Conclusion:
    """Return the conclusion a x + b y + c."""
    return lambda x, y, _: a * x + b * y + c


class Variable(NamedTuple):
    """Input or output variable."""

    name: Token
    low: float
    high: float
    terms: list[Term]


class Clause(NamedTuple):
    """Clause "input is term"; the first of ``hedges`` is the one next to the term."""

    input: int  # index
    term: int  # index
    hedges: Sequence[str] = ()


def folded(
    condition: Sequence[Clause | str],
    leaf: Callable[[Clause], T],
    joins: dict[str, Callable[[T, T], T]],
) -> T:
    """Return the value of a postfix condition: ``leaf`` evaluates clauses, ``joins`` join two."""
    waiting: list[T] = []
    for part in condition:
        joined = joins[part](waiting.pop(), waiting.pop()) if isinstance(part, str) else leaf(part)
        waiting.append(joined)
    return waiting.pop()


class Rule(NamedTuple):
    """Rule: if a condition holds, the output is a term."""

    condition: Sequence[Clause | str]  # postfix: "and" and "or" follow what they join
    term: int  # index of the output term
    hedges: Sequence[str]
    weight: float

    def speaks_of(self, terms: tuple[int, int]) -> bool:
        """True if the rule fires where these terms of both inputs are 1 and all others 0."""

        def holds(clause: Clause) -> bool:
            met = "any" in clause.hedges or terms[clause.input] == clause.term
            return met != (clause.hedges.count("not") % 2 == 1)

        return self.weight > 0.0 and folded(
            self.condition, holds, {"and": bool.__and__, "or": bool.__or__}
        )


class Methods(NamedTuple):
    """Methods that combine rules to an output."""

    conjunction: str
    disjunction: str
    implication: str
    aggregation: str
    defuzzifier: str
    places: Floats  # points in the range of the output
    shares: Floats  # weight of each point in an integral
    default: float  # the output where no rule fires; nan: it has none
    limits: tuple[float, float] = (-inf, inf)  # of the output, which is clipped to them


class RuleBase(NamedTuple):
    """Rule base of two inputs and one output, as in a file."""

    name: str  # of the whole; "": none
    inputs: tuple[Variable, Variable]
    output: Variable
    rules: list[Rule]
    methods: Methods
    #: Functions of the inputs, one for each term, if the output is Sugeno's.
    conclusions: Sequence[Conclusion] = ()
    notes: Sequence[str] = ()  # for the user

    def left_out(self) -> list[str]:
        """Return the pairs of terms without a rule, in words."""
        first, second = self.inputs
        return [
            f"{first.name.text} is {a.label.text} and {second.name.text} is {b.label.text}"
            for i, a in enumerate(first.terms)
            for j, b in enumerate(second.terms)
            if not any(rule.speaks_of((i, j)) for rule in self.rules)
        ]

    def outputs(self, first: Floats, second: Floats) -> Floats:
        """Return the (n,) output at inputs (n,); nan if no rule fires and there is no default."""
        step = max(1, AT_ONCE // max(1, len(self.methods.places)))
        parts = [slice(k, k + step) for k in range(0, len(first), step)]
        return np.concatenate([self._outputs((first[part], second[part])) for part in parts])

    def _outputs(self, values: tuple[Floats, Floats]) -> Floats:
        rules = self._grouped([self._firing(rule, values) for rule in self.rules])
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            outputs = self._averaged(rules, values) if self.conclusions else self._integrated(rules)
        outputs = np.where(np.isfinite(outputs), outputs, self.methods.default)
        return np.clip(outputs, *self.methods.limits)

    def _averaged(self, rules: list[tuple[Rule, Floats]], values: tuple[Floats, Floats]) -> Floats:
        total = sum((degree for _, degree in rules), np.zeros_like(values[0]))
        weighted = [degree * self.conclusions[rule.term](*values, degree) for rule, degree in rules]
        average = sum(weighted, np.zeros_like(total)) / total
        return average if self.methods.defuzzifier in AVERAGES else average * total

    def _integrated(self, rules: list[tuple[Rule, Floats]]) -> Floats:
        methods = self.methods
        norm, implied = NORMS[methods.aggregation], NORMS[methods.implication]
        whole = np.zeros((len(rules[0][1]), len(methods.places)))
        for rule, degree in rules:
            shape = hedged(self.output.terms[rule.term].degree(methods.places), rule.hedges)
            whole = norm(whole, implied(degree[:, None], shape))
        integrated = DEFUZZIFIERS[methods.defuzzifier](whole, methods.places, methods.shares)
        return np.where((whole > 0.0).any(axis=1), integrated, np.nan)

    def _grouped(self, firing: list[Floats]) -> list[tuple[Rule, Floats]]:
        """Return rules with firing strengths, merged by conclusion if the output stays the same.

        Rules with the same Sugeno term are aggregated, as in fuzzylite from version 8 on.
        """
        each = zip(self.rules, firing, strict=True)
        if not (self.conclusions or self.methods.aggregation in ("max", "Maximum")):
            return list(each)
        norm = NORMS[self.methods.aggregation]
        groups: dict[tuple[int, tuple[str, ...]], tuple[Rule, Floats]] = {}
        for rule, degree in each:
            key = rule.term, tuple(rule.hedges)
            groups[key] = rule, norm(groups[key][1], degree) if key in groups else degree
        return list(groups.values())

    def _firing(self, rule: Rule, values: tuple[Floats, Floats]) -> Floats:
        def degree(clause: Clause) -> Floats:
            term = self.inputs[clause.input].terms[clause.term]
            return hedged(term.degree(values[clause.input]), clause.hedges)

        by = {"and": self.methods.conjunction, "or": self.methods.disjunction}
        joins = {word: NORMS[norm] for word, norm in by.items() if norm in NORMS}
        return rule.weight * folded(rule.condition, degree, joins)


def hedged(degree: Floats, hedges: Sequence[str]) -> Floats:
    """Return the degree changed by the hedges, one after another."""
    for hedge in hedges:
        degree = HEDGES[hedge](degree)
    return degree


def _centroid(degrees: Floats, places: Floats, shares: Floats) -> Floats:
    weighted = degrees * shares
    return np.asarray(weighted @ places / weighted.sum(axis=1))


def _bisector(degrees: Floats, places: Floats, shares: Floats) -> Floats:
    """Return the point that best divides the area in half; if several do, their mean."""
    area = np.cumsum(degrees * shares, axis=1)
    off = np.abs(area / area[:, -1:] - 0.5)
    return _mean(off <= off.min(axis=1, keepdims=True) + AREA, places)


def _mean(chosen: Mask, places: Floats) -> Floats:
    return np.asarray(chosen @ places / chosen.sum(axis=1))


def _highest(degrees: Floats) -> Mask:
    return np.asarray(degrees >= (1.0 - TIE) * degrees.max(axis=1, keepdims=True))


#: Name in .fis or FLL -> function: degrees (n, points), points, weights -> output (n,).
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
