"""Reads the fuzzylite language (FLL) of fuzzylite and pyfuzzylite, versions 6 to 8.

An engine is blocks of ``key: value`` lines. Read is what a two-input unit of singletons can be:
product, weighted average, rules of weight 1. Whatever else would change the output is refused.
"""

import re

from hfc_design.formats.reading.system import (
    ALLOWED,
    GAUSSIANS,
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

KEYS = ALLOWED["fll"]
#: How many of each block a two-input unit has.
SUMS = ("none", "UnboundedSum")
COUNTS = {"InputVariable": 2, "OutputVariable": 1, "RuleBlock": 1}
NEEDED = {"OutputVariable": ("defuzzifier",), "RuleBlock": ("conjunction", "activation")}
#: Shape -> which of its numbers the ends are, see ``shape_of``.
SHAPES = {"Triangle": "abbc", "Trapezoid": "abcd", "Ramp": "ab++"}
SHAPES |= {"Gaussian": "baab", "GaussianProduct": "bacd"}
COMMENT = re.compile("()#.*")
TERM = re.compile(r"(\S*) ?(\S*) ?(.*)")
SINGLETON = re.compile(r"(\S+) Constant (\S+)")
RULE = re.compile(r"if (\S+) is (\S+) and (\S+) is (\S+) then (\S+) is (\S+)(?: with (\S+))?")


def read(text: str, wanted: str | None = None) -> System:
    """The system in ``text``; ValueError: it is not FLL, or more than a design can hold."""
    head, *inputs, output, rules = engine(text, KEYS, wanted)
    first, second = map(_input, inputs)
    singletons: dict[str, Singleton] = {}
    for term in output.all("term"):
        found = _singleton(term)
        if found.label in singletons:
            raise term.fault(f"term {found.label} stands twice in output {output.name.text}")
        singletons[found.label] = found
    named = Output(output.name.text, *ends_of(output), list(singletons))
    system = System(head.name.text, (first, second), named, {})
    for rule in rules.all("rule"):
        _add(system, rule, output.name.text, singletons)
    _check_sums(output, [singleton for _, singleton in system.rules.values()])
    return system


def _check_sums(output: Block, said: list[Singleton]) -> None:
    """Refuses what makes of the rules' numbers something else than their average."""
    lock, norm = output.get("lock-range"), output.get("aggregation", "none")
    low, high = ends_of(output)
    if lock.text == "true" and not all(low <= one.value <= high for one in said):
        raise lock.fault(f"lock-range = true cuts off what lies beyond {low:g} and {high:g}")
    if norm.text not in SUMS and len({one.label for one in said}) < len(said):
        raise norm.fault(f"aggregation = {norm.text} of rules that conclude the same")


def engine(text: str, allowed: dict[str, Allowed], wanted: str | None) -> list[Block]:
    """Head, two inputs, the ``wanted`` output, rules that conclude something of it.

    Raises:
        ValueError: there are others, or more is said.
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
            raise last.fault(f"{len(blocks[kind])} of {kind}; a two-input unit has {count}")
    head = (*blocks["Engine"], Block(Token(1, ""), []))[0]
    return [head, *(block for kind in COUNTS for block in blocks[kind])]


def _of_output(block: Block, name: str) -> list[tuple[str, Token]]:
    """The entries of a rule block without what they conclude of other outputs."""
    found = []
    for key, value in block.entries:
        condition, then, rest = value.text.partition(" then ")
        said, by, weight = rest.partition(" with ")
        parts = said.split(" and ")
        if len(parts) > 1 and any(len(part.split()) > 3 for part in parts):
            raise value.fault("a hedge before one of several conclusions cannot be imported")
        own = [part for part in parts if part.split(" is ")[0].strip() == name]
        if key != "rule" or own or not then:
            text = f"{condition}{then}{' and '.join(own)}{by}{weight}"
            found.append((key, value if key != "rule" else value._replace(text=text)))
    return found


def _blocks(text: str, allowed: dict[str, Allowed]) -> dict[str, list[Block]]:
    """The blocks of each kind."""
    blocks: dict[str, list[Block]] = {kind: [] for kind in KEYS}
    kind, block = "", None
    for line in lines(text, COMMENT):
        if not (pair := line.pair(":")):
            raise line.fault(f"{line.text[:40]!r} is no line of FLL, which is key: value")
        key, value = pair[0].text, pair[1]
        if key in KEYS:
            kind, block = key, Block(value, [])
            blocks[kind].append(block)
        elif block is None:
            raise line.fault(f"{key[:40]!r} stands before any block; an FLL starts with Engine:")
        else:
            value = value._replace(text=" ".join(value.text.split()))
            check_known(key, value, allowed[kind], f"{kind} {block.name.text}")
            if key not in ("term", "rule") and block.all(key):
                raise line.fault(f"{key} stands twice in {kind} {block.name.text}")
            block.entries.append((key, value))
    for kind, needed in NEEDED.items():
        for block in blocks[kind]:
            for key in needed:
                if not block.all(key):
                    raise block.name.fault(f"{kind} {block.name.text} has no {key}")
    return blocks


def ends_of(block: Block) -> tuple[float, float]:
    """The range of a variable; ValueError: it is not two numbers."""
    told = block.get("range", "-inf inf")
    ends = [word.edge() for word in told.words()]
    if len(ends) != 2:
        raise told.fault(f"range: {told.text!r} has to be two numbers")
    return ends[0], ends[1]


def _input(block: Block) -> Input:
    return input_of(block.name, *ends_of(block), [_shape(term) for term in block.all("term")])


def _shape(term: Token) -> Shape:
    label, kind, rest = term.match(TERM)
    letters = SHAPES[kind.one_of(f"shape of the term {label.text}", SHAPES)]
    numbers, count = [word.edge() for word in rest.words()], len(set(letters) - {"+"})
    if len(numbers) == count + 1 and numbers.pop() != 1.0:
        raise term.fault(f"term {label.text}: only the height 1 can be imported")
    if len(numbers) != count:
        raise term.fault(f"term {label.text}: a {kind.text} has {count} numbers")
    if kind.text in GAUSSIANS:
        numbers = [word.number() for word in rest.words()[:count]]
    if kind.text == "Ramp" and numbers[0] >= numbers[1]:
        letters = "--ba"  # it falls
    return shape_of(label, kind.text, letters, numbers)


def _singleton(term: Token) -> Singleton:
    if not (found := term.match(SINGLETON)):
        told = f"output term {term.text[:40]!r}: only NAME Constant NUMBER can be imported"
        raise term.fault(told)
    return Singleton(found[0].text, found[1].number())


def _add(system: System, rule: Token, output: str, singletons: dict[str, Singleton]) -> None:
    names = [item.name.text for item in system.inputs]
    if not (found := rule.match(RULE)):
        raise rule.fault(
            f"rule {rule.text[:60]!r} cannot be imported, only: if {names[0]} is TERM and "
            f"{names[1]} is TERM then {output} is TERM"
        )
    *pairs, target, conclusion, weight = found
    if weight.text and weight.number() != 1.0:
        told = f"a rule of weight {weight.text} cannot be imported, only of weight 1"
        raise rule.fault(told)
    target.one_of("output of the rule", (output,))
    for name in pairs[::2]:
        name.place(names, "input")
    terms = {name.text: term for name, term in zip(pairs[::2], pairs[1::2], strict=True)}
    if sorted(terms) != sorted(names):
        raise rule.fault(f"a rule has to read both inputs, {names[0]} and {names[1]}")
    first, second = (
        terms[name].place(item.labels, f"term of {name}")
        for name, item in zip(names, system.inputs, strict=True)
    )
    conclusion.place(list(singletons), f"term of {output}")
    system.add(rule, (first, second), singletons[conclusion.text])
