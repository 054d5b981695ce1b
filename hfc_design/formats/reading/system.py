"""Common part of the readers: a system of two inputs with 2 to 11 terms, and a singleton per rule.

What cannot be imported raises a ``ValueError`` that begins with the number of the line; the caller
adds the file name.
"""

import re
import tomllib
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from math import inf, isfinite
from pathlib import Path
from typing import NamedTuple

from hfc_design.controllers.flc.record import TriangleRecord, terms_fault
from hfc_design.controllers.flc.rules import FEWEST, MOST
from hfc_design.core.records import TERMS, UserError, either, option

#: Longest name of a term or variable, see ``records.Label``.
LONGEST = 32
PLAIN = re.compile(r"[A-Za-z](_?[A-Za-z0-9])*")
#: Replacements of letters that are written as two, or that Unicode cannot decompose.
WRITTEN = {"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "æ": "ae", "œ": "oe", "ø": "o", "ł": "l"}
LETTERS = str.maketrans(WRITTEN | {k.upper(): v.title() for k, v in WRITTEN.items() if k != "ß"})
GREEK = re.compile(r"GREEK (CAPITAL|SMALL) LETTER (\w+)")


def _plain(name: str) -> str:
    """Return the name in ASCII: umlauts as two letters, Greek letters by name, accents removed."""

    def written(letter: re.Match[str]) -> str:
        greek = GREEK.fullmatch(unicodedata.name(letter[0], ""))
        return "" if not greek else greek[2].title() if greek[1] == "CAPITAL" else greek[2].lower()

    text = unicodedata.normalize("NFC", name).translate(LETTERS)
    return re.sub(r"[^\x00-\x7f]", written, unicodedata.normalize("NFKD", text))


def identifiers(names: Iterable[str], prefix: str, stand_ins: Sequence[str] = ()) -> list[str]:
    """Return the names as identifiers in every format, all different even in lower case.

    An identifier is a letter, then letters, digits and single underscores: other characters become
    an underscore, ``prefix`` precedes a leading digit. A name without any usable character becomes
    the entry of ``stand_ins`` with the same index, or ``prefix`` with a number from 1 on.
    """
    result: list[str] = []
    taken: set[str] = set()
    for place, name in enumerate(names):
        text = re.sub(r"[^A-Za-z0-9]+", "_", _plain(name)).strip("_")
        text = text or (stand_ins[place] if stand_ins else f"{prefix}_{place + 1}")
        if not PLAIN.fullmatch(text):
            text = f"{prefix}_{text}"
        text = short = text[:LONGEST].rstrip("_")
        number = 1
        while text.casefold() in taken:
            number += 1
            text = f"{short[: LONGEST - 4].rstrip('_')}_{number}"
        taken.add(text.casefold())
        result.append(text)
    return result


#: Key -> values that can be imported; []: any value.
Allowed = dict[str, list[str]]
#: Language -> block -> ``Allowed``.
ALLOWED: dict[str, dict[str, Allowed]] = tomllib.loads(
    Path(__file__).with_name("allowed.toml").read_text(encoding="utf-8")
)
NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?|[+-]?[Ii]nf", re.ASCII)
#: Gaussian shapes of every language.
GAUSSIANS = ("Gaussian", "GaussianProduct", "gaussmf", "gauss2mf")
_SHOULDER = "must be 1 from its centre to the end of the range, as a design's outermost term is"


class Token(NamedTuple):
    """Piece of a file's text. Its methods raise its ``fault`` if the text is wrong."""

    line: int  # number of its line, from 1 on
    text: str
    file: str = ""  # name of the file, if several are read

    def fault(self, message: str) -> ValueError:
        """Return an error that names the line, to be raised."""
        return ValueError(f"{self.file and self.file + ': '}line {self.line}: {message}")

    def match(self, pattern: re.Pattern[str]) -> "list[Token]":
        """Return the groups of a pattern; [] if the text does not match."""
        match = pattern.fullmatch(self.text)
        return [self._replace(text=part or "") for part in match.groups()] if match else []

    def pair(self, between: str) -> "list[Token]":
        """Return the text before and behind the first ``between``; [] if it does not occur."""
        key, separator, value = self.text.partition(between)
        parts = (key, value) if separator else ()
        return [self._replace(text=part.strip()) for part in parts]

    def words(self) -> "list[Token]":
        """Return the words between blanks."""
        return [self._replace(text=word) for word in self.text.split()]

    def number(self) -> float:
        """Return the text as a finite number."""
        value = self.edge()
        if not isfinite(value):
            raise self.fault(f"{self.text} must be a finite number")
        return value

    def edge(self) -> float:
        """Return the text as a number that may be infinite."""
        if not NUMBER.fullmatch(self.text):
            raise self.fault(f"{self.text[:40]!r} must be a number")
        return float(self.text)

    def one_of(self, key: str, allowed: Iterable[str]) -> str:
        """Return the text if it is allowed as the value of a key."""
        if self.text not in allowed:
            names = [*allowed]
            listed = f"one of {', '.join(names)}" if len(names) > 1 else names[0]
            raise self.fault(f"{key} = {self.text[:40]!r} cannot be imported; must be {listed}")
        return self.text

    def place(self, labels: Sequence[str], what: str) -> int:
        """Return the index of the text among ``labels``."""
        if self.text not in labels:
            known = ", ".join(labels[:TERMS]) + (", ..." if len(labels) > TERMS else "")
            raise self.fault(f"{self.text[:40]!r}: unknown {what}; available: {known}")
        return labels.index(self.text)


class Block(NamedTuple):
    """Block of a file: its name, and its entries as key and value."""

    name: Token
    entries: list[tuple[str, Token]]

    def all(self, key: str) -> list[Token]:
        """Return all values of a key."""
        return [value for name, value in self.entries if name == key]

    def get(self, key: str, default: str = "") -> Token:
        """Return the first value of a key, or else ``default``."""
        return next(iter(self.all(key)), self.name._replace(text=default))


def lines(text: str, comment: re.Pattern[str]) -> Iterator[Token]:
    """Yield the non-empty lines without comments; text in group 1 of ``comment`` is kept."""
    for line, content in enumerate(text.splitlines(), 1):
        if stripped := comment.sub(r"\1", content).strip():
            yield Token(line, stripped)


def chosen(outputs: Sequence[Token], wanted: str | None) -> int:
    """Return the index of the ``wanted`` output; UserError: unknown; ValueError: must be named."""
    names = [name.text for name in outputs]
    listed = ", ".join(names)
    if wanted is None and len(names) > 1:
        raise outputs[1].fault(f"{option('output')} must name one of the outputs {listed}")
    if wanted is not None and wanted not in names:
        raise UserError(f"{option('output', wanted)}: unknown output; available: {listed}")
    return 0 if wanted is None else names.index(wanted)


def check_known(key: str, value: Token, allowed: Allowed, where: str) -> None:
    """Raise ValueError for an unknown key or value: it must not be ignored, as it may matter."""
    if key not in allowed:
        raise value.fault(f"{where}: unknown key {key[:40]!r}")
    if allowed[key]:
        value.one_of(key, allowed[key])


class Shape(NamedTuple):
    """Shape of a term as in a file: it rises from 0 to 1, stays 1, and falls to 0."""

    label: Token
    gaussian: bool
    left: float  # where it begins to rise; of a Gaussian, sigma
    low: float  # where it becomes 1
    high: float  # up to where it is 1
    right: float  # where it becomes 0; of a Gaussian, sigma

    def fault(self, message: str) -> ValueError:
        """Return an error about the term; the label precedes the message."""
        return self.label.fault(f"term {self.label.text}{message}")

    def centre(self, lowest: float, highest: float) -> float:
        """Return the middle of a Gaussian, the peak of a triangle, the inner end of a flat top."""
        if self.gaussian:
            return 0.5 * (self.low + self.high)
        if self.low == self.high:
            return self.low
        if (self.low <= lowest) == (self.high >= highest):
            flat = f"must be a triangle (got flat from {self.low} to {self.high})"
            ends = f"up to the end of the range ({lowest} to {highest})"
            raise self.fault(f" {flat}; only the outermost terms may be flat, {ends}")
        return self.high if self.low <= lowest else self.low


def shape_of(label: Token, kind: str, letters: str, numbers: Sequence[float]) -> Shape:
    """Return the term with these parameters; ValueError: a design cannot have it.

    ``letters`` stand for left, low, high and right: a is the first of ``numbers``, b the second and
    so on, - is minus infinity, + is infinity.
    """
    ends = {"-": -inf, "+": inf} | dict(zip("abcd", numbers, strict=False))
    left, low, high, right = (ends[letter] for letter in letters)
    if kind in GAUSSIANS:
        shape = Shape(label, True, left, low, high, right)
        if left != right:
            raise shape.fault(": both flanks must be equally wide (LL eq. 3)")
        if not (low <= high and 1e-9 <= left <= 1e9):
            raise shape.fault(": its top must not fall, its width must be 1e-9 to 1e9")
        return shape
    low, high = -inf if left == -inf else low, inf if right == inf else high  # a shoulder
    shape = Shape(label, False, left, low, high, right)
    if not (left <= low <= high <= right) or high == -inf or low == inf:
        raise shape.fault(": its corners must rise, and must not all be infinite")
    return shape


class Input(NamedTuple):
    """Input of a system, with its terms from the lowest to the highest."""

    name: Token
    low: float
    high: float
    labels: list[str]  # in the order of the file
    order: list[int]  # index in ``labels`` of each of ``terms``
    terms: list[Shape]
    triangles: list[TriangleRecord]  # the terms as triangles; [] if they are Gaussian


class Singleton(NamedTuple):
    """Conclusion of a rule."""

    label: str  # "": it has none
    value: float


class Output(NamedTuple):
    """Output of a system; empty or infinite fields are not in the file."""

    name: str
    low: float = -inf
    high: float = inf
    labels: Sequence[str] = ()  # of its terms


class System(NamedTuple):
    """System in a file; a key of ``rules`` has the indices of the labels of both inputs."""

    name: str  # "": none
    inputs: tuple[Input, Input]
    output: Output
    rules: dict[tuple[int, int], tuple[Token, Singleton]]  # -> its text, its conclusion
    #: Signal of each input, if the file names it.
    signals: tuple[str, str] | None = None
    notes: Sequence[str] = ()  # for the user

    def add(self, said: Token, places: tuple[int, int], singleton: "Singleton") -> None:
        """Add a rule; ValueError: there is already one for its terms."""
        earlier, _ = self.rules.setdefault(places, (said, singleton))
        if earlier is not said:
            twice = "a second rule for the same two terms"
            raise said.fault(f"{twice}; the first is in line {earlier.line}")


def input_of(name: Token, low: float, high: float, shapes: Sequence[Shape]) -> Input:
    """Return an input; ValueError: a design cannot have its terms."""
    if not FEWEST <= len(shapes) <= MOST:
        fault = f"input {name.text} must have {FEWEST} to {MOST} terms (got {len(shapes)})"
        raise name.fault(fault)
    if not low < high:
        raise name.fault(f"input {name.text}: its range must rise")
    labels = [shape.label.text for shape in shapes]
    for shape in shapes:
        if labels.count(shape.label.text) > 1:
            raise shape.fault(f" is given twice in input {name.text}")
    if len({shape.gaussian for shape in shapes}) > 1:
        raise name.fault(f"input {name.text} must not mix Gaussian and straight terms")
    centres = [shape.centre(low, high) for shape in shapes]
    if shapes[0].gaussian and len(shapes) != TERMS:
        fault = f"input {name.text} must have {TERMS} Gaussian terms (got {len(shapes)})"
        raise name.fault(f"{fault}; {either('--terms N', 'terms=N')} samples them into triangles")
    order = sorted(range(len(shapes)), key=centres.__getitem__)
    terms = [shapes[k] for k in order]
    if terms[0].gaussian:
        return Input(name, low, high, labels, order, terms, [])
    called = identifiers([term.label.text for term in terms], "term")
    ends = {0: "lowest", len(terms) - 1: "highest"}
    triangles = [
        _triangle(low, high, called[k], centres[order[k]], term, ends.get(k, ""))
        for k, term in enumerate(terms)
    ]
    if message := terms_fault(tuple(triangles)):
        raise name.fault(f"input {name.text}, its terms ordered by centre: {message}")
    return Input(name, low, high, labels, order, terms, triangles)


def _triangle(
    low: float, high: float, label: str, centre: float, term: Shape, end: str
) -> TriangleRecord:
    """Return a term as a triangle; the outermost stay 1 beyond the range. ValueError: not one."""
    lowest, highest = end == "lowest", end == "highest"
    if lowest and not term.low <= low <= centre:
        raise term.fault(f", the lowest, {_SHOULDER}")
    if highest and not centre <= high <= term.high:
        raise term.fault(f", the highest, {_SHOULDER}")
    left, right = None if lowest else term.left, None if highest else term.right
    if -inf in (left, right) or inf in (left, right):
        raise term.fault(": only the outermost terms may reach infinity")
    if centre in (left, right):
        raise term.fault(f" must not have a vertical edge (got one at {centre})")
    return TriangleRecord(label=label, left=left, centre=centre, right=right)
