"""Reduction of long curves to the number of points that a picture can show."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hfc_design.core.numbers import Floats
from hfc_design.plotting.figure import drawable

#: Slices of time of a drawn curve, with at most two points in each.
SLICES = 500


def thinned(time: Floats, values: NDArray[Any]) -> tuple[Floats, NDArray[Any]]:
    """Return the curve reduced to the lowest and highest point of each slice, and its ends."""
    values, size = drawable(values), -(-len(values) // SLICES)
    if size <= 2:
        return time, values
    slices = np.pad(values, (0, -len(values) % size), mode="edge").reshape(-1, size)
    first = size * np.arange(len(slices))
    ends = [[0, len(values) - 1], first + slices.argmin(axis=1), first + slices.argmax(axis=1)]
    keep = np.unique(np.minimum(np.concatenate(ends), len(values) - 1))
    return time[keep], values[keep]
