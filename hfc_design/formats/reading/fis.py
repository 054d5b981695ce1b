"""Reads .fis files of MATLAB's and Octave's fuzzy toolboxes: Sugeno systems of constants.

Sections of ``Key=value`` lines; in [Rules] a line is ``1 2, 3 (1) : 1``: the terms of the inputs
and of the output by number, the weight, and 1 for "and".
"""

import re
from math import inf
from typing import NamedTuple

from hfc_design.core.records import TERMS
from hfc_design.formats.reading.system import (
    ALLOWED,
    Input,
    Shape,
    System,
    add_rule,
    fault,
    flat_gaussian,
    input_of,
    known,
    number,
    one_of,
    trapezoid,
)

SYSTEM = ALLOWED["fis"]["System"]
SECTIONS = ("System", "Input1", "Input2", "Output1", "Rules")
TERM = re.compile(r"'([^']*)'\s*:\s*'(\w+)'\s*,\s*\[([^][]*)\]")
RULE = re.compile(r"(-?\d+)[\s,]+(-?\d+)\s*,\s*(-?\d+)\s*\(([^()]*)\)\s*:\s*(\d+)")
#: Term -> how many numbers it has.
SHAPES = {"trimf": 3, "trapmf": 4, "linzmf": 2, "linsmf": 2, "gaussmf": 2, "gauss2mf": 4}


class Section(NamedTuple):
    """A section: its keys with line and value; its rules as (line, text)."""

    line: int
    keys: dict[str, tuple[int, str]]
    rules: list[tuple[int, str]]


def read(text: str) -> System:
    """The system in ``text``; ValueError: it is no .fis, or more than a design can hold."""
    sections = _sections(text)
    for name in SECTIONS:
        if name not in sections:
            raise fault(1, f"there is no section [{name}]; needed are {', '.join(SECTIONS)}")
    head, *inputs, output, rules = (sections[name] for name in SECTIONS)
    for key, (line, value) in head.keys.items():
        known(line, key, value.strip("'"), SYSTEM, "[System]")
    for key, allowed in SYSTEM.items():
        if allowed and key not in head.keys:
            raise fault(head.line, f"[System] has no {key}; needed is {key}='{allowed[0]}'")
    first, second = map(_input, inputs)
    system = System((first, second), {})
    singletons = []
    for line, label, kind, value in _terms(output):
        one_of(line, f"kind of the output term {label}", kind, ("constant",))
        singletons += _numbers(line, f"[{value}]", 1)
    _counted(head, "NumRules", len(rules.rules))
    for line, rule in rules.rules:
        _add(system, line, rule, singletons)
    return system


def _sections(text: str) -> dict[str, Section]:
    sections: dict[str, Section] = {}
    current = None
    for line, content in enumerate(text.splitlines(), 1):
        stripped = re.sub(r"^\s*#.*|%.*", "", content).strip()
        if not stripped:
            continue
        if title := re.fullmatch(r"\[(\w+)\]", stripped):
            name = one_of(line, "section", title[1], SECTIONS)
            if name in sections:
                raise fault(line, f"a second section [{name}]")
            current = sections[name] = Section(line, {}, [])
        elif current is None:
            raise fault(line, f"{stripped[:40]!r} stands before any section; [System] comes first")
        elif current is sections.get("Rules"):
            current.rules.append((line, stripped))
        else:
            key, equals, value = (part.strip() for part in stripped.partition("="))
            if not equals:
                raise fault(line, f"{stripped[:40]!r} is no line of a .fis, which is Key=value")
            if key in current.keys:
                raise fault(line, f"{key} stands there twice")
            current.keys[key] = (line, value)
    return sections


def _input(section: Section) -> Input:
    line, name = section.keys.get("Name", (section.line, ""))
    low, high = _numbers(*section.keys.get("Range", (section.line, "[]")), 2)
    return input_of(line, name.strip("'"), low, high, [_shape(*part) for part in _terms(section)])


def _terms(section: Section) -> list[tuple[int, str, str, str]]:
    """Line, label, shape and numbers of each term, MF1 first."""
    found: list[tuple[int, str, str, str]] = []
    for key, (line, value) in section.keys.items():
        if key in ("Name", "Range", "NumMFs"):
            continue
        term = TERM.fullmatch(value)
        if key != f"MF{len(found) + 1}" or not term:
            wanted = f"MF{len(found) + 1}='NAME':'SHAPE',[NUMBERS]"
            raise fault(line, f"{key[:20]}={value[:40]} cannot be imported; here belongs {wanted}")
        found.append((line, term[1], term[2], term[3]))
    _counted(section, "NumMFs", len(found))
    return found


def _counted(section: Section, key: str, count: int) -> None:
    line, value = section.keys.get(key, (section.line, ""))
    if value != str(count):
        raise fault(line, f"{key}={value[:20]}, but there are {count}")


def _numbers(line: int, text: str, count: int) -> list[float]:
    numbers = [number(line, word) for word in text.strip("[]").replace(",", " ").split()]
    if len(numbers) != count:
        raise fault(line, f"{text[:60]} has to be {count} numbers")
    return numbers


def _shape(line: int, label: str, kind: str, text: str) -> Shape:
    one_of(line, f"shape of the term {label}", kind, SHAPES)
    numbers = _numbers(line, f"[{text}]", SHAPES[kind])
    if kind == "gaussmf":
        sigma, centre = numbers
        return flat_gaussian(line, label, centre, sigma, centre, sigma)
    if kind == "gauss2mf":
        left, low, right, high = numbers
        return flat_gaussian(line, label, low, left, high, right)
    if kind == "linzmf":
        return trapezoid(line, label, -inf, -inf, *numbers)
    if kind == "linsmf":
        return trapezoid(line, label, *numbers, inf, inf)
    if kind == "trimf":
        numbers.insert(1, numbers[1])
    return trapezoid(line, label, *numbers)


def _add(system: System, line: int, rule: str, singletons: list[float]) -> None:
    found = RULE.fullmatch(rule)
    if not found:
        raise fault(line, f"{rule[:40]!r} is no rule of two inputs, as in 1 1, 1 (1) : 1")
    first, second, conclusion = (int(part) for part in found.groups()[:3])
    if number(line, found[4].strip()) != 1.0:
        raise fault(line, f"a rule of weight {found[4]} cannot be imported, only of weight 1")
    one_of(line, "connection of a rule", found[5], ("1",))
    for term, count in ((first, TERMS), (second, TERMS), (conclusion, len(singletons))):
        if not 1 <= term <= count:
            raise fault(line, f"term {term} in a rule; allowed is 1 to {count}, all of them given")
    add_rule(system, line, (first - 1, second - 1), singletons[conclusion - 1])
