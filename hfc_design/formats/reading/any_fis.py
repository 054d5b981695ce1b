"""Reads any .fis of two inputs and one output as what it computes, Mamdani or Sugeno."""

import re
from math import nan

import numpy as np

from hfc_design.formats.reading.fis import (
    RULE,
    checked_sections,
    corners_of,
    notes_on,
    numbers_in,
    numbers_of,
    terms_in,
    unquoted,
)
from hfc_design.formats.reading.inference import FIS as CURVES
from hfc_design.formats.reading.inference import (
    Clause,
    Conclusion,
    Methods,
    Rule,
    RuleBase,
    Term,
    Variable,
    plane,
    sigmoid,
    term_of,
)
from hfc_design.formats.reading.system import ALLOWED, Block, Token

ANY = ALLOWED["fis-sampled"]
METHODS = ("AndMethod", "OrMethod", "ImpMethod", "AggMethod", "DefuzzMethod")
#: Places of an output at which evalfis has its degrees; degrees that differ by less are the same.
PLACES, SAME = 101, 1e-9


def is_mamdani(text: str) -> bool:
    """Whether its output has terms with a shape, so that a table of it is a sample."""
    return bool(re.search(r"^\s*Type\s*=\s*['\"]?mamdani\b", text, re.MULTILINE | re.IGNORECASE))


def rule_base(text: str, wanted: str | None = None) -> RuleBase:
    """The two-input system in ``text``, Mamdani's or Sugeno's, of outputs the ``wanted`` one.

    Integrals as Octave's evalfis takes them: trapezia between 101 places; MATLAB's counts the
    first and the last place twice as much.

    Raises:
        ValueError: it is no .fis, or more than can be sampled.
    """
    mamdani = is_mamdani(text)
    head, *inputs, output, rules = checked_sections(
        text, ANY[f"System-{'mamdani' if mamdani else 'sugeno'}"], wanted
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
    aggregation = aggregation if mamdani else "sum"
    by = conjunction, disjunction, implication, aggregation, defuzzifier
    methods = Methods(*by, places, shares, default=nan)
    counts = [len(found.terms) for found in (first, second, told)]
    found = [_rule(rule, counts, mamdani) for _, rule in rules.entries]
    name = unquoted(head.get("Name")).text
    base = RuleBase(name, (first, second), told, found, methods, conclusions)
    if mamdani:
        return base
    values = [value.text for _, _, value in terms_in(output)]
    return base._replace(notes=notes_on(head, [values[rule.term] for rule in found]))


def _variable(section: Block, shaped: bool = True) -> Variable:
    low, high = numbers_of(section.get("Range", "[]" if shaped else "[-inf inf]"), 2, shaped)
    if shaped and not low < high:
        raise section.name.fault(f"[{section.name.text}]: its range has to rise")
    terms = []
    for label, kind, value in terms_in(section):
        if not shaped:
            terms.append(Term(label, np.ones_like, []))
            continue
        curve = CURVES[kind.one_of(f"shape of the term {label.text}", CURVES)]
        numbers = corners_of(kind.text, value, curve.needs)
        terms.append(term_of(label, curve, numbers))
        if kind.text == "dsigmf":
            places = np.linspace(low, high, 10 * PLACES)
            if (sigmoid(places, *numbers[1::-1]) < sigmoid(places, *numbers[:1:-1]) - SAME).any():
                told = ": where its second sigmoid is the higher one Octave has 0 and MATLAB not"
                raise label.fault(f"term {label.text}{told}")
    if not terms:
        raise section.name.fault(f"[{section.name.text}] has no terms")
    return Variable(unquoted(section.get("Name")), low, high, terms)


def _conclusion(label: Token, kind: Token, value: Token) -> Conclusion:
    """A Sugeno term: a number, or numbers for the inputs and one more."""
    kind.one_of(f"kind of the output term {label.text}", ("constant", "linear"))
    if kind.text == "constant":
        return plane(0.0, 0.0, *numbers_of(value, 1))
    return plane(*numbers_of(value, 3))


def _rule(rule: Token, counts: list[int], mamdani: bool) -> Rule:
    if not (found := rule.match(RULE)):
        raise rule.fault(f"{rule.text[:40]!r} is no rule of two inputs, as in 1 1, 1 (1) : 1")
    numbers = numbers_in(rule, found[:3])
    for number, count in zip(numbers, counts, strict=True):
        if abs(number) > count:
            raise rule.fault(f"term {number} in a rule; allowed is 1 to {count}, and 0 for any")
    if numbers[2] == 0 or not any(numbers[:2]):
        raise rule.fault("a rule needs a term of an input and one of the output")
    if numbers[2] < 0 and not mamdani:
        raise rule.fault(f"not before a conclusion, {numbers[2]}; of Sugeno terms there is none")
    weight = found[3]._replace(text=found[3].text.strip()).number()
    if not 0.0 <= weight <= 1.0:
        raise rule.fault(f"a rule of weight {weight:g}; allowed is 0 to 1")
    word = "and" if found[4].one_of("connection of a rule", ("1", "2")) == "1" else "or"
    said = [(abs(number) - 1, ["not"] if number < 0 else []) for number in numbers]
    clauses = [Clause(k, *said[k]) for k in (0, 1) if numbers[k]]
    return Rule([*clauses, *[word] * (len(clauses) - 1)], *said[2], weight)
