"""Reads .fis files of MATLAB's and Octave's fuzzy toolboxes: Sugeno systems of constants.

Sections of ``Key=value`` lines; in [Rules] a line is ``1 2, 3 (1) : 1``: the terms of the inputs
and of the output by number, the weight, and 1 for "and".
"""

import re

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
    input_of,
    lines,
    shape_of,
)

SYSTEM = ALLOWED["fis"]["System"]
SECTIONS = ("System", "Input1", "Input2", "Output1", "Rules")
#: Shape -> which of its numbers the ends are, see ``shape_of``.
SHAPES = {"trimf": "abbc", "trapmf": "abcd", "linzmf": "--ab", "linsmf": "ab++"}
SHAPES |= {"gaussmf": "abba", "gauss2mf": "abdc"}
COMMENT = re.compile(r"^\s*#.*|%.*")
SECTION = re.compile(r"\[(\w+)\]")
TERM = re.compile(r"'([^']*)'\s*:\s*'(\w+)'\s*,\s*(\[[^][]*\])")
RULE = re.compile(r"(-?\d+)[\s,]+(-?\d+)\s*,\s*(-?\d+)\s*\(([^()]*)\)\s*:\s*(\d+)", re.ASCII)


def read(text: str) -> System:
    """The system in ``text``; ValueError: it is no .fis, or more than a design can hold."""
    head, *inputs, output, rules = checked_sections(text, SYSTEM)
    first, second = map(_input, inputs)
    singletons = []
    for label, kind, value in terms_in(output):
        kind.one_of(f"kind of the output term {label.text}", ("constant",))
        singletons.append(Singleton(label.text, *numbers_of(value, 1)))
    told = unquoted(output.get("Name")).text
    low, high = numbers_of(output.get("Range", "[-inf inf]"), 2, finite=False)
    named = Output(told, low, high, [one.label for one in singletons])
    system = System(unquoted(head.get("Name")).text, (first, second), named, {})
    check_count(head, "NumRules", len(rules.entries))
    for _, rule in rules.entries:
        _add(system, rule, singletons)
    return system


def checked_sections(text: str, system: Allowed) -> list[Block]:
    """The sections in the order of ``SECTIONS``; ValueError: they say what is not allowed."""
    sections = _sections(text)
    for name in SECTIONS:
        if name not in sections:
            needed = ", ".join(SECTIONS)
            raise Token(1, "").fault(f"there is no section [{name}]; needed are {needed}")
    head = sections["System"]
    for key, value in head.entries:
        check_known(key, unquoted(value), system, "[System]")
    for key, allowed in system.items():
        if allowed and not head.all(key):
            raise head.name.fault(f"[System] has no {key}; needed is {key}='{allowed[0]}'")
    return [sections[name] for name in SECTIONS]


def _sections(text: str) -> dict[str, Block]:
    """The sections by name; rules have no key."""
    sections: dict[str, Block] = {}
    current, seen = None, set()
    for line in lines(text, COMMENT):
        if title := line.match(SECTION):
            name = title[0].one_of("section", SECTIONS)
            if name in sections:
                raise line.fault(f"a second section [{name}]")
            current = sections[name] = Block(title[0], [])
        elif current is None:
            raise line.fault(f"{line.text[:40]!r} stands before any section; [System] comes first")
        elif current is sections.get("Rules"):
            current.entries.append(("", line))
        elif pair := line.pair("="):
            if (current.name.text, pair[0].text) in seen:
                raise line.fault(f"{pair[0].text} stands there twice")
            seen.add((current.name.text, pair[0].text))
            current.entries.append((pair[0].text, pair[1]))
        else:
            raise line.fault(f"{line.text[:40]!r} is no line of a .fis, which is Key=value")
    return sections


def unquoted(value: Token) -> Token:
    """A text without its quotes."""
    return value._replace(text=value.text.strip("'\""))


def _input(section: Block) -> Input:
    low, high = numbers_of(section.get("Range", "[]"), 2)
    shapes = [_shape(*term) for term in terms_in(section)]
    return input_of(unquoted(section.get("Name")), low, high, shapes)


def _shape(label: Token, kind: Token, value: Token) -> Shape:
    letters = SHAPES[kind.one_of(f"shape of the term {label.text}", SHAPES)]
    numbers = numbers_of(value, len(set(letters) - {"-", "+"}))
    return shape_of(label, kind.text, letters, numbers)


def terms_in(section: Block) -> list[list[Token]]:
    """Label, shape and numbers of each term, MF1 first."""
    found: list[list[Token]] = []
    for key, value in section.entries:
        if key in ("Name", "Range", "NumMFs"):
            continue
        term = value.match(TERM)
        if key != f"MF{len(found) + 1}" or not term:
            wanted = f"MF{len(found) + 1}='NAME':'SHAPE',[NUMBERS]"
            told = f"{key[:20]}={value.text[:40]} cannot be imported"
            quotes = ", names between apostrophes" * ("'" not in value.text)
            raise value.fault(f"{told}; here belongs {wanted}{quotes}")
        found.append(term)
    check_count(section, "NumMFs", len(found))
    return found


def check_count(section: Block, key: str, count: int) -> None:
    """Refuses a number of entries that is not theirs."""
    value = section.get(key)
    if value.text != str(count):
        raise value.fault(f"{key}={value.text[:20]}, but there are {count}")


def numbers_of(value: Token, count: int, finite: bool = True) -> list[float]:
    """So many numbers between brackets; ValueError: they are others."""
    inner = value._replace(text=value.text.strip("[]").replace(",", " "))
    numbers = [word.number() if finite else word.edge() for word in inner.words()]
    if len(numbers) != count:
        raise value.fault(f"{value.text[:60]} has to be {count} numbers")
    return numbers


def _add(system: System, rule: Token, singletons: list[Singleton]) -> None:
    if not (found := rule.match(RULE)):
        raise rule.fault(f"{rule.text[:40]!r} is no rule of two inputs, as in 1 1, 1 (1) : 1")
    first, second, conclusion = (int(part.text) for part in found[:3])
    weight = found[3]._replace(text=found[3].text.strip())
    if weight.number() != 1.0:
        raise rule.fault(f"a rule of weight {found[3].text} cannot be imported, only of weight 1")
    found[4].one_of("connection of a rule", ("1",))
    counts = [*(len(item.labels) for item in system.inputs), len(singletons)]
    for term, count in zip((first, second, conclusion), counts, strict=True):
        if not 1 <= term <= count:
            raise rule.fault(f"term {term} in a rule; allowed is 1 to {count}, all of them given")
    system.add(rule, (first - 1, second - 1), singletons[conclusion - 1])
