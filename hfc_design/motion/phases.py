"""Parts of a motion: windows of a scenario, samples at which a loop should have settled."""

from typing import Annotated

import numpy as np
from pydantic import Field

from hfc_design.core.numbers import SAME, Floats, Mask, first_at
from hfc_design.core.records import NotNegative, Positive, Record
from hfc_design.motion.samples import Simulation


class Window(Record):
    """Part of the motion for which every metric is given separately, a cycle for example."""

    #: prefix of the names of its metrics
    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,31}$")]
    from_s: NotNegative = 0.0  # start [s]
    to_s: Positive | None = None  # end [s]; left out: that of the motion

    def part(self, simulation: Simulation) -> slice:
        """Return the window as a slice of the samples of a simulation."""
        time = simulation.time
        end = None if self.to_s is None else first_at(time, self.to_s)
        return slice(first_at(time, self.from_s), end)


def settled_samples(time: Floats, settled_after: float) -> Mask:
    """Return (steps,) True where the loop should have settled; all if the motion ends before."""
    goes_on = time[-1] > settled_after * (1.0 + SAME)
    return np.arange(len(time)) >= (first_at(time, settled_after) if goes_on else 0)


def late_samples(time: Floats) -> Floats:
    """Return (steps,) 1 and 2 in the two halves of the last quarter of a motion, 0 before it."""
    left = len(time) - np.arange(len(time))  # samples from here to the end
    return np.where(8 * left <= len(time), 2.0, np.where(4 * left <= len(time), 1.0, 0.0))


def slides(rate: Floats) -> Mask:
    """Return (steps,) True where an axis has at least half its largest speed (so no reversal)."""
    speed = np.abs(rate)
    return (speed > 0.0) & (speed * (1.0 + SAME) >= 0.5 * speed.max(initial=0.0))
