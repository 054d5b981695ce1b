"""What every reader fills in: two inputs of seven terms each, and a singleton a rule.

What cannot be imported is a ``ValueError`` that starts with the line that it is about; the caller
puts the file before. Every function here that is given a line raises it.
"""

import re
import tomllib
from collections.abc import Iterable, Sequence
from math import inf, isfinite
from pathlib import Path
from typing import NamedTuple

from hfc_design.controllers.flc.record import TriangleRecord, terms_fault, terms_of
from hfc_design.controllers.rules import FlatGaussian, Term, Triangle
from hfc_design.core.records import TERMS

#: Key -> values that can be imported.
Allowed = dict[str, list[str]]
#: Language -> block -> ``Allowed``.
ALLOWED: dict[str, dict[str, Allowed]] = tomllib.loads(
    Path(__file__).with_name("allowed.toml").read_text(encoding="utf-8")
)
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?[Ii]nf")
_SHOULDER = "has to be 1 from its centre to the end of the range, as a design's outermost term is"


class Shape(NamedTuple):
    """A term as a file has it."""

    line: int
    label: str
    corners: tuple[float, float, float, float] | None  # of a trapezoid, from 0 to 1 to 1 to 0
    gaussian: FlatGaussian | None  # if it is no trapezoid


class Input(NamedTuple):
    """An input, its terms in the order of the file."""

    line: int
    name: str
    low: float
    high: float
    terms: tuple[Term, ...]


class System(NamedTuple):
    """What a file says; rules by the indices of the terms of the first and the second input."""

    inputs: tuple[Input, Input]
    rules: dict[tuple[int, int], tuple[int, float]]  # -> line, singleton


def fault(line: int, message: str) -> ValueError:
    """An error that names its line."""
    return ValueError(f"line {line}: {message}")


def number(line: int, text: str) -> float:
    """A finite number."""
    value = edge(line, text)
    if not isfinite(value):
        raise fault(line, f"{text} has to be a finite number")
    return value


def edge(line: int, text: str) -> float:
    """A number that may be infinite."""
    if not NUMBER.fullmatch(text):
        raise fault(line, f"{text[:40]!r} has to be a number")
    return float(text)


def one_of(line: int, key: str, value: str, allowed: Iterable[str]) -> str:
    """``value`` if it is allowed."""
    if value not in allowed:
        listed = " or ".join(allowed)
        raise fault(line, f"{key} = {value[:40]!r} cannot be imported, only {listed}")
    return value


def flat_gaussian(
    line: int, label: str, low: float, left_sigma: float, high: float, right_sigma: float
) -> Shape:
    """A Gaussian with a flat top from ``low`` to ``high``."""
    if left_sigma != right_sigma:
        raise fault(line, f"term {label}: both flanks have to be equally wide (LL eq. 3)")
    if not (low <= high and 1e-9 <= left_sigma <= 1e9):
        raise fault(line, f"term {label}: its top may not fall, its width has to be 1e-9 to 1e9")
    return Shape(line, label, None, FlatGaussian(label, low, high, left_sigma))


def trapezoid(line: int, label: str, *corners: float) -> Shape:
    """A trapezoid, where a left corner of -inf or a right one of inf stands for a shoulder."""
    a, b, c, d = corners
    b = -inf if a == -inf else b
    c = inf if d == inf else c
    if not (a <= b <= c <= d) or c == -inf or b == inf:
        raise fault(line, f"term {label}: its corners have to rise, and cannot all be infinite")
    return Shape(line, label, (a, b, c, d), None)


def input_of(line: int, name: str, low: float, high: float, shapes: Sequence[Shape]) -> Input:
    """An input with the design's terms."""
    if len(shapes) != TERMS:
        raise fault(line, f"input {name} has {len(shapes)} terms; a design has {TERMS}")
    if not low < high:
        raise fault(line, f"input {name}: its range has to rise")
    labels = [shape.label for shape in shapes]
    for shape in shapes:
        if labels.count(shape.label) > 1:
            raise fault(shape.line, f"term {shape.label} stands twice in input {name}")
    gaussians = [shape.gaussian for shape in shapes if shape.gaussian]
    if len(gaussians) == TERMS:
        return Input(line, name, low, high, tuple(gaussians))
    if gaussians:
        raise fault(line, f"input {name} mixes Gaussian and straight terms; a design does not")
    terms = _triangles(low, high, shapes)
    if message := terms_fault(triangle_records(terms)):
        raise fault(line, f"input {name}, with terms NL to PL in the order of centres: {message}")
    return Input(line, name, low, high, terms)


def triangle_records(terms: Sequence[Term]) -> tuple[TriangleRecord, ...]:
    """Triangles as a design holds them, NL to PL in the order of their centres."""
    return terms_of([term[1:] for term in sorted(terms, key=centre_of)])


def centre_of(term: Term) -> float:
    """Where a term is 1, or the middle of that."""
    return term.centre if isinstance(term, Triangle) else 0.5 * (term.low + term.high)


def _triangles(low: float, high: float, shapes: Sequence[Shape]) -> tuple[Term, ...]:
    """Triangles, the outermost of which are 1 up to the range's end and beyond."""
    centres = [_centre(low, high, shape) for shape in shapes]
    order = sorted(range(TERMS), key=centres.__getitem__)
    found = []
    for shape, centre in zip(shapes, centres, strict=True):
        assert shape.corners
        left, top, end, right = shape.corners
        outermost = shape is shapes[order[0]], shape is shapes[order[-1]]
        if outermost[0] and not top <= low <= centre:
            raise fault(shape.line, f"term {shape.label}, the lowest, {_SHOULDER}")
        if outermost[1] and not centre <= high <= end:
            raise fault(shape.line, f"term {shape.label}, the highest, {_SHOULDER}")
        left, right = -inf if outermost[0] else left, inf if outermost[1] else right
        if not any(outermost) and not (isfinite(left) and isfinite(right)):
            raise fault(shape.line, f"term {shape.label}: only the outermost reach infinity")
        if not left < centre < right:
            raise fault(shape.line, f"term {shape.label} has a vertical edge at {centre}")
        found.append(Triangle(shape.label, left, centre, right))
    return tuple(found)


def _centre(low: float, high: float, shape: Shape) -> float:
    assert shape.corners
    _, top, end, _ = shape.corners
    if top == end:
        return top
    if (top <= low) == (end >= high):
        raise fault(
            shape.line,
            f"term {shape.label} is flat from {top} to {end}; a design has triangles, and only "
            f"the outermost are flat, out to the end of the range ({low} to {high})",
        )
    return end if top <= low else top


def add_rule(system: System, line: int, places: tuple[int, int], singleton: float) -> None:
    """A rule more."""
    if places in system.rules:
        earlier = system.rules[places][0]
        raise fault(line, f"a second rule for the same two terms; the first is in line {earlier}")
    system.rules[places] = (line, singleton)


def place(line: int, label: str, labels: Sequence[str], what: str) -> int:
    """Where ``label`` stands."""
    if label not in labels:
        known = ", ".join(labels[:TERMS]) + (", ..." if len(labels) > TERMS else "")
        raise fault(line, f"{label[:40]!r} is no {what}; there is {known}")
    return labels.index(label)


def known(line: int, key: str, value: str, allowed: Allowed, where: str) -> None:
    """Refuses what is not known: what it means is not known, so that it cannot be left out."""
    if key not in allowed:
        raise fault(line, f"{where}: key {key[:40]!r} is not known")
    if allowed[key]:
        one_of(line, key, value, allowed[key])
