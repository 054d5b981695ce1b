"""Reader of the fuzzylite language (FLL) of fuzzylite and pyfuzzylite, versions 6 to 8.

An engine consists of blocks of ``key: value`` lines. ``read`` accepts engines of two inputs with
singletons, product, weighted average and rules of weight 1; it refuses anything else that would
change the output. ``rule_base`` reads any engine of two inputs as the function that it computes.
"""

import re
from collections.abc import Iterable, Sequence
from math import inf, nan

import numpy as np

from hfc_design.core.numbers import Floats
from hfc_design.formats.reading import inference
from hfc_design.formats.reading.inference import FLL as CURVES
from hfc_design.formats.reading.inference import Clause, Rule, RuleBase, Term, Variable
from hfc_design.formats.reading.system import (
    ALLOWED,
    GAUSSIANS,
    Allowed,
    Block,
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

KEYS = ALLOWED["fll"]
#: Aggregations that add; number of blocks of each kind; keys that blocks must have.
SUMS = ("none", "UnboundedSum")
COUNTS = {"InputVariable": 2, "OutputVariable": 1, "RuleBlock": 1}
NEEDED = {"OutputVariable": ("defuzzifier",), "RuleBlock": ("conjunction", "activation")}
#: Shape -> which of its parameters are the ends, see ``shape_of``.
SHAPES = {"Triangle": "abbc", "Trapezoid": "abcd", "Ramp": "ab++"}
SHAPES |= {"Gaussian": "baab", "GaussianProduct": "bacd"}
COMMENT = re.compile("()#.*")
TERM = re.compile(r"(\S*) ?(\S*) ?(.*)")
SINGLETON = re.compile(r"(\S+) Constant (\S+)")
RULE = re.compile(r"if (\S+) is (\S+) and (\S+) is (\S+) then (\S+) is (\S+)(?: with (\S+))?")


def read(text: str, wanted: str | None = None) -> System:
    """Return the system in ``text``; ValueError: not FLL, or a design cannot represent it."""
    head, *inputs, output, rules = engine(text, KEYS, wanted)
    first, second = (input_of(x.name, *ends_of(x), [*map(_shape, x.all("term"))]) for x in inputs)
    singletons: dict[str, Singleton] = {}
    for term in output.all("term"):
        if not (match := term.match(SINGLETON)):
            raise term.fault(f"output term {term.text[:40]!r}: must be NAME Constant NUMBER")
        value = Singleton(match[0].text, match[1].number())
        if value.label in singletons:
            raise term.fault(f"term {value.label} is given twice in output {output.name.text}")
        singletons[value.label] = value
    named = Output(output.name.text, *ends_of(output), list(singletons))
    system = System(head.name.text, (first, second), named, {})
    for rule in rules.all("rule"):
        _add(system, rule, output.name.text, singletons)
    _check_sums(output, [singleton for _, singleton in system.rules.values()])
    return system


def _check_sums(output: Block, said: list[Singleton]) -> None:
    """Raise ValueError if settings make the output more than a weighted average of rules."""
    lock, norm = output.get("lock-range"), output.get("aggregation", "none")
    low, high = ends_of(output)
    if lock.text == "true" and not all(low <= one.value <= high for one in said):
        raise lock.fault(f"lock-range = true limits the output to {low:g} to {high:g}")
    if norm.text not in SUMS and len({one.label for one in said}) < len(said):
        raise norm.fault(f"aggregation = {norm.text} of rules that conclude the same")


def engine(text: str, allowed: dict[str, Allowed], wanted: str | None) -> list[Block]:
    """Return the blocks: head, two inputs, the ``wanted`` output, and the rules about it.

    Raises:
        ValueError: there are other blocks or settings.
        UserError: there is no such output.
    """
    blocks = _blocks(text, allowed)
    if outputs := blocks["OutputVariable"]:
        names = [block.name for block in outputs]
        blocks["OutputVariable"] = [outputs[k := chosen(names, wanted)]]
        for block in blocks["RuleBlock"] if len(names) > 1 else []:
            block.entries[:] = _of_output(block, names[k].text)
    for kind, count in COUNTS.items():
        if len(blocks[kind]) != count:
            last = blocks[kind][-1].name if blocks[kind] else Token(1, "")
            raise last.fault(f"must have {count} of {kind} (got {len(blocks[kind])})")
    head = (*blocks["Engine"], Block(Token(1, ""), []))[0]
    return [head, *(block for kind in COUNTS for block in blocks[kind])]


def _of_output(block: Block, name: str) -> list[tuple[str, Token]]:
    """Return the entries of a rule block without their conclusions on other outputs."""
    clauses = []
    for key, value in block.entries:
        condition, then, rest = value.text.partition(" then ")
        said, by, weight = rest.partition(" with ")
        parts = said.split(" and ")
        if len(parts) > 1 and any(len(part.split()) > 3 for part in parts):
            raise value.fault("a hedge before one of several conclusions cannot be imported")
        about = [part for part in parts if part.split(" is ")[0].strip() == name]
        if key != "rule" or about or not then:
            text = f"{condition}{then}{' and '.join(about)}{by}{weight}"
            clauses.append((key, value if key != "rule" else value._replace(text=text)))
    return clauses


def _blocks(text: str, allowed: dict[str, Allowed]) -> dict[str, list[Block]]:
    """Return kind -> its blocks; ValueError: a line is not FLL, or its key is not ``allowed``."""
    blocks: dict[str, list[Block]] = {kind: [] for kind in KEYS}
    kind, block = "", None
    for line in lines(text, COMMENT):
        if not (pair := line.pair(":")):
            raise line.fault(f"{line.text[:40]!r} must be key: value")
        key, value = pair[0].text, pair[1]
        if key in KEYS:
            kind, block = key, Block(value, [])
            blocks[kind].append(block)
        elif block is None:
            raise line.fault(f"{key[:40]!r} must come after a block; an FLL starts with Engine:")
        else:
            value = value._replace(text=" ".join(value.text.split()))
            check_known(key, value, allowed[kind], f"{kind} {block.name.text}")
            if key not in ("term", "rule") and block.all(key):
                raise line.fault(f"{key} is given twice in {kind} {block.name.text}")
            block.entries.append((key, value))
    for kind, needed in NEEDED.items():
        for block in blocks[kind]:
            for key in needed:
                if not block.all(key):
                    raise block.name.fault(f"{kind} {block.name.text} must have {key}")
    return blocks


def ends_of(block: Block) -> tuple[float, float]:
    """Return the range of a variable; ValueError: it is not two numbers."""
    span = block.get("range", "-inf inf")
    ends = [word.edge() for word in span.words()]
    if len(ends) != 2:
        raise span.fault(f"range: {span.text!r} must be two numbers")
    return ends[0], ends[1]


def _numbers(term: Token, kinds: Iterable[str]) -> tuple[Token, str, list[float]]:
    """Return label, shape and parameters of a term; ValueError: its shape is not in ``kinds``."""
    label, kind, rest = term.match(TERM)
    count = CURVES[kind.one_of(f"term {label.text}: shape", kinds)].needs
    numbers = [word.edge() for word in rest.words()]
    if len(numbers) == count + 1 and numbers.pop() != 1.0:
        raise term.fault(f"term {label.text}: its height must be 1")
    if len(numbers) != count:
        raise term.fault(f"term {label.text}: a {kind.text} must have {count} numbers")
    return label, kind.text, numbers


def _shape(term: Token) -> Shape:
    label, kind, numbers = _numbers(term, SHAPES)
    if kind in GAUSSIANS:
        for word in term.match(TERM)[2].words()[: len(numbers)]:
            word.number()
    falls = kind == "Ramp" and numbers[0] >= numbers[1]
    return shape_of(label, kind, "--ba" if falls else SHAPES[kind], numbers)


def _add(system: System, rule: Token, output: str, singletons: dict[str, Singleton]) -> None:
    names = [item.name.text for item in system.inputs]
    if not (match := rule.match(RULE)):
        form = f"if {names[0]} is TERM and {names[1]} is TERM then {output} is TERM"
        raise rule.fault(f"rule {rule.text[:60]!r} cannot be imported; must be: {form}")
    *pairs, target, conclusion, weight = match
    if weight.text and weight.number() != 1.0:
        raise rule.fault(f"the weight of a rule must be 1 (got {weight.text})")
    target.one_of("output of the rule", (output,))
    terms = {
        name.place(names, "input"): term for name, term in zip(pairs[::2], pairs[1::2], strict=True)
    }
    if len(terms) < len(names):
        raise rule.fault(f"a rule must read both inputs, {names[0]} and {names[1]}")
    first, second = (
        terms[k].place(item.labels, f"term of {names[k]}") for k, item in enumerate(system.inputs)
    )
    conclusion.place(list(singletons), f"term of {output}")
    system.add(rule, (first, second), singletons[conclusion.text])


ANY = {kind: keys | ALLOWED["fll-sampled"].get(kind, {}) for kind, keys in KEYS.items()}
#: Defuzzifiers of terms with shapes; number of points: of fuzzylite by default, and the largest.
INTEGRALS = [name for name in inference.DEFUZZIFIERS if name[0].isupper()]
PLACES, MOST_PLACES = 1000, 10_000
#: Defuzzifiers that average or add the conclusions of rules.
WEIGHTED = [*(name for name in inference.AVERAGES if name[0].isupper()), "WeightedSum"]
WORD = re.compile(r"[()]|[^\s()]+")
SAMPLED_RULE = re.compile(r"if (.+) then (\S+) is (.+?)(?: with (\S+))?")
CLAUSE = re.compile(r"(\S+) is (.+)")


def is_mamdani(text: str) -> bool:
    """True if output terms have shapes, so that a rule table can only sample the output."""
    for line in lines(text, COMMENT):
        key, _, value = line.text.partition(":")
        if key.strip() == "defuzzifier" and value.split()[:1] and value.split()[0] in INTEGRALS:
            return True
    return False


def rule_base(text: str, wanted: str | None = None) -> RuleBase:
    """Return the two-input engine in ``text``, with the ``wanted`` one of its outputs.

    Integrals are computed by the midpoint rule, as in fuzzylite.

    Raises:
        ValueError: ``text`` is not FLL, or its engine cannot be sampled.
    """
    head, first, second, output, rules = engine(text, ANY, wanted)
    inputs = _variable(first), _variable(second)
    defuzzifier = output.get("defuzzifier")
    name, *more = defuzzifier.words()
    name.one_of("defuzzifier", (*INTEGRALS, *WEIGHTED))
    shaped = name.text in INTEGRALS
    result = _variable(output, shaped)
    kinds = {} if shaped else _kinds(defuzzifier, more, output)
    conclusions = [] if shaped else [_conclusion(term, kinds) for term in output.all("term")]
    count = _count(defuzzifier, [word.text for word in more]) if shaped else 0
    conjunction, disjunction, implication = (
        rules.get(key, "none").text for key in ("conjunction", "disjunction", "implication")
    )
    by = conjunction, disjunction, implication, output.get("aggregation", "none").text
    if shaped and "none" in by[2:]:
        raise defuzzifier.fault(f"{name.text} needs an implication and an aggregation (got none)")
    shares: Floats = np.ones(count)
    width = result.high - result.low
    places = result.low + (shares.cumsum() - 0.5) * (width / max(count, 1))
    default = output.get("default", "nan")
    number = nan if default.text == "nan" else default.number()
    locked = output.get("lock-range").text == "true"
    if locked and not result.low <= result.high:
        raise output.get("range").fault("lock-range = true of a range that falls")
    limits = (result.low, result.high) if locked else (-inf, inf)
    methods = inference.Methods(*by, name.text, places, shares, number, limits)
    listed = [_rule(rule, (*inputs, result), by) for rule in rules.all("rule")]
    if not listed:
        raise rules.name.fault("there are no rules")
    base = RuleBase(head.name.text, inputs, result, listed, methods, conclusions)
    if not shaped and by[3] not in SUMS and len({rule.term for rule in listed}) < len(listed):
        computed = "is computed as in fuzzylite 8; older versions add"
        return base._replace(notes=[f"{by[3]} of rules with the same conclusion {computed}"])
    return base


def _kinds(defuzzifier: Token, more: list[Token], output: Block) -> dict[str, int]:
    """Return the allowed kinds of a weighted output's terms, each with its number of parameters."""
    ramps = any(term.match(TERM)[1].text == "Ramp" for term in output.all("term"))
    kind = "Tsukamoto" if ramps else "TakagiSugeno"
    if [word.text for word in more] not in ([], ["Automatic"], [kind]):
        raise defuzzifier.fault(f"defuzzifier: {defuzzifier.text!r} of terms that are {kind}'s")
    return {"Ramp": 2} if ramps else {"Constant": 1, "Linear": 3}


def _count(defuzzifier: Token, words: list[str]) -> int:
    """Return the number of points for the integral of the output; ValueError: it is wrong."""
    if not words:
        return PLACES
    whole = len(words) == 1 and re.fullmatch("[0-9]{1,9}", words[0])
    if not whole or not 2 <= int(words[0]) <= MOST_PLACES:
        allowed = f"must have a resolution of 2 to {MOST_PLACES} (got {defuzzifier.text!r})"
        raise defuzzifier.fault(f"defuzzifier: {allowed}")
    return int(words[0])


def _variable(block: Block, shaped: bool = True) -> Variable:
    low, high = ends_of(block)
    if shaped and not low < high:
        raise block.name.fault(f"{block.name.text}: its range must rise")
    if shaped and not np.isfinite((low, high)).all():
        message = f"range of {block.name.text}: must be finite, to be sampled"
        raise block.get("range").fault(message)
    terms = [_term(term, shaped) for term in block.all("term")]
    if not terms:
        raise block.name.fault(f"{block.name.text} must have terms")
    labels = [term.label.text for term in terms]
    if twice := next((term for k, term in enumerate(terms) if labels[k] in labels[:k]), None):
        raise twice.label.fault(f"term {twice.label.text} is given twice in {block.name.text}")
    return Variable(block.name, low, high, terms)


def _term(term: Token, shaped: bool) -> Term:
    if not shaped:
        return Term(term.match(TERM)[0], np.ones_like, [])
    label, kind, numbers = _numbers(term, CURVES)
    if kind == "Ramp" and numbers[0] == numbers[1]:
        raise term.fault(f"term {label.text}: a Ramp must rise or fall")
    return inference.term_of(label, CURVES[kind], numbers)


def _conclusion(term: Token, kinds: dict[str, int]) -> inference.Conclusion:
    """Return a conclusion: a number, a linear function of the inputs, or the inverse of a ramp."""
    label, kind, rest = term.match(TERM)
    kind.one_of(f"kind of the output term {label.text}", kinds)
    numbers = [word.number() for word in rest.words()]
    if kind.text == "Linear" and len(numbers) == 2:
        numbers.append(0.0)
    if len(numbers) != kinds[kind.text]:
        raise term.fault(f"term {label.text}: a {kind.text} must have {kinds[kind.text]} numbers")
    if kind.text == "Ramp":
        start, end = numbers
        return lambda _x, _y, degree: start + (end - start) * degree
    return inference.plane(*[0.0, 0.0, *numbers][-3:])


def _rule(rule: Token, variables: tuple[Variable, ...], by: Sequence[str]) -> Rule:
    if not (match := rule.match(SAMPLED_RULE)):
        message = "must be if INPUT is TERM and INPUT is TERM then OUTPUT is TERM"
        raise rule.fault(f"{rule.text[:60]!r} {message}")
    condition, target, conclusion, weight = match
    *inputs, output = variables
    target.one_of("output of the rule", (output.name.text,))
    number = weight.number() if weight.text else 1.0
    if not 0.0 <= number <= 1.0:
        raise rule.fault(f"the weight of a rule must be 0 to 1 (got {number:g})")
    term, hedges = _said(conclusion, output)
    if hedges:  # fuzzylite would apply it to the firing strength
        got = f"(got {conclusion.text[:40]!r})"
        raise conclusion.fault(f"a hedge before a conclusion is not allowed {got}")
    return Rule(_condition(condition, inputs, by), term, [], number)


def _condition(condition: Token, inputs: list[Variable], by: Sequence[str]) -> list[Clause | str]:
    """Return clauses in postfix order, "and" and "or" behind what they join; "and" binds closer."""
    clauses: list[Clause | str] = []
    waiting, words, before = ["("], [], ""
    for text in [*WORD.findall(condition.text), ")"]:
        if text not in ("and", "or", ")", "("):
            words.append(text)
            continue
        if (text == "(" and words) or (text != "(" and bool(words) == (before == ")")):
            wanted = f"before {text!r} must be INPUT is TERM"
            raise condition.fault(f"{wanted} (got {' '.join([before, *words]).strip()[:40]!r})")
        if words:
            clauses.append(_clause(condition._replace(text=" ".join(words)), inputs))
        ahead = {"(": (), "and": ("and",)}.get(text, ("and", "or"))
        while waiting and waiting[-1] in ahead:
            clauses.append(waiting.pop())
        if text == ")" and not waiting:
            raise condition.fault("a bracket closes without an opening one")
        waiting[len(waiting) - (text == ")") :] = [] if text == ")" else [text]
        if text in ("and", "or") and by[text == "or"] == "none":
            raise condition.fault(f"{text} needs a norm of the rule block (got none)")
        words, before = [], text
    if waiting:
        raise condition.fault("a bracket is not closed")
    return clauses


def _clause(text: Token, inputs: list[Variable]) -> Clause:
    if not (pair := text.match(CLAUSE)):
        raise text.fault(f"{text.text[:40]!r} must be INPUT is TERM")
    k = pair[0].place([item.name.text for item in inputs], "input")
    return Clause(k, *_said(pair[1], inputs[k]))


def _said(text: Token, variable: Variable) -> tuple[int, list[str]]:
    """Return the index of a term, and its hedges, first the one next to the term."""
    *hedges, label = text.words()
    place = 0
    if label.text == "any":  # it stands without a term
        hedges.append(label)
    else:
        labels = [term.label.text for term in variable.terms]
        place = label.place(labels, f"term of {variable.name.text}")
    return place, [hedge.one_of("hedge", inference.HEDGES) for hedge in reversed(hedges)]
