"""Reads the X-Y motion out of a G-code program.

The language is the part of RS274/NGC that moves two axes in a plane: G0 to G3, arcs by their
centre (I, J) or their radius (R), G90/G91 positions, F, in millimetres. The machine starts at
X0 Y0. What moves neither axis is passed over: N, O, S and T words, the M codes of ``IDLE_M``,
the G codes of ``IDLE_G``, and Z in a block of its own. Everything else is refused: a program
that is understood in part would be simulated wrongly.
"""

from dataclasses import dataclass, field
from functools import lru_cache
from math import atan2, dist, hypot, pi, sqrt
from pathlib import Path

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedInput

from hfc_design.core.texts import about, content, decoded
from hfc_design.motion.paths import SAME_PLACE, Point, Segment, arc, line

GRAMMAR = r"""
block: word*
word: LETTER NUMBER?
LETTER: /[A-Za-z]/
NUMBER: /[+-]?(\d+\.?\d*|\.\d+)/
COMMENT: /\([^()\n]*\)|;[^\n]*|%/
%ignore COMMENT
%ignore /[ \t\f]+/
"""
PARSER = Lark(GRAMMAR, parser="lalr", start="block", propagate_positions=True)
#: Units, plane and modes that are so anyway; no offsets, no cutter compensation, no cycle.
IDLE_G = frozenset({17, 21, 40, 49, 54, 80, 94})
IDLE_M = frozenset({0, 1, 3, 4, 5, 6, 7, 8, 9})  # stops, spindle, tool, coolant
ENDS = frozenset({2, 30})
IDLE_LETTERS = frozenset("NOST")
LETTERS = "FGIJMRXYZ"
#: By how much the radii at both ends of an arc may differ [mm].
ROUNDING = 0.01
#: Numbers that no machine has a use for; larger ones would overflow when squared.
LARGEST = 1e6
#: Lines of a program that are read in a few seconds.
MOST_LINES = 50_000

Words = dict[str, float]


def read(file: Path, rapid: float) -> tuple[Segment, ...]:
    """The segments that the G-code program in ``file`` moves along; G0 at ``rapid`` [mm/min].

    Raises:
        UserError: the file cannot be read or used; the line says file, line number and why.
    """
    with about(file):
        return segments(text_of(file), rapid)


def text_of(file: Path) -> str:
    """The text of a program; its comments may be in any encoding.

    Raises:
        ValueError: the file cannot be read.
    """
    return decoded(content(file), "utf-8-sig", "replace")


@lru_cache(maxsize=8)
def segments(text: str, rapid: float) -> tuple[Segment, ...]:
    """The segments that the program ``text`` moves along; G0 at ``rapid`` [mm/min].

    Raises:
        ValueError: it cannot be used; the message starts with the line number.
    """
    machine, ended, lines = _Machine(rapid), False, text.split("\n")
    if len(lines) > MOST_LINES:
        raise ValueError(f"has {len(lines)} lines; allowed are {MOST_LINES}: simulate a part of it")
    for number, code in enumerate(lines, 1):
        try:
            block = PARSER.parse(code)
            ended = ended or machine.ended_by(*_sorted(block))
        except UnexpectedInput as error:
            there = error.get_context(code, span=20).splitlines()[0].strip()
            told = f"cannot be understood at column {error.column}: {there!r}"
            raise ValueError(f"line {number}: {told}") from None
        except ValueError as error:
            raise ValueError(f"line {number}: {error}") from None
    if not machine.done:
        raise ValueError("has no motion in X or Y")
    return tuple(machine.done)


def _sorted(block: Tree[Token]) -> tuple[list[float], list[float], Words]:
    """The G codes, the M codes and the other words of a block."""
    codes: dict[str, list[float]] = {"G": [], "M": []}
    words: Words = {}
    for word in block.children:
        assert isinstance(word, Tree)
        letter = str(word.children[0]).upper()
        if len(word.children) < 2:
            raise ValueError(f"{letter} has no number")
        value = float(str(word.children[1]))
        if letter in IDLE_LETTERS:
            continue
        if letter not in LETTERS:
            raise ValueError(f"{letter}{value:g}: unknown word; there is {', '.join(LETTERS)}")
        if abs(value) > LARGEST:
            raise ValueError(f"{letter}{value:g}: more than {LARGEST:g} is no machine's")
        if letter in codes:
            codes[letter].append(value)
        elif letter in words:
            raise ValueError(f"{letter} stands there twice")
        else:
            words[letter] = value
    return codes["G"], codes["M"], words


@dataclass
class _Machine:
    """What a block finds and leaves behind."""

    rapid: float  # [mm/min]
    place: Point = (0.0, 0.0)  # as programmed [mm]
    reached: Point = (0.0, 0.0)  # off it by the rounding of an arc's radii [mm]
    height: float = 0.0
    absolute: bool = True
    mode: int | None = None  # of motion: G0 to G3
    feed: float | None = None  # [mm/min]
    done: list[Segment] = field(default_factory=list)

    def ended_by(self, g_codes: list[float], m_codes: list[float], words: Words) -> bool:
        """Carry out a block; whether it ends the program."""
        self._set_modes(g_codes)
        for code in m_codes:
            if code not in IDLE_M | ENDS:
                raise ValueError(f"M{code:g}: unknown code")
        if "F" in words:
            if words["F"] <= 0:
                raise ValueError(f"F{words['F']:g}: a feed has to be more than 0 mm/min")
            self.feed = words["F"]
        if words.keys() & set("XYZIJR"):
            self._move(words)
        return any(code in ENDS for code in m_codes)

    def _set_modes(self, codes: list[float]) -> None:
        moves = [int(code) for code in codes if code in (0, 1, 2, 3)]
        if len(moves) > 1:
            raise ValueError(f"G{moves[0]} and G{moves[1]} in one block")
        self.mode = moves[0] if moves else self.mode
        for code in codes:
            if code in (90, 91):
                self.absolute = code == 90
            elif code == 20:
                raise ValueError("G20: inches are not read, only millimetres (G21)")
            elif code not in IDLE_G and code not in (0, 1, 2, 3):
                raise ValueError(f"G{code:g}: unknown code")

    def _move(self, words: Words) -> None:
        if self.mode is None:
            raise ValueError("moves before any of G0, G1, G2, G3")
        here = zip("XYZ", (*self.place, self.height), strict=True)
        x, y, height = (
            (0.0 if self.absolute else at) + words[axis] if axis in words else at
            for axis, at in here
        )
        start, end = self.place, (x, y)
        in_plane = dist(start, end) >= SAME_PLACE or words.keys() & set("IJ")
        if in_plane and self.mode > 0 and height != self.height:
            raise ValueError("Z moves together with X or Y; only motion in X-Y is read")
        feed = self.feed if self.mode > 0 else self.rapid
        if feed is None:
            raise ValueError(f"G{self.mode} before any F")
        if self.mode < 2:
            if words.keys() & set("IJR"):
                raise ValueError(f"I, J or R with G{self.mode}; they belong to G2 and G3")
            if dist(self.reached, end) >= SAME_PLACE:
                self.done.append(line(self.reached, end, feed))
                self.reached = end
        elif words.keys() & set("XYIJR"):
            centre = _centre(start, end, words, self.mode == 3)
            if dist(self.reached, centre) < SAME_PLACE:
                raise ValueError("an arc smaller than the rounding of the one before")
            sweep = _sweep(start, end, centre, self.mode == 3)
            self.done.append(arc(self.reached, centre, sweep, feed))
            share = dist(self.reached, centre) / dist(end, centre)
            x, y = (about + share * (to - about) for about, to in zip(centre, end, strict=True))
            self.reached = (x, y)
        self.place, self.height = end, height


def _centre(start: Point, end: Point, words: Words, ccw: bool) -> Point:
    """Of an arc, from its I and J, or from its R (negative: more than half a circle)."""
    x, y = end[0] - start[0], end[1] - start[1]
    chord = hypot(x, y)
    if "R" in words:
        if words.keys() & {"I", "J"}:
            raise ValueError("an arc with R as well as I or J")
        if chord < SAME_PLACE:
            raise ValueError("an arc with R has to end elsewhere; a full circle needs I or J")
        radius = abs(words["R"])
        if radius < chord / 2 - ROUNDING:
            raise ValueError(f"R{words['R']:g} is too small for ends {chord:.6g} mm apart")
        height = sqrt(max(radius**2 - chord**2 / 4, 0.0))
        left = height if ccw == (words["R"] > 0) else -height
        return start[0] + x / 2 - left * y / chord, start[1] + y / 2 + left * x / chord
    centre = start[0] + words.get("I", 0.0), start[1] + words.get("J", 0.0)
    first, last = dist(start, centre), dist(end, centre)
    if min(first, last) < SAME_PLACE:
        raise ValueError("an arc without a centre: neither I, J nor R, or all are 0")
    if abs(first - last) > ROUNDING:
        raise ValueError(
            f"the arc's radii differ: {first:.6g} mm at its start, {last:.6g} mm at its end"
        )
    return centre


def _sweep(start: Point, end: Point, centre: Point, ccw: bool) -> float:
    """Angle [rad] from start to end about the centre, ccw if positive; a full turn if equal."""
    if dist(start, end) < SAME_PLACE:
        return 2 * pi if ccw else -2 * pi
    turn = atan2(end[1] - centre[1], end[0] - centre[0])
    turn -= atan2(start[1] - centre[1], start[0] - centre[0])
    return turn % (2 * pi) if ccw else -(-turn % (2 * pi))
