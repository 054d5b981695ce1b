"""Reads any .fis of two inputs and one output as what it computes, Mamdani or Sugeno."""

import re
from collections.abc import Callable
from math import nan

import numpy as np

from hfc_design.core.numbers import Floats
from hfc_design.formats.reading.fis import (
    RULE,
    check_count,
    checked_sections,
    numbers_of,
    terms_in,
    unquoted,
)
from hfc_design.formats.reading.inference import (
    Clause,
    Methods,
    Rule,
    RuleBase,
    Term,
    Variable,
    plane,
    term_of,
)
from hfc_design.formats.reading.shapes import FIS as CURVES
from hfc_design.formats.reading.system import ALLOWED, Block, Token

ANY = ALLOWED["fis-sampled"]
METHODS = ("AndMethod", "OrMethod", "ImpMethod", "AggMethod", "DefuzzMethod")
#: Places of an output at which evalfis has its degrees.
PLACES = 101


def is_mamdani(text: str) -> bool:
    """Whether its output has terms with a shape, so that a table of it is a sample."""
    return bool(re.search(r"^\s*Type\s*=\s*['\"]?mamdani\b", text, re.MULTILINE))


def rule_base(text: str) -> RuleBase:
    """The two-input system in ``text``, Mamdani's or Sugeno's.

    Integrals as Octave's evalfis takes them: trapezia between 101 places; MATLAB's counts the
    first and the last place twice as much.

    Raises:
        ValueError: it is no .fis, or more than can be sampled.
    """
    mamdani = is_mamdani(text)
    head, *inputs, output, rules = checked_sections(
        text, ANY[f"System-{'mamdani' if mamdani else 'sugeno'}"]
    )
    first, second = (_variable(section) for section in inputs)
    conclusions = [] if mamdani else [_conclusion(*term) for term in terms_in(output)]
    told = _variable(output) if mamdani else _variable(output, shaped=False)
    places = np.linspace(told.low, told.high, PLACES)
    shares = np.ones(PLACES)
    shares[[0, -1]] = 0.5
    conjunction, disjunction, implication, aggregation, defuzzifier = (
        unquoted(head.get(key)).text for key in METHODS
    )
    by = conjunction, disjunction, implication, aggregation, defuzzifier
    methods = Methods(*by, places, shares, default=nan)
    check_count(head, "NumRules", len(rules.entries))
    counts = [len(found.terms) for found in (first, second, told)]
    found = [_rule(rule, counts) for _, rule in rules.entries]
    return RuleBase(
        unquoted(head.get("Name")).text, (first, second), told, found, methods, conclusions
    )


def _variable(section: Block, shaped: bool = True) -> Variable:
    low, high = numbers_of(section.get("Range", "[]"), 2)
    if not low < high:
        raise section.name.fault(f"[{section.name.text}]: its range has to rise")
    terms = []
    for label, kind, value in terms_in(section):
        if not shaped:
            terms.append(Term(label, np.ones_like, []))
            continue
        curve = CURVES[kind.one_of(f"shape of the term {label.text}", CURVES)]
        terms.append(term_of(label, curve, numbers_of(value, curve.needs)))
    if not terms:
        raise section.name.fault(f"[{section.name.text}] has no terms")
    return Variable(unquoted(section.get("Name")), low, high, terms)


def _conclusion(label: Token, kind: Token, value: Token) -> Callable[[Floats, Floats], Floats]:
    """A Sugeno term: a number, or numbers for the inputs and one more."""
    kind.one_of(f"kind of the output term {label.text}", ("constant", "linear"))
    if kind.text == "constant":
        return plane(0.0, 0.0, *numbers_of(value, 1))
    return plane(*numbers_of(value, 3))


def _rule(rule: Token, counts: list[int]) -> Rule:
    if not (found := rule.match(RULE)):
        raise rule.fault(f"{rule.text[:40]!r} is no rule of two inputs, as in 1 1, 1 (1) : 1")
    numbers = [int(part.text) for part in found[:3]]
    for number, count in zip(numbers, counts, strict=True):
        if abs(number) > count:
            raise rule.fault(f"term {number} in a rule; allowed is 1 to {count}, and 0 for any")
    if numbers[2] == 0 or not any(numbers[:2]):
        raise rule.fault("a rule needs a term of an input and one of the output")
    weight = found[3]._replace(text=found[3].text.strip()).number()
    if not 0.0 <= weight <= 1.0:
        raise rule.fault(f"a rule of weight {weight:g}; allowed is 0 to 1")
    every = found[4].one_of("connection of a rule", ("1", "2")) == "1"
    said = [(abs(number) - 1, ["not"] if number < 0 else []) for number in numbers]
    clauses = [Clause(k, *said[k]) for k in (0, 1) if numbers[k]]
    return Rule(clauses, every, *said[2], weight)
