"""Reads the fuzzylite language (FLL) of fuzzylite and pyfuzzylite, versions 6 to 8.

An engine is blocks of ``key: value`` lines. Read is what a two-input unit of singletons can be:
product, weighted average, rules of weight 1. Whatever else would change the output is refused.
"""

import re
from math import inf
from typing import NamedTuple

from hfc_design.formats.reading.system import (
    ALLOWED,
    Input,
    Shape,
    System,
    add_rule,
    edge,
    fault,
    flat_gaussian,
    input_of,
    known,
    number,
    one_of,
    place,
    trapezoid,
)

KEYS = ALLOWED["fll"]
#: How many of each block a two-input unit has.
COUNTS = {"InputVariable": 2, "OutputVariable": 1, "RuleBlock": 1}
NEEDED = {"OutputVariable": ("defuzzifier",), "RuleBlock": ("conjunction", "activation")}
RULE = re.compile(r"if (\S+) is (\S+) and (\S+) is (\S+) then (\S+) is (\S+)(?: with (\S+))?")
#: Term -> how many numbers it has.
SHAPES = {"Triangle": 3, "Trapezoid": 4, "Ramp": 2, "Gaussian": 2, "GaussianProduct": 4}


class Block(NamedTuple):
    """A block and its lines as (line, key, value)."""

    line: int
    kind: str
    name: str
    lines: list[tuple[int, str, str]]

    def values(self, key: str) -> list[tuple[int, str]]:
        """Line and value of each ``key``."""
        return [(line, value) for line, found, value in self.lines if found == key]


def read(text: str) -> System:
    """The system in ``text``; ValueError: it is not FLL, or more than a design can hold."""
    blocks: dict[str, list[Block]] = {kind: [] for kind in KEYS}
    for block in _blocks(text):
        blocks[block.kind].append(block)
    for kind, count in COUNTS.items():
        if len(blocks[kind]) != count:
            last = blocks[kind][-1].line if blocks[kind] else 1
            raise fault(last, f"{len(blocks[kind])} of {kind}; a two-input unit has {count}")
    first, second = map(_input, blocks["InputVariable"])
    (output,), (rules,) = blocks["OutputVariable"], blocks["RuleBlock"]
    system = System((first, second), {})
    singletons = dict(_singleton(line, value) for line, value in output.values("term"))
    for line, rule in rules.values("rule"):
        _add(system, line, rule, output.name, singletons)
    return system


def _blocks(text: str) -> list[Block]:
    blocks: list[Block] = []
    for line, content in enumerate(text.splitlines(), 1):
        stripped = content.split("#")[0].strip()
        if not stripped:
            continue
        key, colon, value = (part.strip() for part in stripped.partition(":"))
        if not colon:
            raise fault(line, f"{stripped[:40]!r} is no line of FLL, which is key: value")
        if key in KEYS:
            blocks.append(Block(line, key, value, []))
        elif not blocks:
            raise fault(line, f"{key[:40]!r} stands before any block; an FLL starts with Engine:")
        else:
            _, kind, name, lines = block = blocks[-1]
            value = " ".join(value.split())
            known(line, key, value, KEYS[kind], f"{kind} {name}")
            if key not in ("term", "rule") and block.values(key):
                raise fault(line, f"{key} stands twice in {kind} {name}")
            lines.append((line, key, value))
    for block in blocks:
        for key in NEEDED.get(block.kind, ()):
            if not block.values(key):
                raise fault(block.line, f"{block.kind} {block.name} has no {key}")
    return blocks


def _input(block: Block) -> Input:
    low, high = -inf, inf
    for line, value in block.values("range"):
        ends = [edge(line, end) for end in value.split()]
        if len(ends) != 2:
            raise fault(line, f"range: {value!r} has to be two numbers")
        low, high = ends
    shapes = [_shape(line, value) for line, value in block.values("term")]
    return input_of(block.line, block.name, low, high, shapes)


def _shape(line: int, value: str) -> Shape:
    label, kind, *words = [*value.split(), "", ""][: max(2, len(value.split()))]
    one_of(line, f"shape of the term {label}", kind, SHAPES)
    numbers = [edge(line, word) for word in words]
    count = SHAPES[kind]
    if len(numbers) == count + 1 and numbers.pop() != 1.0:
        raise fault(line, f"term {label}: only the height 1 can be imported")
    if len(numbers) != count:
        raise fault(line, f"term {label}: a {kind} has {count} numbers")
    if kind in ("Gaussian", "GaussianProduct"):
        numbers = [number(line, word) for word in words[:count]]
        mean, sigma = numbers[:2]
        return flat_gaussian(line, label, mean, sigma, *(numbers[2:] or numbers))
    if kind == "Ramp":
        start, end = numbers
        if start < end:
            return trapezoid(line, label, start, end, inf, inf)
        return trapezoid(line, label, -inf, -inf, end, start)
    if kind == "Triangle":
        numbers.insert(1, numbers[1])
    return trapezoid(line, label, *numbers)


def _singleton(line: int, value: str) -> tuple[str, float]:
    words = value.split()
    if len(words) != 3 or words[1] != "Constant":
        raise fault(line, f"output term {value[:40]!r}: only NAME Constant NUMBER can be imported")
    return words[0], number(line, words[2])


def _add(system: System, line: int, rule: str, output: str, singletons: dict[str, float]) -> None:
    found = RULE.fullmatch(rule)
    names = tuple(item.name for item in system.inputs)
    if not found:
        raise fault(
            line,
            f"rule {rule[:60]!r} cannot be imported, only: if {names[0]} is TERM and {names[1]} "
            f"is TERM then {output} is TERM",
        )
    *pairs, target, conclusion, weight = found.groups()
    if weight is not None and number(line, weight) != 1.0:
        raise fault(line, f"a rule of weight {weight} cannot be imported, only of weight 1")
    one_of(line, "output of the rule", target, (output,))
    terms = dict(zip(pairs[::2], pairs[1::2], strict=True))
    if sorted(terms) != sorted(names):
        raise fault(line, f"a rule has to read both inputs, {names[0]} and {names[1]}")
    first, second = (
        place(line, terms[item.name], [term.label for term in item.terms], f"term of {item.name}")
        for item in system.inputs
    )
    place(line, conclusion, list(singletons), f"term of {output}")
    add_rule(system, line, (first, second), singletons[conclusion])
