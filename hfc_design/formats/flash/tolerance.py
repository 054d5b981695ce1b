"""How far the commands of code may be off, and where code in float can be asked for them.

Of a controller that decides (which rule is to blame, whether an integral is held) rounding may
decide otherwise, and from there on it does something else, with equal right. Where a decision is
as close as that, commands are not compared until all is forgotten.
"""

from collections.abc import Iterator
from random import Random
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats
from hfc_design.formats.flash.driving import RESETS

#: Of a command in double precision, in shares of the largest one.
DOUBLE = 1e-12
#: By how much more than the runtime in single precision C may be off: it sums in another order.
MARGIN = 4.0
#: What single precision is off by at least, in shares of the largest command.
ROUNDING = 2.0**-21
#: Inputs are off by so many roundings, where it is tried whether a decision is close.
NOISE = 16.0
#: Commands that are off by so much more than before have come of another decision; those of inputs
#: that are off by ``NOISE`` roundings may be off by four times as many.
JUMP = 16.0
#: Times that it is tried, each with a noise and its opposite, which is on the other side.
TRIES = 2


class Tolerance(NamedTuple):
    """Of a command, in its unit."""

    double: float
    single: float
    alike: tuple[bool, ...]  # (samples,) whether single precision decides as double does


def rounded(inputs: Floats) -> Iterator[Floats]:
    """The inputs in single precision, and off by up to one more rounding, at every call alike."""
    yield inputs.astype(np.float32).astype(float)
    yield from _disturbed(inputs, 1.0, 1)


def disturbed(inputs: Floats) -> Iterator[Floats]:
    """The inputs in single precision, off by up to ``NOISE`` roundings, at every call alike."""
    yield from _disturbed(inputs, NOISE, TRIES)


def _disturbed(inputs: Floats, noise: float, tries: int) -> Iterator[Floats]:
    for seed in range(tries):
        random = Random(seed)
        off = np.array([[random.uniform(-noise, noise) for _ in row] for row in inputs])
        for side in (1.0, -1.0):
            yield (inputs * (1.0 + side * 2.0**-23 * off)).astype(np.float32).astype(float)


def tolerance(commands: Floats, near: Floats, far: Floats) -> Tolerance:
    """Of the commands (samples, axes), and what they are in single precision, (tries, ...).

    ``near`` are those of ``rounded``, ``far`` those of ``disturbed`` inputs.
    """
    largest = float(np.abs(commands).max())
    off, further = (_off(commands, each) for each in (near, far))
    alike = np.ones(len(commands), dtype=bool)
    usual = max(ROUNDING * largest, 2.0 * float(np.median(off)))
    begins = sorted(RESETS)
    for begin, end in zip(begins, [*begins[1:], len(commands)], strict=True):
        level, first = usual, end  # of those that may have come of a decision that shows later
        for k in range(begin, end):
            if further[k] > MARGIN * max(level, off[k]):
                first = min(first, k)
            if not (off[k] <= JUMP * level and further[k] <= 4.0 * NOISE * max(level, off[k])):
                alike[min(first, k) : end] = False
                break
            level = max(level, off[k])
    worst = float(off[alike].max(initial=ROUNDING * largest / MARGIN))
    return Tolerance(DOUBLE * largest, MARGIN * worst, tuple(map(bool, alike)))


def _off(commands: Floats, tried: Floats) -> Floats:
    """(samples,) the largest difference."""
    found: Floats = np.abs(tried - commands).max(axis=(0, 2))
    return found
