"""Stress tests of a design beyond the scenario: a delay, a mode, a load, a gap."""

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from hfc_design.core.records import NotNegative, Positive, Quantity, Record

Share = Annotated[float, Field(gt=0, lt=1)]
Factor = Annotated[float, Field(ge=1, le=100)]
#: Share of the sampling rate above which no mode is tried; number of frequencies that are tried.
HIGHEST, MODES = 0.25, 4
#: Stresses that robust.tolerances may set instead.
ALSO = ("delay_samples", "load", "noise")


class Mode(Record):
    """A known mode that the model lacks, from a log for example."""

    hz: Positive  # frequency [Hz]
    damping: Share = 0.02  # damping ratio [1]
    #: inertia on the spring, relative to the rest [1]; -1: the measured part is on the spring
    share: Annotated[float, Field(ge=-1, le=100)] = -1.0


class StressSettings(Record):
    """Stresses that the answer adds to the scenario, one at a time; 0 leaves one out."""

    delay_samples: Annotated[float, Field(ge=0, le=16)] = 1.0  # additional delay [samples]
    lag_samples: NotNegative = 0.5  # additional time constant of the current loop [samples]
    noise: Factor = 2.0  # factor on the noise of the sensors [1]; 1: no test
    #: load on every axis, in both directions, and as a step after a third of the motion [load];
    #: left out: the largest constant load of a motion, else the largest varying load, else the load
    #: that a tenth of the largest command holds
    load: Quantity | None = None
    friction: Factor = 2.0  # factor on all friction, and its inverse [1]; 1: no test
    sticking: NotNegative = 0.25  # additional friction at rest, as a share of Coulomb friction [1]
    mode_damping: Share = 0.02  # damping ratio of a mode that the model does not have [1]
    #: inertia on a spring, as shares of the moving inertia [1]; from twice the crossover to a
    #: quarter of the sampling rate
    mode_inertia: tuple[Share, ...] = (0.1, 1.0 / 3.0)
    modes: tuple[Mode, ...] = ()  # modes found in a log
    #: frequency below which a log shows no other mode [Hz]; above it any mode is possible
    unknown_above_hz: Positive | None = None
    #: position of the encoder; at the drive there is no mode before it
    encoder_at: Literal["load", "drive"] = "load"
    backlash_steps: NotNegative = 3.0  # backlash before the feedback encoder [steps]
    start: NotNegative = 0.1  # initial error, as a share of the travel in the fastest second [1]
    #: share of every motion that is reversed [1]
    backwards: Annotated[float, Field(ge=0, le=1)] = 1.0
    jitter: Annotated[float, Field(ge=0, le=0.9)] = 0.1  # jitter of the sample time [1]
    rest_s: NotNegative = 60.0  # time at rest after every motion [s]
    #: machines for each test, the nominal one first
    machines: Annotated[int, Field(ge=1, le=1000)] = 32
    share: Share = 0.9  # share of the machines stable without stress that must stay stable [1]

    @property
    def far_modes(self) -> bool:
        """True if there may be an unknown mode between drive and encoder."""
        return self.unknown_above_hz is not None and self.encoder_at == "load"

    def modes_between(self, crossover: Any, every: float) -> tuple[Any, float]:
        """Return the lowest and the highest frequency of a possible unknown mode [Hz].

        ``crossover`` is that of the loop [Hz] (None: unknown; then the lowest is infinite), and
        ``every`` the sample time [s].
        """
        lowest = np.inf if crossover is None else 2.0 * crossover
        return np.maximum(lowest, self.unknown_above_hz or 0.0), HIGHEST / every
