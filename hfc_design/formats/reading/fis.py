"""Reader of .fis files of MATLAB's and Octave's fuzzy toolboxes.

``read`` accepts only Sugeno systems whose output terms are constants. ``rule_base`` reads any
system of two inputs, Mamdani or Sugeno, as the function that it computes.

A file has sections of ``Key=value`` lines. A line of [Rules], as ``1 2, 3 (1) : 1``, has the
numbers of the terms of both inputs and of the output, the weight, and 1 for "and".
"""

import re
from collections.abc import Sequence
from math import inf, nan

import numpy as np

from hfc_design.formats.reading import inference
from hfc_design.formats.reading.inference import FIS as CURVES
from hfc_design.formats.reading.inference import Clause, Rule, RuleBase, Term, Variable, sigmoid
from hfc_design.formats.reading.system import (
    ALLOWED,
    Allowed,
    Block,
    Input,
    Output,
    Shape,
    Singleton,
    System,
    Token,
    check_known,
    chosen,
    input_of,
    lines,
    shape_of,
)

SYSTEM = ALLOWED["fis"]["System"]
SECTIONS = ("System", "Input1", "Input2", "Output1", "Rules")
OUTPUT = re.compile(r"Output[1-9]\d?")
#: Shape -> which of its parameters are the ends, see ``shape_of``.
SHAPES = {"trimf": "abbc", "trapmf": "abcd", "linzmf": "--ab", "linsmf": "ab++"}
SHAPES |= {"gaussmf": "abba", "gauss2mf": "abdc"}
COMMENT = re.compile(r"""('[^']*'|"[^"]*")|^\s*#.*|%.*""")
SECTION = re.compile(r"\[(\w+)\]")
TERM = re.compile(r"'([^']*)'\s*:\s*'(\w+)'\s*,\s*(\[[^][]*\])")
RULE = re.compile(r"([^\s,]+)[\s,]+([^\s,]+)\s*,([^,()]+)\(([^()]*)\)\s*:\s*(\d+)", re.ASCII)
#: Number of a term: fuzzylite writes decimals; in Octave decimals other than 0 are hedges.
NUMBER = re.compile(r"(-?\d{1,9})(?:\.0*)?", re.ASCII)


def read(text: str, wanted: str | None = None) -> System:
    """Return the system in ``text``; ValueError: not .fis, or a design cannot represent it."""
    head, *inputs, output, rules = checked_sections(text, SYSTEM, wanted)
    first, second = map(_input, inputs)
    singletons = []
    for label, kind, value in terms_in(output):
        kind.one_of(f"kind of the output term {label.text}", ("constant",))
        singletons.append(Singleton(label.text, *numbers_of(value, 1)))
    output_name = unquoted(output.get("Name")).text
    low, high = numbers_of(output.get("Range", "[-inf inf]"), 2, finite=False)
    named = Output(output_name, low, high, [one.label for one in singletons])
    system = System(unquoted(head.get("Name")).text, (first, second), named, {})
    for _, rule in rules.entries:
        _add(system, rule, singletons)
    values = [singleton.value for _, singleton in system.rules.values()]
    return system._replace(notes=notes_on(head, values))


def notes_on(head: Block, conclusions: Sequence[object]) -> list[str]:
    """Return a note if programs treat Sugeno rules with the same conclusion differently."""
    method = unquoted(head.get("AggMethod", "sum")).text
    if method == "sum" or len({*conclusions}) == len(conclusions):
        return []
    same = "rules with the same conclusion are added as in MATLAB, not as in Octave"
    return [f"AggMethod {method}: {same}"]


def checked_sections(text: str, system: Allowed, wanted: str | None) -> list[Block]:
    """Return the sections in the order of ``SECTIONS``; of several outputs the ``wanted`` one.

    Each rule keeps only the term number of this output; rules without a term of it are left out.

    Raises:
        ValueError: the sections contain something that is not allowed.
        UserError: there is no such output.
    """
    sections = _sections(text)
    for name in SECTIONS:
        if name not in sections:
            needed = ", ".join(SECTIONS)
            raise Token(1, "").fault(f"section [{name}] is missing; needed are {needed}")
    head = sections["System"]
    for k, (key, value) in enumerate(head.entries):
        if key.endswith(("Type", "Method")):
            head.entries[k] = key, (value := value._replace(text=value.text.lower()))
        check_known(key, unquoted(value), system, "[System]")
    for key, allowed in system.items():
        if allowed and not head.all(key):
            raise head.name.fault(f"[System] must have {key}='{allowed[0]}'")
    outputs = [sections[name] for name in sections if OUTPUT.fullmatch(name)]
    check_count(head, "NumOutputs", len(outputs))
    check_count(head, "NumRules", len(sections["Rules"].entries))
    k = chosen([unquoted(section.get("Name")) for section in outputs], wanted)
    rules = [_of_output(rule, len(outputs), k) for _, rule in sections["Rules"].entries]
    checked = Block(sections["Rules"].name, [("", rule) for rule in rules if rule])
    return [head, sections["Input1"], sections["Input2"], outputs[k], checked]


def _of_output(rule: Token, count: int, k: int) -> Token | None:
    """Return a rule with only output ``k`` of ``count``, from 0 on; None without a term of it."""
    if count == 1 or not (match := rule.match(RULE)):
        return rule
    first, second, numbers, weight, connection = match
    terms = numbers.words()
    if len(terms) != count:
        raise rule.fault(f"a rule must name terms of {count} outputs (got {len(terms)})")
    text = f"{first.text} {second.text}, {terms[k].text} ({weight.text}) : {connection.text}"
    return rule._replace(text=text) if numbers_in(rule, terms[k : k + 1]) != [0] else None


def numbers_in(rule: Token, tokens: Sequence[Token]) -> list[int]:
    """Return ``tokens`` of a rule as term numbers; ValueError: one is not a whole number."""
    numbers = []
    for part in tokens:
        whole = part._replace(text=part.text.strip()).match(NUMBER)
        if not whole:
            message = f"the number of a term must be whole (got {part.text.strip()[:20]})"
            raise rule.fault(f"{message}; decimals are hedges, which only Octave has")
        numbers.append(int(whole[0].text))
    return numbers


def _sections(text: str) -> dict[str, Block]:
    """Return name -> section; rules have the key ""."""
    sections: dict[str, Block] = {}
    current, seen = None, set()
    for line in lines(text, COMMENT):
        if title := line.match(SECTION):
            name = title[0].text
            if not OUTPUT.fullmatch(name):
                title[0].one_of("section", SECTIONS)
            if name in sections:
                raise line.fault(f"section [{name}] is given twice")
            current = sections[name] = Block(title[0], [])
        elif current is None:
            raise line.fault(f"{line.text[:40]!r} must come after a section, [System] first")
        elif current is sections.get("Rules"):
            current.entries.append(("", line))
        elif pair := line.pair("="):
            if (current.name.text, pair[0].text) in seen:
                raise line.fault(f"{pair[0].text} is given twice")
            seen.add((current.name.text, pair[0].text))
            current.entries.append((pair[0].text, pair[1]))
        else:
            raise line.fault(f"{line.text[:40]!r} must be Key=value")
    return sections


def unquoted(value: Token) -> Token:
    """Return a text without its quotes."""
    return value._replace(text=value.text.strip("'\""))


def _input(section: Block) -> Input:
    low, high = numbers_of(section.get("Range", "[]"), 2)
    shapes = [_shape(*term) for term in terms_in(section)]
    return input_of(unquoted(section.get("Name")), low, high, shapes)


def _shape(label: Token, kind: Token, value: Token) -> Shape:
    letters = SHAPES[kind.one_of(f"shape of the term {label.text}", SHAPES)]
    numbers = corners_of(kind.text, value, len(set(letters) - {"-", "+"}))
    return shape_of(label, kind.text, letters, numbers)


def terms_in(section: Block) -> list[list[Token]]:
    """Return label, shape and parameters of each term, MF1 first."""
    terms: list[list[Token]] = []
    for key, value in section.entries:
        if key in ("Name", "Range", "NumMFs"):
            continue
        term = value.match(TERM)
        if key != f"MF{len(terms) + 1}" or not term:
            wanted = f"MF{len(terms) + 1}='NAME':'SHAPE',[NUMBERS]"
            message = f"{key[:20]}={value.text[:40]} cannot be imported"
            quotes = ", names between apostrophes" * ("'" not in value.text)
            raise value.fault(f"{message}; must be {wanted}{quotes}")
        terms.append(term)
    check_count(section, "NumMFs", len(terms))
    return terms


def check_count(section: Block, key: str, count: int) -> None:
    """Check that ``key`` of a section states the right ``count``; ValueError: it does not."""
    value = section.get(key)
    if value.text != str(count):
        raise value.fault(f"{key} must be {count}, the number that follow (got {value.text[:20]})")


def numbers_of(value: Token, count: int, finite: bool = True) -> list[float]:
    """Return ``count`` numbers between brackets; ValueError: there are not that many."""
    inner = value._replace(text=value.text.strip("[]").replace(",", " "))
    numbers = [word.number() if finite else word.edge() for word in inner.words()]
    if len(numbers) != count:
        raise value.fault(f"{value.text[:60]} must be {count} numbers")
    return numbers


def corners_of(kind: str, value: Token, count: int) -> list[float]:
    """Return a term's parameters; in a trapezium both ends of a flank may be infinite together."""
    numbers = numbers_of(value, count, finite=kind != "trapmf")
    a, b, c, d = numbers if kind == "trapmf" else (0.0, 0.0, 0.0, 0.0)
    if (a == -inf) != (b == -inf) or (c == inf) != (d == inf):
        raise value.fault(f"{value.text[:60]}: a flank must not be infinitely long")
    return numbers


def _add(system: System, rule: Token, singletons: list[Singleton]) -> None:
    if not (match := rule.match(RULE)):
        raise rule.fault(f"{rule.text[:40]!r} must be a rule of two inputs, as in 1 1, 1 (1) : 1")
    first, second, conclusion = numbers_in(rule, match[:3])
    weight = match[3]._replace(text=match[3].text.strip())
    if weight.number() != 1.0:
        raise rule.fault(f"the weight of a rule must be 1 (got {match[3].text})")
    match[4].one_of("connection of a rule", ("1",))
    counts = [*(len(item.labels) for item in system.inputs), len(singletons)]
    for term, count in zip((first, second, conclusion), counts, strict=True):
        if not 1 <= term <= count:
            raise rule.fault(f"the term of a rule must be 1 to {count} (got {term})")
    system.add(rule, (first - 1, second - 1), singletons[conclusion - 1])


METHODS = ("AndMethod", "OrMethod", "ImpMethod", "AggMethod", "DefuzzMethod")
#: Number of points of an output at which evalfis computes; smallest difference of degrees.
PLACES, SAME = 101, 1e-9


def is_mamdani(text: str) -> bool:
    """True if output terms have shapes, so that a rule table can only sample the output."""
    return bool(re.search(r"^\s*Type\s*=\s*['\"]?mamdani\b", text, re.MULTILINE | re.IGNORECASE))


def rule_base(text: str, wanted: str | None = None) -> RuleBase:
    """Return the two-input Mamdani or Sugeno system in ``text``, with its ``wanted`` output.

    Integrals are computed as in Octave's evalfis, by the trapezoidal rule at 101 points; MATLAB's
    evalfis gives the first and the last point twice the weight.

    Raises:
        ValueError: ``text`` is not a .fis file, or its system cannot be sampled.
    """
    mamdani = is_mamdani(text)
    otherwise = ALLOWED["fis-sampled"][f"System-{'mamdani' if mamdani else 'sugeno'}"]
    head, *inputs, output, rules = checked_sections(text, SYSTEM | otherwise, wanted)
    first, second = (_variable(section) for section in inputs)
    conclusions = [] if mamdani else [_conclusion(*term) for term in terms_in(output)]
    result = _variable(output) if mamdani else _variable(output, shaped=False)
    ends = (result.low, result.high) if mamdani else (0.0, 1.0)  # a Sugeno range may be infinite
    places = np.linspace(*ends, PLACES)
    shares = np.ones(PLACES)
    shares[[0, -1]] = 0.5
    conjunction, disjunction, implication, aggregation, defuzzifier = (
        unquoted(head.get(key)).text for key in METHODS
    )
    aggregation = aggregation if mamdani else "sum"
    by = conjunction, disjunction, implication, aggregation, defuzzifier
    methods = inference.Methods(*by, places, shares, default=nan)
    counts = [len(variable.terms) for variable in (first, second, result)]
    listed = [_rule(rule, counts, mamdani) for _, rule in rules.entries]
    name = unquoted(head.get("Name")).text
    base = RuleBase(name, (first, second), result, listed, methods, conclusions)
    if mamdani:
        return base
    values = [value.text for _, _, value in terms_in(output)]
    return base._replace(notes=notes_on(head, [values[rule.term] for rule in listed]))


def _variable(section: Block, shaped: bool = True) -> Variable:
    low, high = numbers_of(section.get("Range", "[]" if shaped else "[-inf inf]"), 2, shaped)
    if shaped and not low < high:
        raise section.name.fault(f"[{section.name.text}]: its range must rise")
    terms = []
    for label, kind, value in terms_in(section):
        if not shaped:
            terms.append(Term(label, np.ones_like, []))
            continue
        curve = CURVES[kind.one_of(f"shape of the term {label.text}", CURVES)]
        numbers = corners_of(kind.text, value, curve.needs)
        terms.append(inference.term_of(label, curve, numbers))
        if kind.text == "dsigmf":
            places = np.linspace(low, high, 10 * PLACES)
            if (sigmoid(places, *numbers[1::-1]) < sigmoid(places, *numbers[:1:-1]) - SAME).any():
                message = ": where its second sigmoid is higher, Octave gives 0 and MATLAB does not"
                raise label.fault(f"term {label.text}{message}")
    if not terms:
        raise section.name.fault(f"[{section.name.text}] must have terms")
    return Variable(unquoted(section.get("Name")), low, high, terms)


def _conclusion(label: Token, kind: Token, value: Token) -> inference.Conclusion:
    """Return the conclusion of a Sugeno term: a constant, or a linear function of both inputs."""
    kind.one_of(f"kind of the output term {label.text}", ("constant", "linear"))
    if kind.text == "constant":
        return inference.plane(0.0, 0.0, *numbers_of(value, 1))
    return inference.plane(*numbers_of(value, 3))


def _rule(rule: Token, counts: list[int], mamdani: bool) -> Rule:
    if not (match := rule.match(RULE)):
        raise rule.fault(f"{rule.text[:40]!r} must be a rule of two inputs, as in 1 1, 1 (1) : 1")
    numbers = numbers_in(rule, match[:3])
    for number, count in zip(numbers, counts, strict=True):
        if abs(number) > count:
            allowed = f"must be 1 to {count}, or 0 for any (got {number})"
            raise rule.fault(f"the term of a rule {allowed}")
    if numbers[2] == 0 or not any(numbers[:2]):
        raise rule.fault("a rule must have a term of an input and one of the output")
    if numbers[2] < 0 and not mamdani:
        raise rule.fault(f"a Sugeno conclusion must not be negated (got {numbers[2]})")
    weight = match[3]._replace(text=match[3].text.strip()).number()
    if not 0.0 <= weight <= 1.0:
        raise rule.fault(f"the weight of a rule must be 0 to 1 (got {weight:g})")
    word = "and" if match[4].one_of("connection of a rule", ("1", "2")) == "1" else "or"
    said = [(abs(number) - 1, ["not"] if number < 0 else []) for number in numbers]
    clauses = [Clause(k, *said[k]) for k in (0, 1) if numbers[k]]
    return Rule([*clauses, *[word] * (len(clauses) - 1)], *said[2], weight)
