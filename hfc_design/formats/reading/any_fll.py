"""Reads any FLL of two inputs and one output as what it computes, Mamdani or Sugeno."""

import re
from collections.abc import Callable
from math import nan

import numpy as np

from hfc_design.core.numbers import Floats
from hfc_design.formats.reading.fll import COMMENT, TERM, ends_of, engine
from hfc_design.formats.reading.inference import (
    AVERAGES,
    DEFUZZIFIERS,
    HEDGES,
    Clause,
    Methods,
    Rule,
    RuleBase,
    Term,
    Variable,
    plane,
    term_of,
)
from hfc_design.formats.reading.shapes import FLL as CURVES
from hfc_design.formats.reading.system import ALLOWED, Block, Token, lines

ANY = ALLOWED["fll-sampled"]
#: What integrates over terms with a shape, in so many places; fuzzylite's own number of these.
INTEGRALS = [name for name in DEFUZZIFIERS if name[0].isupper()]
PLACES, MOST_PLACES = 1000, 10_000
#: What averages or adds the output's numbers.
WEIGHTED = [*(name for name in AVERAGES if name[0].isupper()), "WeightedSum"]
RULE = re.compile(r"if (.+) then (\S+) is (.+?)(?: with (\S+))?")
CLAUSE = re.compile(r"(\S+) is (.+)")


def is_mamdani(text: str) -> bool:
    """Whether its output has terms with a shape, so that a table of it is a sample."""
    for line in lines(text, COMMENT):
        key, _, value = line.text.partition(":")
        if key.strip() == "defuzzifier" and value.split()[:1] and value.split()[0] in INTEGRALS:
            return True
    return False


def rule_base(text: str) -> RuleBase:
    """The two-input engine in ``text``; integrals by midpoints, as fuzzylite takes them.

    Raises:
        ValueError: it is no FLL, or more than can be sampled.
    """
    head, first, second, output, rules = engine(text, ANY)
    inputs = _variable(first), _variable(second)
    told = output.get("defuzzifier")
    name, *more = told.words()
    name.one_of("defuzzifier", (*INTEGRALS, *WEIGHTED))
    shaped = name.text in INTEGRALS
    result = _variable(output, shaped)
    conclusions = [] if shaped else [_conclusion(term) for term in output.all("term")]
    count = _count(told, [word.text for word in more]) if shaped else 0
    by = (
        rules.get("conjunction").text,
        rules.get("disjunction", "none").text,
        rules.get("implication", "none").text,
        output.get("aggregation", "none").text,
    )
    if shaped and "none" in by[2:]:
        raise told.fault(f"{name.text} needs an implication and an aggregation, not none")
    shares: Floats = np.ones(count)
    width = result.high - result.low
    places = result.low + (shares.cumsum() - 0.5) * (width / max(count, 1))
    default = output.get("default", "nan")
    number = nan if default.text == "nan" else default.number()
    methods = Methods(*by, name.text, places, shares, number)
    variables = (*inputs, result)
    found = [_rule(rule, variables, by) for rule in rules.all("rule")]
    return RuleBase(head.name.text, inputs, result, found, methods, conclusions)


def _count(told: Token, words: list[str]) -> int:
    """Places of the output at which it is integrated."""
    if not words:
        return PLACES
    whole = len(words) == 1 and re.fullmatch("[0-9]{1,9}", words[0])
    if not whole or not 2 <= int(words[0]) <= MOST_PLACES:
        raise told.fault(f"defuzzifier: {told.text!r}; allowed are 2 to {MOST_PLACES} places")
    return int(words[0])


def _variable(block: Block, shaped: bool = True) -> Variable:
    low, high = ends_of(block)
    if not low < high:
        raise block.name.fault(f"{block.name.text}: its range has to rise")
    if shaped and not np.isfinite((low, high)).all():
        told = f"range of {block.name.text}: has to be finite, to be sampled"
        raise block.get("range").fault(told)
    terms = [_term(term, shaped) for term in block.all("term")]
    if not terms:
        raise block.name.fault(f"{block.name.text} has no terms")
    return Variable(block.name, low, high, terms)


def _term(term: Token, shaped: bool) -> Term:
    label, kind, rest = term.match(TERM)
    if not shaped:
        return Term(label, np.ones_like, [])
    curve = CURVES[kind.one_of(f"shape of the term {label.text}", CURVES)]
    numbers = [word.edge() for word in rest.words()]
    if len(numbers) == curve.needs + 1 and numbers.pop() != 1.0:
        raise term.fault(f"term {label.text}: only the height 1 can be imported")
    if len(numbers) != curve.needs:
        raise term.fault(f"term {label.text}: a {kind.text} has {curve.needs} numbers")
    return term_of(label, curve, numbers)


def _conclusion(term: Token) -> Callable[[Floats, Floats], Floats]:
    """A number, or numbers for the inputs and one more."""
    label, kind, rest = term.match(TERM)
    kind.one_of(f"kind of the output term {label.text}", ("Constant", "Linear"))
    numbers = [word.number() for word in rest.words()]
    count = 1 if kind.text == "Constant" else 3
    if len(numbers) != count:
        raise term.fault(f"term {label.text}: a {kind.text} has {count} numbers here")
    return plane(*numbers) if count == 3 else plane(0.0, 0.0, *numbers)


def _rule(rule: Token, variables: tuple[Variable, ...], by: tuple[str, ...]) -> Rule:
    if not (found := rule.match(RULE)):
        told = "is no rule, which is if INPUT is TERM and INPUT is TERM then OUTPUT is TERM"
        raise rule.fault(f"{rule.text[:60]!r} {told}")
    condition, target, conclusion, weight = found
    every, either = " and " in condition.text, " or " in condition.text
    if every and either:
        raise rule.fault("a rule with both and and or; one of them can be imported")
    if by[0 if every else 1] == "none" and (every or either):
        raise rule.fault("a rule that joins by a norm which the rule block has not: none")
    *inputs, output = variables
    target.one_of("output of the rule", (output.name.text,))
    names, clauses = [item.name.text for item in inputs], []
    for text in re.split(r" and | or ", condition.text):
        part = condition._replace(text=text.strip())
        if not (pair := part.match(CLAUSE)):
            raise part.fault(f"{text[:40]!r} is no INPUT is TERM")
        k = pair[0].place(names, "input")
        clauses.append(Clause(k, *_said(pair[1], inputs[k])))
    number = weight.number() if weight.text else 1.0
    if not 0.0 <= number <= 1.0:
        raise rule.fault(f"a rule of weight {number:g}; allowed is 0 to 1")
    term, hedges = _said(conclusion, output)
    if hedges:  # which fuzzylite would apply to how much the rule fires
        raise conclusion.fault(f"a hedge before a conclusion, {conclusion.text[:40]!r}")
    return Rule(clauses, not either, term, [], number)


def _said(text: Token, variable: Variable) -> tuple[int, list[str]]:
    """Place of a term, and the hedges before it, the nearest first."""
    *hedges, label = text.words()
    labels = [term.label.text for term in variable.terms]
    place = label.place(labels, f"term of {variable.name.text}")
    return place, [hedge.one_of("hedge", HEDGES) for hedge in reversed(hedges)]
