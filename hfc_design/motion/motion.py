"""Motion along a path: trapezoidal velocity with a limited acceleration.

The motion stops where the direction jumps, and passes from segment to segment at the lower of
both feeds, or slower where that leaves too little way to brake. The limit is that of the speed
along the path; the centripetal acceleration of an arc comes on top.
"""

from dataclasses import dataclass

import numpy as np

from hfc_design.core.shapes import Floats
from hfc_design.motion.shapes import Path


@dataclass(frozen=True, eq=False)
class Motion:
    """Phases of constant acceleration: three a segment (up, even, down), and the rest after it."""

    start: Floats  # (phases,) when each begins [s]
    distance: Floats  # (phases,) way until then [mm]
    speed: Floats  # (phases,) at its start [mm/s]
    acceleration: Floats  # (phases,) [mm/s2]
    peak: Floats  # (segments,) largest speed on each segment [mm/s]

    @property
    def duration(self) -> float:
        """When the end of the path is reached [s]."""
        return float(self.start[-1])

    def at(self, time: Floats) -> tuple[Floats, Floats, Floats]:
        """Way [mm], speed [mm/s] and acceleration along it [mm/s2] at ``time`` (steps,) [s].

        In closed form from the phase.
        """
        k = np.maximum(np.searchsorted(self.start, time, side="right") - 1, 0)
        since = np.maximum(time - self.start[k], 0.0)
        acceleration = self.acceleration[k]
        way = self.distance[k] + (self.speed[k] + 0.5 * acceleration * since) * since
        speed = np.maximum(self.speed[k] + acceleration * since, 0.0)
        return np.minimum(way, self.distance[-1]), speed, acceleration


def motion(path: Path, acceleration: float | None) -> Motion:
    """The fastest motion along ``path`` from rest to rest.

    Args:
        path: the segments and their feeds.
        acceleration: its limit [mm/s2]; None for full feed at once, corners included.
    """
    feed = path.feed / 60.0
    if acceleration is None:
        entry = leave = peak = feed
        up = down = np.zeros_like(feed)
        rate = 0.0
    else:
        rate = acceleration
        speed = _speeds_between(path, feed, rate)
        entry, leave = speed[:-1], speed[1:]
        peak = np.minimum(feed, np.sqrt(rate * path.length + 0.5 * (entry**2 + leave**2)))
        up, down = (peak - entry) / rate, (peak - leave) / rate
    rise = 0.5 * (entry + peak) * up
    fall = 0.5 * (leave + peak) * down
    even = np.maximum(path.length - rise - fall, 0.0) / peak
    end = np.cumsum(np.stack([up, even, down], axis=1))
    before = path.knots[:-1]
    ways = np.stack([before, before + rise, path.knots[1:] - fall], axis=1)
    return Motion(
        np.concatenate([[0.0], end]),
        np.append(ways, path.knots[-1]),
        np.append(np.stack([entry, peak, peak], axis=1), 0.0),
        np.append(np.tile([rate, 0.0, -rate], len(feed)), 0.0),
        peak,
    )


def _speeds_between(path: Path, feed: Floats, rate: float) -> Floats:
    """(segments + 1,) speed [mm/s] at the start of each segment and at the end of the path."""
    passing = np.where(path.corners(), 0.0, np.minimum(feed[:-1], feed[1:]))
    squares = [0.0, *(passing**2).tolist(), 0.0]
    gains = (2.0 * rate * path.length).tolist()
    for k, gain in enumerate(gains):  # no faster than it can get there
        squares[k + 1] = min(squares[k + 1], squares[k] + gain)
    for k in range(len(gains) - 1, -1, -1):  # no faster than it can brake
        squares[k] = min(squares[k], squares[k + 1] + gains[k])
    return np.sqrt(squares)
