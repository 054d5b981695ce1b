"""Input shapers: impulses with which references are convolved, so that a mode does not vibrate on.

ZV and ZVD: Singer and Seering, J. Dyn. Syst. Meas. Control 112, 1990. MZV: Klipper. EI, with one to
three humps, for a residual vibration of 5 %: Singhose et al., J. Mech. Des. 116, 1994, and J. Dyn.
Syst. Meas. Control 119, 1997. With damping, impulses fall as the vibration does, as in Klipper.
"""

from functools import partial

import numpy as np
from jax import tree

from hfc_design.core.numbers import Floats, Series
from hfc_design.motion.samples import AxisSamples, PathFrame

#: Sizes of evenly spaced impulses for a mode without damping, and the last delay in periods.
SHAPERS = {
    "none": ([1.0], 0.0),
    "zv": ([0.5, 0.5], 0.5),
    "mzv": ([1.0 - 0.5**0.5, 2.0**0.5 - 1.0, 1.0 - 0.5**0.5], 0.75),
    "zvd": ([0.25, 0.5, 0.25], 1.0),
    "ei": ([0.2625, 0.475, 0.2625], 1.0),
    "2hump_ei": ([0.1597972, 0.3402028, 0.3402028, 0.1597972], 1.5),
    "3hump_ei": ([0.1123796, 0.2375, 0.3002408, 0.2375, 0.1123796], 2.0),
}


def impulses(kind: str, hz: float, damping: float) -> Floats:
    """Return sizes and delays [s] (2, impulses) for a mode with ``damping``, of ``hz`` without."""
    even, last = SHAPERS[kind]
    periods, root = np.linspace(0.0, last, len(even)), (1.0 - damping**2) ** 0.5
    sizes = np.array(even) * np.exp(-2.0 * np.pi * damping / root * periods)
    return np.stack([sizes / sizes.sum(), periods / (hz * root)])


def shaped(
    references: list[AxisSamples], path: PathFrame | None, time: Floats, shapers: list[Floats]
) -> tuple[list[AxisSamples], PathFrame | None]:
    """Return references at ``time`` (steps,) [s] after the shaper of each axis.

    A path, and the places on it where the axes should be, are late by the mean delay: what shapers
    change of a contour is an error.
    """
    delay = np.mean([sizes @ delays for sizes, delays in shapers])
    if not delay:
        return references, path
    late, ways = partial(np.interp, time - delay, time), []

    def mean(shaper: Floats, column: Series, before: float = 0.0) -> Series:
        return sum(a * np.interp(time - t, time, column, left=before) for a, t in shaper.T)

    for one, shaper in zip(references, shapers, strict=True):
        place, rate = mean(shaper, one.target, one.target[0]), mean(shaper, one.reference_rate)
        target = place if path is None else late(one.target)
        change = mean(shaper, one.reference_acceleration)
        ways.append(AxisSamples(place, rate, None, None, target, change))
    return ways, tree.map(late, path)
