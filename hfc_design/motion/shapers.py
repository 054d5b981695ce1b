"""Input shapers: impulses with which references are convolved, so that a mode does not vibrate on.

ZV and ZVD are those of Singer and Seering (J. Dyn. Syst. Meas. Control 112, 1990), MZV that of
Klipper, EI those of Singhose, Seering and Singer (J. Mech. Des. 116, 1994) and, with humps, of
Singhose, Porter, Tuttle and Singer (J. Dyn. Syst. Meas. Control 119, 1997) for a residual vibration
of 5 %. With damping, impulses fall as the vibration does, as in Klipper.
"""

from collections.abc import Sequence
from functools import partial
from math import pi, sqrt
from typing import TypeAlias

import numpy as np
from jax import tree

from hfc_design.core.numbers import Floats, Series
from hfc_design.motion.samples import AxisSamples, PathFrame

#: Sizes of the impulses of a shaper, with the sum 1, and their delays [s].
Impulses: TypeAlias = tuple[Floats, Floats]
#: Sizes of evenly spaced impulses for a mode without damping, and the last delay in periods.
SHAPERS = {
    "none": ([1.0], 0.0),
    "zv": ([0.5, 0.5], 0.5),
    "mzv": ([1.0 - sqrt(0.5), sqrt(2.0) - 1.0, 1.0 - sqrt(0.5)], 0.75),
    "zvd": ([0.25, 0.5, 0.25], 1.0),
    "ei": ([0.2625, 0.475, 0.2625], 1.0),
    "2hump_ei": ([0.1597972, 0.3402028, 0.3402028, 0.1597972], 1.5),
    "3hump_ei": ([0.1123796, 0.2375, 0.3002408, 0.2375, 0.1123796], 2.0),
}


def impulses(kind: str, hz: float, damping: float) -> Impulses:
    """Return the impulses of a shaper for a mode of ``hz`` without damping, and of this damping."""
    even, last = SHAPERS[kind]
    periods, root = np.linspace(0.0, last, len(even)), sqrt(1.0 - damping**2)
    sizes = np.array(even) * np.exp(-2.0 * pi * damping / root * periods)
    return sizes / sizes.sum(), periods / (hz * root)


def shaped(
    references: list[AxisSamples], path: PathFrame | None, time: Floats, each: Sequence[Impulses]
) -> tuple[list[AxisSamples], PathFrame | None]:
    """Return references at ``time`` (steps,) [s] after the shaper of each axis.

    A path and the places on it where the axes should be are late by the mean delay, so that what
    shapers change of a contour is an error. Between samples everything is linear.
    """
    delay = np.mean([sizes @ delays for sizes, delays in each])
    if not delay:
        return references, path
    late, ways = partial(np.interp, time - delay, time), []
    for axis, impulses in zip(references, each, strict=True):

        def mean(column: Series, before: float, impulses: Impulses = impulses) -> Series:
            pairs = zip(*impulses, strict=True)
            return sum(a * np.interp(time - t, time, column, left=before) for a, t in pairs)

        place = mean(axis.target, axis.target[0])
        rates = mean(axis.reference_rate, 0.0), None, None
        there = place if path is None else late(axis.target)
        ways.append(AxisSamples(place, *rates, there, mean(axis.reference_acceleration, 0.0)))
    return ways, tree.map(late, path)
