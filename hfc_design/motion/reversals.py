"""Reversals of axes: the errors after them (quadrant glitches), and undisturbed parts of a path."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Indices, Mask, first_at
from hfc_design.motion.samples import PathSamples

#: Time from a sign change of an axis' velocity in which its quadrant glitch is looked for [s].
GLITCH_TIME = 1.0
#: Share of the largest velocity below which the velocity of an axis is only rounding of a tangent.
MOVES = 1e-9


class Glitch(NamedTuple):
    """Contour error after the reversal of an axis."""

    time_s: float  # of the first sample with the new direction
    axis: str  # the axis that reverses
    error: float  # the contour error that is largest in magnitude soon after the reversal
    worst_s: float  # time of this error [s]


def glitches(time: Floats, samples: PathSamples, error: Floats) -> list[Glitch]:
    """Return the reversals of commanded velocities, each with the contour error that follows it.

    Args:
        time: (steps,) [s].
        samples: the trajectory in X-Y at these times.
        error: (steps,) contour error.
    """
    return after_reversals(time, dict(zip("XY", samples.velocity, strict=True)), error)


def after_reversals(time: Floats, velocities: Mapping[str, Floats], error: Floats) -> list[Glitch]:
    """Return the ``glitches`` of axes with (steps,) ``velocities`` by their names."""
    glitch_list, largest = [], _largest([*velocities.values()])
    for axis, velocity in velocities.items():
        for index in _reversals(velocity, largest)[1:]:
            window = error[_soon_after(time, index)]
            worst = index + int(np.abs(window).argmax())
            glitch_list.append(
                Glitch(float(time[index]), axis, float(error[worst]), float(time[worst]))
            )
    return sorted(glitch_list)


def turns(reference: Floats) -> list[int]:
    """Return the indices of the samples at which a ``reference`` (steps,) turns back, or ends."""
    moving = np.flatnonzero(change := np.diff(reference))
    back = np.flatnonzero(np.diff(np.sign(change[moving])))
    # Changes are between samples: the turning point is the sample to which the last change led.
    return [*(moving[back] + 1).tolist(), *(moving[-1:] + 1).tolist()]


def turned_back(reference: Floats) -> tuple[Floats, Floats]:
    """Return the last turning point (or end) of a ``reference`` (steps,), and how it was reached.

    Returns:
        Position of this point (steps,); 1 or -1 if the axis came from below or above. First both 0.
    """
    change = np.diff(reference)
    end, side = np.zeros(len(reference)), np.zeros(len(reference))
    for place in turns(reference):
        end[place:], side[place:] = reference[place], np.sign(change[place - 1])
    return end, side


def reversing(time: Floats, velocities: Floats) -> Mask:
    """Return (steps,) True within ``GLITCH_TIME`` after a reversal in ``velocities`` of axes."""
    return _within(time, velocities, first=1)


def undisturbed(time: Floats, velocities: Floats, window: float = GLITCH_TIME) -> Mask:
    """Return (steps,) True except within ``window`` [s] after the start or reversal of an axis."""
    return ~_within(time, velocities, 0, window)


def _within(time: Floats, velocities: Floats, first: int, window: float = GLITCH_TIME) -> Mask:
    mask, largest = np.zeros(len(time), bool), _largest(velocities)
    for velocity in velocities:
        for index in _reversals(velocity, largest)[first:]:
            mask[_soon_after(time, index, window)] = True
    return mask


def _largest(velocities: Sequence[Floats] | Floats) -> float:
    return max((float(np.abs(velocity).max()) for velocity in velocities), default=0.0)


def _reversals(velocity: Floats, largest: float) -> Indices:
    """Return the first samples in a new direction: at the start, and after each reversal."""
    moving = np.flatnonzero(np.abs(velocity) > MOVES * largest)
    return moving[np.diff(np.sign(velocity[moving]), prepend=0.0) != 0]


def _soon_after(time: Floats, index: int, window: float = GLITCH_TIME) -> slice:
    return slice(index, first_at(time, time[index] + window))
