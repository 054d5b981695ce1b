"""Reader of the motion of any axes in a G-code program.

The language is the part of RS274/NGC that moves X, Y, Z [mm or inch] and A, B, C [deg]: G0 to G3,
with arcs in X-Y, Z-X or Y-Z (G17 to G19) by centre (I, J, K) or radius (R), of P turns, while other
axes may move too; G4 for rests, G20/G21 for units, G90/G91 for positions, G93 to G95 for feeds.
Words that move no axis are ignored: N, O and T words, ``IDLE_M``, ``IDLE_G``; ``notes`` lists codes
on which machines may differ. Everything else is refused: a program that is understood in part would
be simulated wrongly. All facts are those of LinuxCNC's reference (``gcode.toml``).
"""

import re
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from math import atan2, copysign, dist, hypot, pi, remainder, sqrt
from pathlib import Path
from typing import Any, NamedTuple

from hfc_design.core.embedded_files import AnyFile, content_of
from hfc_design.core.texts import as_user_error, decoded
from hfc_design.motion.paths import SAME_PLACE, Point, Segment, arc, line

#: Comment, blanks, or a letter with its number.
PIECE = re.compile(
    r"(?P<comment>\([^()\n]*\)|;[^\n]*|%)"
    r"|(?P<letter>[A-Za-z])\s*(?P<number>[+-]?\s*(?:\d[\d\s]*(?:\.[\d\s]*)?|\.\s*\d[\d\s]*))?"
    r"|(?P<blank>\s+)",
    re.ASCII,
)
#: First character of a block that a machine may be told to skip.
SKIPPED = "/"
#: O words other than the number of a program.
FLOW = re.compile(
    r"\s*(o\s*(?:<[^<>]*>|\d+)\s*(?:sub|endsub|call|return|if|elseif|else|endif|while|endwhile|do"
    r"|repeat|endrepeat|break|continue)\b)",
    re.ASCII | re.IGNORECASE,
)
#: First character of a computed number -> what it begins.
CALCULATED = {"#": "parameters", "[": "expressions"}
#: Number of characters of a refused text that are shown.
SHOWN = 20


def words_of(block: str) -> list[tuple[str, float]]:
    """Return the words of a block: capital letters with their numbers.

    As in RS274/NGC blanks mean nothing, not even inside numbers: X- .992 is X-.992.

    Raises:
        ValueError: a letter has no number, or something is neither word nor comment.
    """
    if flow := FLOW.match(block):
        raise ValueError(f"{flow[1]}: subprograms and loops are not read; write their moves out")
    words: list[tuple[str, str | None]] = []
    place = len(block) - len(block.lstrip().removeprefix(SKIPPED))
    while place < len(block):
        piece = PIECE.match(block, place)
        if piece is None or (piece["letter"] and piece["number"] is None):
            after = block[place + (piece is not None) :].lstrip()[:1]
            if after in CALCULATED:
                raise ValueError(f"{after}: {CALCULATED[after]} are not read; write the numbers")
        if piece is None:
            there = block[max(place - SHOWN, 0) : place + SHOWN].strip()
            raise ValueError(f"cannot be understood at column {place + 1}: {there!r}")
        if piece["letter"]:
            words.append((piece["letter"].upper(), piece["number"]))
        place = piece.end()
    return [(letter, _number(letter, number)) for letter, number in words]


def _number(letter: str, number: str | None) -> float:
    if number is None:
        raise ValueError(f"{letter} has no number")
    return float("".join(number.split()))


CODES = tomllib.loads(Path(__file__).with_name("gcode.toml").read_text("utf-8"))
IDLE_G, IDLE_M, ENDS = frozenset(CODES["idle_g"]), frozenset(CODES["idle_m"]), frozenset({2, 30})
#: Accepted codes that a machine may treat differently -> how they are read.
NOTED_G = {code: how for how, codes in CODES["noted_g"].items() for code in codes}
NOTED_BLOCK = "blocks that begin with / are carried out"
#: Code -> letters of the words that belong to it, and mean nothing without it.
PARAMETERS = {float(code): letters for code, letters in CODES["parameters"].items()}
#: Refused codes, with the reason.
OTHERS: dict[str, dict[float, str]] = {
    letter: {code: why for why, codes in CODES[key].items() for code in codes}
    for letter, key in (("G", "refused_g"), ("M", "refused_m"))
}
#: Axes of the plane of arcs, by their places in ``AXES``; the third axis makes it right-handed.
PLANES = {17: (0, 1), 18: (2, 0), 19: (1, 2)}
#: Length of a unit [mm].
UNITS = {20: 25.4, 21: 1.0}
#: Unit of a feed: with G93 it is 1 / (time of the block).
FEEDS = {93: "per minute", 94: "mm/min", 95: "mm/rev"}

AXES = "XYZABC"
#: Words in the unit of length.
LENGTHS = frozenset("XYZIJKR")
IDLE_LETTERS = frozenset("NOT")
LETTERS = "ABCFGIJKMPRSXYZ"
#: Largest difference of the radii at both ends of an arc [mm]: this, or this share of the radius up
#: to a limit, both as in LinuxCNC.
ROUNDING, ROUNDED_SHARE, MOST_ROUNDING = 0.01, 0.001, 0.5
#: Largest number in a program; larger ones are of no use and would overflow when squared.
LARGEST = 1e6
#: Largest number of turns of an arc.
MOST_TURNS = 1000
#: Largest number of lines, which are read in a few seconds.
MOST_LINES = 50_000

Words = dict[str, float]
Places = tuple[float, ...]  # of X Y Z A B C
ORIGIN: Places = (0.0,) * len(AXES)


class Block(NamedTuple):
    """Straight line in all axes, or an arc in a plane with a straight line in all others."""

    line: int  # of the program
    start: Places
    end: Places
    #: Feed [mm/min] along X-Y-Z, or [deg/min] along A-B-C if only these move; None: G0.
    feed: float | None
    rest: float  # time at the start [s]
    centre: Point | None = None  # of an arc, in its plane
    sweep: float = 0.0  # [rad], positive from the first axis of the plane to the second
    plane: tuple[int, int] = PLANES[17]

    @property
    def linear(self) -> bool:
        """True if X, Y or Z moves, so that the feed is meant along X-Y-Z."""
        return self.centre is not None or _apart(self.start[:3], self.end[:3])

    @property
    def length(self) -> float:
        """Length of the way along which the feed is meant [mm or deg]."""
        if self.centre is not None:
            first, second = self.plane
            third = 3 - first - second
            radius = dist((self.start[first], self.start[second]), self.centre)
            return hypot(radius * self.sweep, self.end[third] - self.start[third])
        some = slice(3) if self.linear else slice(3, None)
        return dist(self.start[some], self.end[some])


def _apart(one: Sequence[float], other: Sequence[float]) -> bool:
    return any(abs(a - b) >= SAME_PLACE for a, b in zip(one, other, strict=True))


def text_of(file: AnyFile) -> str:
    """Read the text of a program; its comments may be in any encoding.

    Raises:
        ValueError: the file cannot be read.
    """
    return decoded(content_of(file), "utf-8-sig", "replace")


@lru_cache(maxsize=8)
def blocks(text: str, start: Places = ORIGIN) -> tuple[Block, ...]:
    """Return the motions of the program ``text`` in order, from ``start`` on.

    Raises:
        ValueError: the program cannot be used; the message starts with the line number.
    """
    machine = _Machine(start, start)
    for number, code in _lines(text):
        try:
            if machine.ended_by(number, *_sorted(words_of(code))):
                break
        except ValueError as error:
            raise ValueError(f"line {number}: {error}") from None
    return tuple(machine.done)


def notes(text: str) -> list[str]:
    """Return notes on what a machine may treat differently, each with its first line."""
    lines: dict[str, str] = {}
    for number, code in _lines(text):
        words = words_of(code)
        if code.lstrip().startswith(SKIPPED):
            lines.setdefault(SKIPPED, f"line {number}: {NOTED_BLOCK}")
        for letter, value in words:
            if letter == "G" and value in NOTED_G:
                note = f"line {number}: G{value:g}: {NOTED_G[value]}"
                lines.setdefault(f"G{value:g}", note)
        if any(letter == "M" and value in ENDS for letter, value in words):
            break
    return [*lines.values()]


def _lines(text: str) -> Iterator[tuple[int, str]]:
    """Yield numbers and texts of the lines up to the ``%`` that ends a program."""
    lines = text.split("\n")
    if len(lines) > MOST_LINES:
        raise ValueError(
            f"must have at most {MOST_LINES} lines (got {len(lines)}); simulate a part of it"
        )
    begun = False
    for number, code in enumerate(lines, 1):
        if code.lstrip().startswith("%"):
            if begun:
                return
        else:
            yield number, code
        begun = begun or bool(code.strip())


def read(file: AnyFile, rapid: float) -> tuple[Segment, ...]:
    """Return the ``segments`` of the program in ``file``.

    Raises:
        UserError: the file cannot be read or used; the message has file, line number and reason.
    """
    with as_user_error(file):
        return segments(text_of(file), rapid)


@lru_cache(maxsize=8)
def segments(text: str, rapid: float) -> tuple[Segment, ...]:
    """Return the X-Y segments of the program ``text``; G0 moves at ``rapid`` [mm/min].

    The machine starts at X0 Y0. Motion of Z is ignored, except at a feed together with X or Y.

    Raises:
        ValueError: the program cannot be used, moves another axis, or has no motion in X or Y.
    """
    moves, rest = [], 0.0
    for block in blocks(text):
        rest += block.rest
        planar = block.centre is not None or dist(block.start[:2], block.end[:2]) >= SAME_PLACE
        for axis, a, b in zip(AXES[2:], block.start[2:], block.end[2:], strict=True):
            still = abs(a - b) < SAME_PLACE and (axis != "Z" or block.plane == PLANES[17])
            if still or (axis == "Z" and (block.feed is None or not planar)):
                continue
            fault = f"axis {axis} moves together with X or Y" if planar else f"axis {axis} moves"
            raise ValueError(f"line {block.line}: {fault}; only motion in X-Y is read")
        feed = rapid if block.feed is None else block.feed
        start, end = (block.start[0], block.start[1]), (block.end[0], block.end[1])
        if block.centre is not None:
            moves.append(arc(start, block.centre, block.sweep, feed)._replace(rest=rest))
        elif planar:
            moves.append(line(start, end, feed)._replace(rest=rest))
        rest = 0.0 if planar else rest
    if not moves:
        raise ValueError("has no motion in X or Y")
    return tuple(moves)


def _sorted(block_words: list[tuple[str, float]]) -> tuple[list[float], list[float], Words]:
    """Return the G codes, the M codes and the other words of a block."""
    codes: dict[str, list[float]] = {"G": [], "M": []}
    words: Words = {}
    for letter, code in block_words:
        if why := OTHERS.get(letter, {}).get(code):
            raise ValueError(f"{letter}{code:g}: {why}")
    parameters = {
        letter for kind, code in block_words if kind == "G" for letter in PARAMETERS.get(code, "")
    }
    for letter, value in block_words:
        if letter in parameters:
            if ("G", 5.1) in block_words and letter == "Q" and value != 1.0:
                raise ValueError(f"G5.1 Q{value:g}: look-ahead is always on here (Q1)")
        elif letter not in IDLE_LETTERS | set(LETTERS):
            raise ValueError(f"{letter}{value:g}: unknown word; available: {', '.join(LETTERS)}")
        elif abs(value) > LARGEST:
            raise ValueError(f"{letter}{value:g}: must be at most {LARGEST:g} in magnitude")
        elif letter in codes:
            codes[letter].append(value)
        elif letter in words:
            raise ValueError(f"{letter} is given twice")
        elif letter not in IDLE_LETTERS:
            words[letter] = value
    if 4.0 in codes["G"]:
        times = [value for letter, value in block_words if letter in PARAMETERS[4.0]]
        if len(times) != 1 or not 0.0 <= times[0] <= LARGEST:
            raise ValueError(f"G4 must have one of P, X, U: a time of 0 to {LARGEST:g} s")
        words["G4"] = times[0]
    return codes["G"], codes["M"], words


@dataclass
class _Machine:
    """Modal state of the machine between blocks."""

    place: Places  # as programmed [mm, deg]
    reached: Places  # differs from ``place`` by the rounding of radii of arcs
    absolute: bool = True
    centres: bool = False  # G90.1: I, J and K are positions of a centre
    plane: int = 17
    unit: float = 1.0  # [mm]
    feeds: int = 94  # what F means
    mode: int | None = None  # of motion: G0 to G3
    feed: float | None = None  # [units of length/min, deg/min; other units under G93 and G95]
    speed: float = 0.0  # of the spindle: S [rev/min]
    turning: bool = False  # of the spindle
    rest: float = 0.0  # before the next motion [s]
    done: list[Block] = field(default_factory=list)

    def ended_by(
        self, number: int, g_codes: list[float], m_codes: list[float], words: Words
    ) -> bool:
        """Carry out the block in line ``number``; return True if it ends the program."""
        self._set_modes(g_codes)
        for code in m_codes:
            if code not in IDLE_M | ENDS:
                raise ValueError(f"M{code:g}: unknown code")
            if code in (3, 4, 5):
                self.turning = code != 5
        self.speed = words.pop("S", self.speed)
        self.rest += words.pop("G4", 0.0)
        if "F" in words:
            if words["F"] <= 0:
                unit = FEEDS[self.feeds]
                raise ValueError(f"F{words['F']:g}: a feed must be greater than 0 {unit}")
            self.feed = words["F"]
        if words.keys() & {*AXES, *"IJKPR"}:
            in_millimetres = {k: self.unit * x if k in LENGTHS else x for k, x in words.items()}
            self._move(number, in_millimetres)
        return any(code in ENDS for code in m_codes)

    def _set_modes(self, codes: list[float]) -> None:
        moves = [int(code) for code in codes if code in (0, 1, 2, 3)]
        if len(moves) > 1:
            raise ValueError(f"G{moves[0]} and G{moves[1]} in one block")
        self.mode = moves[0] if moves else self.mode
        for code in codes:
            if code in (90, 91):
                self.absolute = code == 90
            elif code in (90.1, 91.1):
                self.centres = code == 90.1
            elif code in PLANES:
                self.plane = int(code)
            elif code in UNITS and self.unit != UNITS[int(code)]:
                self.unit, self.feed = UNITS[int(code)], None  # a feed in the old unit is void
            elif code in FEEDS and self.feeds != code:
                self.feeds, self.feed = int(code), None  # so is a feed in the old sense
            elif code not in IDLE_G and code not in NOTED_G and code not in (0, 1, 2, 3):
                raise ValueError(f"G{code:g}: unknown code")

    def _move(self, number: int, words: Words) -> None:
        if self.mode is None and self.feed is not None:
            self.mode = 1  # as on controls that start with G1
        if self.mode is None:
            raise ValueError("moves before any of G0, G1, G2, G3")
        end = tuple(
            (0.0 if self.absolute else at) + words[axis] if axis in words else at
            for axis, at in zip(AXES, self.place, strict=True)
        )
        if self.mode > 0 and self.feeds == 93 and "F" not in words:
            raise ValueError(f"G{self.mode} needs an F in the same block under G93")
        if self.mode > 0 and self.feed is None:
            raise ValueError(f"G{self.mode} before any F")
        if self.mode > 0 and self.feeds == 95 and not (self.turning and self.speed > 0.0):
            raise ValueError(f"G{self.mode} needs S and M3 or M4 before it under G95")
        if self.mode < 2 or words.keys() <= {AXES[3 - sum(PLANES[self.plane])], "F"}:
            if words.keys() & set("IJKPR"):
                raise ValueError(f"I, J, K, P or R with G{self.mode}; they belong to G2 and G3")
            self._add(number, end)
        else:
            self._turn(number, end, words)
        self.place = end

    def _turn(self, number: int, to: Places, words: Words) -> None:
        """Add an arc in the plane to ``to``, with straight motion in all other axes."""
        plane = first, second = PLANES[self.plane]
        offsets, other = ("IJK"[first], "IJK"[second]), "IJK"[3 - first - second]
        if words.get(other):
            name = f"{AXES[first]}-{AXES[second]} (G{self.plane})"
            raise ValueError(f"{other}{words[other]:g}: must be 0 for an arc in {name}")
        turns = words.get("P", 1.0)
        if turns not in range(1, MOST_TURNS + 1):
            raise ValueError(f"P{turns:g}: must be a whole number of turns, 1 to {MOST_TURNS}")
        start, end, reached = ((at[first], at[second]) for at in (self.place, to, self.reached))
        if self.centres and "R" not in words:
            if not words.keys() >= {*offsets}:
                raise ValueError(f"an arc needs both {' and '.join(offsets)} under G90.1")
            words = words | {k: words[k] - at for k, at in zip(offsets, start, strict=True)}
        ccw = self.mode == 3
        centre = _centre(start, end, words, offsets, ccw)
        sweep = _sweep(start, end, centre, ccw)
        sweep += copysign(2 * pi * (turns - 1), sweep) + _angle(reached, start, centre)
        if dist(reached, centre) * min(abs(sweep), 1.0) < SAME_PLACE:
            raise ValueError("an arc smaller than its rounding, or that of the one before")
        share, places = dist(reached, centre) / dist(end, centre), [*to]
        for axis, about in zip(plane, centre, strict=True):
            places[axis] = about + share * (to[axis] - about)
        self._add(number, tuple(places), centre, sweep, plane)

    def _add(self, number: int, to: Places, *turning: Any) -> None:
        """Add a motion to ``to``; ``turning``: centre, sweep and plane of an arc."""
        reached = tuple(
            at if abs(at - x) < SAME_PLACE else x for at, x in zip(self.reached, to, strict=True)
        )
        if reached == self.reached and not turning:
            return
        feed = self.feed if self.mode else None
        block = Block(number, self.reached, reached, feed, self.rest, *turning)
        if feed is not None:
            unit = block.length if self.feeds == 93 else self.unit if block.linear else 1.0
            per_minute = self.speed if self.feeds == 95 else 1.0
            block = block._replace(feed=feed * unit * per_minute)
        self.done.append(block)
        self.reached, self.rest = reached, 0.0


def _centre(start: Point, end: Point, words: Words, offsets: tuple[str, str], ccw: bool) -> Point:
    """Return an arc's centre from ``offsets`` or R (negative: more than half a circle)."""
    x, y = end[0] - start[0], end[1] - start[1]
    i, j = offsets
    chord = hypot(x, y)
    if "R" in words:
        if words.keys() & {i, j}:
            raise ValueError(f"an arc with R as well as {i} or {j}")
        if chord < SAME_PLACE:
            raise ValueError(
                f"an arc with R must end at another point; a full circle needs {i} or {j}"
            )
        radius = abs(words["R"])
        if radius < chord / 2 - ROUNDING - SAME_PLACE:
            raise ValueError(f"R{words['R']:g} is too small for ends {chord:.6g} mm apart")
        height = sqrt(max(radius**2 - chord**2 / 4, 0.0))
        left = height if ccw == (words["R"] > 0) else -height
        return start[0] + x / 2 - left * y / chord, start[1] + y / 2 + left * x / chord
    centre = start[0] + words.get(i, 0.0), start[1] + words.get(j, 0.0)
    first, last = dist(start, centre), dist(end, centre)
    if min(first, last) < SAME_PLACE:
        raise ValueError(f"an arc needs a centre: {i}, {j} or R other than 0")
    rounding = min(max(ROUNDING, ROUNDED_SHARE * first), MOST_ROUNDING)
    if abs(first - last) > rounding + SAME_PLACE:
        raise ValueError(
            f"the arc's radii differ: {first:.6g} mm at its start, {last:.6g} mm at its end"
        )
    return centre


def _sweep(start: Point, end: Point, centre: Point, ccw: bool) -> float:
    """Return the angle [rad] of an arc, ccw > 0; a full turn if it ends in the same direction."""
    turn = 0.0 if dist(start, end) < SAME_PLACE else _angle(start, end, centre)
    return turn % (2 * pi) or 2 * pi if ccw else -(-turn % (2 * pi) or 2 * pi)


def _angle(start: Point, end: Point, centre: Point) -> float:
    ends, begins = (atan2(at[1] - centre[1], at[0] - centre[0]) for at in (end, start))
    return remainder(ends - begins, 2 * pi)
