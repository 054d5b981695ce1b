"""What a usable design has to stand that no scenario has: a delay, a mode, a load, a gap."""

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from hfc_design.core.records import NotNegative, Positive, Quantity, Record

Share = Annotated[float, Field(gt=0, lt=1)]
Factor = Annotated[float, Field(ge=1, le=100)]
#: Share of the sampling rate above which no mode is tried, and frequencies from the lowest on.
HIGHEST, MODES = 0.25, 4
#: What of it robust.tolerances may have too.
ALSO = ("delay_samples", "load", "noise")


class Mode(Record):
    """What a log shows of a mode that the model has not."""

    hz: Positive  # frequency [Hz]
    damping: Share = 0.02  # damping ratio [1]
    #: what swings, as a share of what does not; -1: what is measured is what swings [1]
    share: Annotated[float, Field(ge=-1, le=100)] = -1.0


class StressSettings(Record):
    """What the answer tries beside the scenario's machines, one at a time; 0 leaves one out."""

    delay_samples: Annotated[float, Field(ge=0, le=16)] = 1.0  # longer delay [samples]
    lag_samples: NotNegative = 0.5  # slower current loop, its time constant [samples]
    noise: Factor = 2.0  # factor on the noise of the sensors; 1 leaves it out [1]
    #: load on every axis, one way, the other, and as a step after a third of the motion; left out:
    #: the largest constant load of a motion, of none the largest that changes, of none what a tenth
    #: of the largest command holds [load]
    load: Quantity | None = None
    friction: Factor = 2.0  # factor on all friction, and its inverse; 1 leaves it out [1]
    sticking: NotNegative = 0.25  # more friction at rest, as a share of Coulomb friction [1]
    mode_damping: Share = 0.02  # damping ratio of a mode that the model has not [1]
    #: what swings in it, as shares of all that moves; from twice the crossover to a quarter of the
    #: sampling rate [1]
    mode_inertia: tuple[Share, ...] = (0.1, 1.0 / 3.0)
    modes: tuple[Mode, ...] = ()  # which a log has shown
    #: a log shows that there is no other mode below; above, one may be there of every kind [Hz]
    unknown_above_hz: Positive | None = None
    encoder_at: Literal["load", "drive"] = "load"  # at the drive no mode lies before it
    backlash_steps: NotNegative = 3.0  # gap before the encoder that is fed back [steps]
    start: NotNegative = 0.1  # start off the reference, of the way in the fastest second [1]
    backwards: Annotated[float, Field(ge=0, le=1)] = 1.0  # every motion the other way, so far [1]
    jitter: Annotated[float, Field(ge=0, le=0.9)] = 0.1  # of the sample time [1]
    rest_s: NotNegative = 60.0  # at rest after every motion [s]
    machines: Annotated[int, Field(ge=1, le=1000)] = 32  # on which each is tried, nominal one first
    share: Share = 0.9  # of those that hold without it have to hold [1]

    @property
    def far_modes(self) -> bool:
        """Whether there may be one between drive and encoder."""
        return self.unknown_above_hz is not None and self.encoder_at == "load"

    def modes_between(self, crossover: Any, every: float) -> tuple[Any, float]:
        """Where a mode may be that nobody knows of [Hz].

        Of loops with such a ``crossover`` [Hz], None: unknown, that are sampled ``every`` [s].
        """
        lowest = np.inf if crossover is None else 2.0 * crossover
        return np.maximum(lowest, self.unknown_above_hz or 0.0), HIGHEST / every
