"""What a recorded signal tells of its sensor: the step of an encoder, noise."""

import numpy as np

from hfc_design.core.numbers import SAME, Floats, Mask

#: A step is told by so many of the least changes; noise by what is this much of a step at least.
LOOKED_AT, SEEN = 50, 0.1
#: A sample is wrong that is off by so many times what all but this share bend.
WRONG, USUAL = 20.0, 0.97
#: Noise is looked for in this share of the samples, the slowest: where an axis is fast, stamps that
#: tremble look like noise of its position.
SLOW = 0.2


def step_of(values: Floats) -> float | None:
    """The step of an encoder, if the values of a log are whole steps; None if that is not seen."""
    changes = np.unique(np.round(np.abs(np.diff(values)), 15))
    steps = changes[changes > 1e-12 * max(np.abs(values).max(), 1e-300)]
    if len(steps) < 1 + (len(steps) == len(changes)):  # nothing, or a ramp
        return None
    least = float(steps[0])
    off = np.abs(steps / least - np.round(steps / least))[:LOOKED_AT]
    return float(f"{least:.4g}") if off.max() < 0.02 else None


def spikes(values: Floats) -> Mask:
    """(steps,) single samples far off both of their neighbours; those bend back by half as much."""
    bend, changes = np.diff(values, 2), np.abs(np.diff(values))
    least = changes[changes > 0].min(initial=np.inf)
    usual = max(float(np.quantile(np.abs(bend), USUAL)), least)
    back = np.pad(bend, 1)
    both = np.maximum(back[:-2] * np.sign(bend), back[2:] * np.sign(bend))
    wrong = (0.5 * np.abs(bend) > WRONG * usual) & (both < -0.25 * np.abs(bend))
    return np.r_[False, wrong, False]


def righted(values: Floats) -> tuple[Floats, Mask]:
    """Values (steps,) with the ``spikes`` on straight lines, and which these are."""
    wrong, steps = spikes(values), np.arange(len(values))
    return np.interp(steps, steps[~wrong], values[~wrong]) if wrong.any() else values, wrong


def noise_of(off: Floats, place: Floats, step: float | None) -> float | None:
    """Standard deviation of the white noise in (steps,) what a replay is off; None: none is seen.

    ``place`` (steps,) says where the axis is slow.

    Second differences leave white noise alone, of six times its variance; the largest are not
    counted, which are of reversals. 0 is where a replay does not count; rounding to a ``step`` is
    noise too, of step^2 / 12, and none of the sensor's.
    """
    counts = (off[2:] != 0) & (off[1:-1] != 0) & (off[:-2] != 0)
    speed = np.abs(place[2:] - place[:-2])
    slow = speed <= np.quantile(speed, SLOW) + SAME * speed.max() if counts.any() else counts
    bend = np.diff(off, 2)[counts & slow]
    if not bend.size:
        return None
    usual = max(float(np.median(np.abs(bend))) / 0.6745, step or 0.0)  # of a normal distribution
    size = float(np.mean(bend[np.abs(bend) <= 4.0 * usual] ** 2))
    left = size / 6.0 - (step or 0.0) ** 2 / 12.0
    least = SEEN * step if step else 1e-30
    return float(f"{np.sqrt(left):.2g}") if left > least**2 else None
