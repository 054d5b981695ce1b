"""Successive halving: number of islands in each heat of a race."""

import numpy as np

from hfc_design.core.numbers import Integers

#: Length of a heat without Gauss-Newton steps, in shares of one with them.
SHORT = 0.25


def heats(trees: int) -> list[int]:
    """Return the number of islands in each heat: all trees, then half of them, down to one."""
    sizes = [trees]
    while sizes[-1] > 1:
        sizes.append(-(-sizes[-1] // 2))
    return sizes


def room(trees: int, stepping: int, share: float) -> int:
    """Return the number of islands when a ``share`` of the race is over.

    Heats with more than ``stepping`` islands have no Gauss-Newton steps and are short.
    """
    sizes = heats(trees)
    lengths = np.array([SHORT if size > stepping else 1.0 for size in sizes])
    ends = np.cumsum(lengths) / lengths.sum()
    heat = int(np.searchsorted(ends, share + 1e-9, side="right"))
    return sizes[min(heat, len(sizes) - 1)]


def shares(count: int, islands: int) -> Integers:
    """Return the island of each of ``count`` individuals, (count,), ascending and balanced."""
    return np.sort(np.arange(count) % islands)
