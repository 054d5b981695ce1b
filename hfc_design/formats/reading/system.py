"""What every reader takes from a file, and what it fills in: two inputs of seven terms each, and a
singleton a rule.

What cannot be imported is a ``ValueError`` that starts with the line that it is about; the caller
puts the file before.
"""

import re
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from math import inf, isfinite
from pathlib import Path
from typing import NamedTuple

from hfc_design.controllers.flc.record import LABELS, TriangleRecord, terms_fault
from hfc_design.controllers.rules import FlatGaussian
from hfc_design.core.records import TERMS

#: Key -> values that can be imported.
Allowed = dict[str, list[str]]
#: Language -> block -> ``Allowed``.
ALLOWED: dict[str, dict[str, Allowed]] = tomllib.loads(
    Path(__file__).with_name("allowed.toml").read_text(encoding="utf-8")
)
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?[Ii]nf")
_SHOULDER = "has to be 1 from its centre to the end of the range, as a design's outermost term is"


class Token(NamedTuple):
    """A piece of a file's text and where it stands. Every method may raise its ``fault``."""

    line: int
    text: str
    file: str = ""  # where there are several

    def fault(self, message: str) -> ValueError:
        """An error that names the line."""
        return ValueError(f"{self.file and self.file + ': '}line {self.line}: {message}")

    def match(self, pattern: re.Pattern[str]) -> "list[Token]":
        """The groups of a pattern; none if this is something else."""
        found = pattern.fullmatch(self.text)
        return [self._replace(text=part or "") for part in found.groups()] if found else []

    def words(self) -> "list[Token]":
        """What stands between blanks."""
        return [self._replace(text=word) for word in self.text.split()]

    def number(self) -> float:
        """A finite number."""
        value = self.edge()
        if not isfinite(value):
            raise self.fault(f"{self.text} has to be a finite number")
        return value

    def edge(self) -> float:
        """A number that may be infinite."""
        if not NUMBER.fullmatch(self.text):
            raise self.fault(f"{self.text[:40]!r} has to be a number")
        return float(self.text)

    def one_of(self, key: str, allowed: Iterable[str]) -> str:
        """The text, if it is allowed as the value of a key."""
        if self.text not in allowed:
            listed = " or ".join(allowed)
            raise self.fault(f"{key} = {self.text[:40]!r} cannot be imported, only {listed}")
        return self.text

    def place(self, labels: Sequence[str], what: str) -> int:
        """Where the text stands among ``labels``."""
        if self.text not in labels:
            known = ", ".join(labels[:TERMS]) + (", ..." if len(labels) > TERMS else "")
            raise self.fault(f"{self.text[:40]!r} is no {what}; there is {known}")
        return labels.index(self.text)


class Block(NamedTuple):
    """A block of a file: its name, and its entries as key and value."""

    name: Token
    entries: list[tuple[str, Token]]

    def all(self, key: str) -> list[Token]:
        """The values of a key."""
        return [value for found, value in self.entries if found == key]

    def get(self, key: str, default: str = "") -> Token:
        """The value of a key."""
        return next(iter(self.all(key)), self.name._replace(text=default))


def lines(text: str, comment: re.Pattern[str]) -> Iterator[Token]:
    """The lines that are left without comments."""
    for line, content in enumerate(text.splitlines(), 1):
        if stripped := comment.sub("", content).strip():
            yield Token(line, stripped)


def check_known(key: str, value: Token, allowed: Allowed, where: str) -> None:
    """Refuses what is not known: what it means is not known, so that it cannot be left out."""
    if key not in allowed:
        raise value.fault(f"{where}: key {key[:40]!r} is not known")
    if allowed[key]:
        value.one_of(key, allowed[key])


class Shape(NamedTuple):
    """A term as a file has it."""

    label: Token
    #: A Gaussian, or the corners of a trapezoid from 0 to 1 to 1 to 0.
    term: FlatGaussian | tuple[float, float, float, float]


class Shapes(NamedTuple):
    """The shapes of a language, each as four letters: a is a term's first number in a file.

    A corner at - or + is infinitely far. Both methods raise a ``fault``.
    """

    trapezoids: dict[str, str]  # the corners from 0 to 1 to 1 to 0
    gaussians: dict[str, str]  # where the flat top begins, sigma before it, where it ends, sigma

    def size(self, label: Token, kind: Token) -> int:
        """How many numbers a term of a kind has."""
        known = self.trapezoids | self.gaussians
        return len(set(known[kind.one_of(f"shape of the term {label.text}", known)]) - {"-", "+"})

    def of(self, label: Token, kind: Token, numbers: Sequence[float]) -> Shape:
        """The term with these numbers."""
        told = {"-": -inf, "+": inf} | dict(zip("abcd", numbers, strict=False))
        letters = self.trapezoids.get(kind.text) or self.gaussians[kind.text]
        a, b, c, d = (told[letter] for letter in letters)
        if kind.text in self.trapezoids:
            return trapezoid(label, a, b, c, d)
        if b != d:
            raise label.fault(f"term {label.text}: both flanks have to be equally wide (LL eq. 3)")
        if not (a <= c and 1e-9 <= b <= 1e9):
            told_range = "its top may not fall, its width has to be 1e-9 to 1e9"
            raise label.fault(f"term {label.text}: {told_range}")
        return Shape(label, FlatGaussian(label.text, a, c, b))


def trapezoid(label: Token, a: float, b: float, c: float, d: float) -> Shape:
    """A trapezoid, where a left corner of -inf or a right one of inf stands for a shoulder."""
    b = -inf if a == -inf else b
    c = inf if d == inf else c
    if not (a <= b <= c <= d) or c == -inf or b == inf:
        told = "its corners have to rise, and cannot all be infinite"
        raise label.fault(f"term {label.text}: {told}")
    return Shape(label, (a, b, c, d))


class Input(NamedTuple):
    """An input with a design's terms from the lowest to the highest."""

    name: Token
    low: float
    high: float
    labels: list[str]  # in the order of the file
    order: list[int]  # of each term the place of its label
    gaussians: list[FlatGaussian]  # or none, and
    triangles: list[TriangleRecord]


class System(NamedTuple):
    """What a file says; rules by the places of the first and the second input's labels."""

    inputs: tuple[Input, Input]
    rules: dict[tuple[int, int], tuple[Token, float]]  # -> what says so, singleton

    def add(self, said: Token, places: tuple[int, int], singleton: float) -> None:
        """A rule more; ValueError: it is not the first for its terms."""
        earlier, _ = self.rules.setdefault(places, (said, singleton))
        if earlier is not said:
            raise said.fault(
                f"a second rule for the same two terms; the first is in line {earlier.line}"
            )


def input_of(name: Token, low: float, high: float, shapes: Sequence[Shape]) -> Input:
    """An input; ValueError: its terms are not those of a design."""
    if len(shapes) != TERMS:
        raise name.fault(f"input {name.text} has {len(shapes)} terms; a design has {TERMS}")
    if not low < high:
        raise name.fault(f"input {name.text}: its range has to rise")
    labels = [shape.label.text for shape in shapes]
    for label, _ in shapes:
        if labels.count(label.text) > 1:
            raise label.fault(f"term {label.text} stands twice in input {name.text}")
    gaussians = [term for _, term in shapes if isinstance(term, FlatGaussian)]
    if gaussians and len(gaussians) < TERMS:
        raise name.fault(f"input {name.text} mixes Gaussian and straight terms; a design does not")
    centres = [_centre(low, high, shape) for shape in shapes]
    order = sorted(range(TERMS), key=centres.__getitem__)
    if gaussians:
        return Input(name, low, high, labels, order, [gaussians[k] for k in order], [])
    triangles = _triangles(low, high, [(centres[k], shapes[k]) for k in order])
    if message := terms_fault(tuple(triangles)):
        told = f"input {name.text}, with terms NL to PL in the order of centres: {message}"
        raise name.fault(told)
    return Input(name, low, high, labels, order, [], triangles)


def _centre(low: float, high: float, shape: Shape) -> float:
    """Where a term is 1, or the middle of that."""
    label, term = shape
    if isinstance(term, FlatGaussian):
        return 0.5 * (term.low + term.high)
    _, top, end, _ = term
    if top == end:
        return top
    if (top <= low) == (end >= high):
        raise label.fault(
            f"term {label.text} is flat from {top} to {end}; a design has triangles, and only "
            f"the outermost are flat, out to the end of the range ({low} to {high})"
        )
    return end if top <= low else top


def _triangles(
    low: float, high: float, shapes: Sequence[tuple[float, Shape]]
) -> list[TriangleRecord]:
    """Triangles of centres and trapezoids; the outermost are 1 up to the range's end and beyond."""
    found = []
    for name, (centre, (label, term)) in zip(LABELS, shapes, strict=True):
        assert not isinstance(term, FlatGaussian)
        left, top, end, right = term
        lowest, highest = name == LABELS[0], name == LABELS[-1]
        if lowest and not top <= low <= centre:
            raise label.fault(f"term {label.text}, the lowest, {_SHOULDER}")
        if highest and not centre <= high <= end:
            raise label.fault(f"term {label.text}, the highest, {_SHOULDER}")
        inner = ([] if lowest else [left]) + ([] if highest else [right])
        if not all(map(isfinite, inner)):
            raise label.fault(f"term {label.text}: only the outermost reach infinity")
        if centre in inner:
            raise label.fault(f"term {label.text} has a vertical edge at {centre}")
        edges = (None if lowest else left, None if highest else right)
        found.append(TriangleRecord(label=name, left=edges[0], centre=centre, right=edges[1]))
    return found
