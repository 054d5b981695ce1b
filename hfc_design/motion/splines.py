"""Smooth interpolation of a table that stands still where its rows do."""

from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.interpolate import CubicSpline, PPoly

from hfc_design.core.numbers import Floats

#: Largest difference of rows that are a rest, as a share of the whole way.
STILL = 1e-9


def spline(times: Floats, values: Floats) -> PPoly:
    """Return the cubic spline through rows; it rests in three equal rows, at an end in two.

    One spline through all rows would oscillate through a rest with decreasing amplitude and never
    stop: the axis would be told to creep. Therefore each move between two rests is a separate
    spline, with speed 0 at the rests. Two equal rows between others may be the rows beside a
    turning point.
    """
    still = np.abs(np.diff(values)) <= STILL * np.ptp(values)
    ends = [0, *(np.flatnonzero(np.diff(still)) + 1).tolist(), len(still)]
    for begin, end in pairwise(ends):
        if end - begin == 1 and 0 < begin < len(still) - 1:
            still[begin] = False
    ends = [0, *(np.flatnonzero(np.diff(still)) + 1).tolist(), len(still)]
    parts = []
    for begin, end in pairwise(ends):
        if still[begin]:
            rest = np.zeros((4, end - begin))
            rest[3] = values[begin:end]
            parts.append(rest)
            continue
        rows, sides = slice(begin, end + 1), (_side(begin > 0), _side(end < len(still)))
        parts.append(CubicSpline(times[rows], values[rows], bc_type=sides).c)
    return PPoly(np.concatenate(parts, axis=1), times)


def _side(rests: bool) -> Literal["clamped", "not-a-knot"]:
    return "clamped" if rests else "not-a-knot"
