"""Candidates for the segments of an experiment, each from rest to rest inside limits.

Moves to and fro at several speeds, sines of the reference, and, if a signal may be added to the
command, binary noise and sweeps there, while the axis moves slowly so that its friction slides.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats
from hfc_design.motion.references import Trapezoidal

#: Shares of the largest speed and of the travel of moves; frequencies of sines [Hz].
SPEEDS, TRAVELS = (1.0, 0.5, 0.2, 0.05, 0.01), (1.0, 0.3, 0.05)
FREQUENCIES = (0.5, 1, 2, 4, 8, 16, 32)
#: Amplitudes of added signals as shares of the largest command; samples of a bit of binary noise.
ADDED, BITS = (0.03, 0.1, 0.3), (1, 2, 4)
#: Speed, as a share of the largest one, below an added signal.
SLOW = 0.2
#: Time for a change of the acceleration, as a share of that for the largest speed.
JERK = 0.5
#: Share of a segment in which a sine fades in and out.
FADE = 0.1
#: Highest frequency of a sine of the reference, and of an added sweep [sampling rate].
HIGHEST, SWEPT = 0.1, 0.4


class Limits(NamedTuple):
    """Largest values of an axis, in units of its drive."""

    travel: float  # from end to end
    speed: float
    acceleration: float  # of the reference
    command: float


class Segment(NamedTuple):
    """A part of an experiment, from rest to rest in the middle of the travel."""

    words: str  # beside what ``told`` adds
    reference: Floats  # (steps,) from the middle of the travel
    added: Floats  # (steps,) to the command
    moves: Sequence[tuple[float, float]] = ()  # place and speed of each, if it has only moves

    def told(self, units: Mapping[str, str]) -> str:
        """Return what the segment is, with its sizes, in the units of its signals."""
        place, added = units["error"], float(np.abs(self.added).max())
        if added:
            return f"{self.words}, up to {added:.3g} {units['command']}"
        if not self.moves:
            return f"{self.words}, up to {np.abs(self.reference).max():.3g} {place}"
        ends, speed = [x for x, _ in self.moves], self.moves[0][1]
        return f"{len(ends)} moves of {np.ptp(ends):.3g} {place} at {speed:.3g} {place}/s"


def segments(limits: Limits, every: float, steps: int, add: bool) -> Iterator[Segment]:
    """Yield all candidates of a length within limits."""
    travel, speed, acceleration, command = limits
    still, time = np.zeros(steps), every * np.arange(steps)
    ends = np.minimum(np.arange(steps), np.arange(steps)[::-1])
    fade = np.clip(ends / (FADE * steps), 0.0, 1.0)
    fade = fade**2 * (3.0 - 2.0 * fade)
    for share in SPEEDS:
        for far in TRAVELS:
            if move := _to_and_fro(share * speed, far * travel, acceleration, every, steps):
                yield move
    for hz in FREQUENCIES:
        if hz * steps * every >= 1.0 and hz < HIGHEST / every:
            sine = fade * np.sin(2.0 * np.pi * hz * time)
            most = (0.5 * travel, speed * every, acceleration * every**2)
            swing = min(x / np.abs(np.diff(sine, n)).max() for n, x in enumerate(most))
            yield Segment(f"sine of the reference, {hz:g} Hz", swing * sine, still)
    if add:
        slow = _to_and_fro(SLOW * speed, travel, acceleration, every, steps)
        below, random = slow.reference if slow else still, np.random.default_rng(0)
        for share in ADDED:
            for bits in BITS:
                noise = random.choice([-1.0, 1.0], -(-steps // bits)).repeat(bits)[:steps]
                words = f"binary noise added, {bits * every:g} s a bit"
                yield Segment(words, below, share * command * fade * noise)
            phase = np.cumsum(np.geomspace(2.0 / (steps * every), SWEPT / every, steps)) * every
            sweep = share * command * fade * np.sin(2.0 * np.pi * phase)
            yield Segment(f"sweep added to {SWEPT / every:g} Hz", below, sweep)


def _to_and_fro(
    speed: float, distance: float, acceleration: float, every: float, steps: int
) -> Segment | None:
    """Return moves to and fro through the middle, with limited jerk; None: not one fits."""
    half, whole = (_move(way, speed, acceleration, every) for way in (0.5 * distance, distance))
    soft = max(round(JERK * speed / acceleration / every), 1)
    more = (steps - 2 * soft - 2 * len(half)) // len(whole)
    if more < 0:
        return None
    ends = 0.5 * distance * (-1.0) ** np.arange(more + 1)
    between = [end - np.sign(end) * whole for end in ends[:-1]]
    moved = np.concatenate([half, *between, ends[-1] - np.sign(ends[-1]) * half])
    padded = np.pad(moved, (soft - 1, steps - len(moved)))
    smooth = np.convolve(padded, np.full(soft, 1.0 / soft), "valid")
    return Segment("moves", smooth, np.zeros(steps), [(x, speed) for x in (*ends.tolist(), 0.0)])


def _move(way: float, speed: float, acceleration: float, every: float) -> Floats:
    """Return the places of a trapezoidal move by ``way``, one a sample."""
    move = Trapezoidal(distance=way, velocity=speed, acceleration=acceleration)
    time = np.asarray(every * np.arange(1, np.ceil(move.duration_s / every) + 1), float)
    return np.asarray(move.samples(time).reference)
