"""What every reader takes from a file, and what it fills in: two inputs of 2 to 11 terms, and a
singleton a rule.

What cannot be imported is a ``ValueError`` that starts with the line that it is about; the caller
puts the file before.
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
from hfc_design.core.records import TERMS, UserError

#: Longest name of a term or variable, see ``records.Label``.
LONGEST = 32
PLAIN = re.compile(r"[A-Za-z](_?[A-Za-z0-9])*")
#: Letters that are written as two, and those of which Unicode knows no plain one.
WRITTEN = {"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "æ": "ae", "œ": "oe", "ø": "o", "ł": "l"}
LETTERS = str.maketrans(WRITTEN | {k.upper(): v.title() for k, v in WRITTEN.items() if k != "ß"})
GREEK = re.compile(r"GREEK (CAPITAL|SMALL) LETTER (\w+)")


def _plain(name: str) -> str:
    """The name in ASCII: umlauts as two letters, Greek ones by name, no accents, nothing else."""

    def written(letter: re.Match[str]) -> str:
        greek = GREEK.fullmatch(unicodedata.name(letter[0], ""))
        return "" if not greek else greek[2].title() if greek[1] == "CAPITAL" else greek[2].lower()

    text = unicodedata.normalize("NFC", name).translate(LETTERS)
    return re.sub(r"[^\x00-\x7f]", written, unicodedata.normalize("NFKD", text))


def identifiers(names: Iterable[str], prefix: str, stand_ins: Sequence[str] = ()) -> list[str]:
    """The names as identifiers of every format, all different, also in lower case.

    A letter, then letters, digits and single underscores: whatever else is none becomes an
    underscore, ``prefix`` stands before what would begin with a digit. Of a name of which nothing
    is left the place decides: one of ``stand_ins``, or ``prefix`` with a number from 1 on.
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


#: Key -> values that can be imported.
Allowed = dict[str, list[str]]
#: Language -> block -> ``Allowed``.
ALLOWED: dict[str, dict[str, Allowed]] = tomllib.loads(
    Path(__file__).with_name("allowed.toml").read_text(encoding="utf-8")
)
NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?|[+-]?[Ii]nf", re.ASCII)
#: Shapes of every language that are Gaussian.
GAUSSIANS = ("Gaussian", "GaussianProduct", "gaussmf", "gauss2mf")
_SHOULDER = "must be 1 from its centre to the end of the range, as a design's outermost term is"


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
        match = pattern.fullmatch(self.text)
        return [self._replace(text=part or "") for part in match.groups()] if match else []

    def pair(self, between: str) -> "list[Token]":
        """What stands before and behind the first ``between``; none if there is none."""
        key, separator, value = self.text.partition(between)
        parts = (key, value) if separator else ()
        return [self._replace(text=part.strip()) for part in parts]

    def words(self) -> "list[Token]":
        """What stands between blanks."""
        return [self._replace(text=word) for word in self.text.split()]

    def number(self) -> float:
        """A finite number."""
        value = self.edge()
        if not isfinite(value):
            raise self.fault(f"{self.text} must be a finite number")
        return value

    def edge(self) -> float:
        """A number that may be infinite."""
        if not NUMBER.fullmatch(self.text):
            raise self.fault(f"{self.text[:40]!r} must be a number")
        return float(self.text)

    def one_of(self, key: str, allowed: Iterable[str]) -> str:
        """The text, if it is allowed as the value of a key."""
        if self.text not in allowed:
            names = [*allowed]
            listed = f"one of {', '.join(names)}" if len(names) > 1 else names[0]
            raise self.fault(f"{key} = {self.text[:40]!r} cannot be imported; must be {listed}")
        return self.text

    def place(self, labels: Sequence[str], what: str) -> int:
        """Where the text stands among ``labels``."""
        if self.text not in labels:
            known = ", ".join(labels[:TERMS]) + (", ..." if len(labels) > TERMS else "")
            raise self.fault(f"{self.text[:40]!r}: unknown {what}; available: {known}")
        return labels.index(self.text)


class Block(NamedTuple):
    """A block of a file: its name, and its entries as key and value."""

    name: Token
    entries: list[tuple[str, Token]]

    def all(self, key: str) -> list[Token]:
        """The values of a key."""
        return [value for name, value in self.entries if name == key]

    def get(self, key: str, default: str = "") -> Token:
        """The value of a key."""
        return next(iter(self.all(key)), self.name._replace(text=default))


def lines(text: str, comment: re.Pattern[str]) -> Iterator[Token]:
    """The lines that are left without comments; a group of ``comment`` is none, and stays."""
    for line, content in enumerate(text.splitlines(), 1):
        if stripped := comment.sub(r"\1", content).strip():
            yield Token(line, stripped)


def chosen(outputs: Sequence[Token], wanted: str | None) -> int:
    """Which output is ``wanted``; UserError, ValueError: there is none of that name, or several."""
    names = [name.text for name in outputs]
    listed = ", ".join(names)
    if wanted is None and len(names) > 1:
        raise outputs[1].fault(f"--output must name one of the outputs {listed}")
    if wanted is not None and wanted not in names:
        raise UserError(f"--output {wanted}: unknown output; available: {listed}")
    return 0 if wanted is None else names.index(wanted)


def check_known(key: str, value: Token, allowed: Allowed, where: str) -> None:
    """Refuses what is not known: what it means is not known, so that it cannot be left out."""
    if key not in allowed:
        raise value.fault(f"{where}: unknown key {key[:40]!r}")
    if allowed[key]:
        value.one_of(key, allowed[key])


class Shape(NamedTuple):
    """A term as a file has it."""

    label: Token
    gaussian: bool
    left: float  # where it is no longer 0; sigma of a Gaussian
    low: float  # it is 1 from here
    high: float  # to here
    right: float

    def fault(self, message: str) -> ValueError:
        """An error about the term, whose label stands before the message."""
        return self.label.fault(f"term {self.label.text}{message}")

    def centre(self, lowest: float, highest: float) -> float:
        """Where it is 1 in a range, or the middle of that; a straight one has to be a triangle."""
        if self.gaussian:
            return 0.5 * (self.low + self.high)
        if self.low == self.high:
            return self.low
        if (self.low <= lowest) == (self.high >= highest):
            raise self.fault(
                f" must be a triangle (got flat from {self.low} to {self.high}); only the "
                f"outermost terms may be flat, up to the end of the range ({lowest} to "
                f"{highest})"
            )
        return self.high if self.low <= lowest else self.low


def shape_of(label: Token, kind: str, letters: str, numbers: Sequence[float]) -> Shape:
    """The term with these numbers; ValueError: it is none of a design.

    ``letters`` are a for the first number and so on, of left, low, high and right; - and + are
    infinite.
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
    """An input with a design's terms from the lowest to the highest."""

    name: Token
    low: float
    high: float
    labels: list[str]  # in the order of the file
    order: list[int]  # of each term the place of its label
    terms: list[Shape]
    triangles: list[TriangleRecord]  # the same, if they are straight


class Singleton(NamedTuple):
    """What a rule concludes."""

    label: str  # "": it has none
    value: float


class Output(NamedTuple):
    """The output; what is empty or infinite the file does not say."""

    name: str
    low: float = -inf
    high: float = inf
    labels: Sequence[str] = ()  # of its terms


class System(NamedTuple):
    """What a file says; rules by the places of the first and the second input's labels."""

    name: str  # "": none
    inputs: tuple[Input, Input]
    output: Output
    rules: dict[tuple[int, int], tuple[Token, Singleton]]  # -> what says so, what it concludes
    #: Which signal each input is, where the file says so.
    signals: tuple[str, str] | None = None
    notes: Sequence[str] = ()  # for the user

    def add(self, said: Token, places: tuple[int, int], singleton: "Singleton") -> None:
        """A rule more; ValueError: it is not the first for its terms."""
        earlier, _ = self.rules.setdefault(places, (said, singleton))
        if earlier is not said:
            raise said.fault(
                f"a second rule for the same two terms; the first is in line {earlier.line}"
            )


def input_of(name: Token, low: float, high: float, shapes: Sequence[Shape]) -> Input:
    """An input; ValueError: its terms are not those of a design."""
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
        raise name.fault(f"{fault}; --terms N samples them into triangles")
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
    """A term; the outermost are 1 up to the range's end and beyond."""
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
