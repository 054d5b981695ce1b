"""Limits of a machine's axes in a program, as a user writes them."""

from collections.abc import Mapping, Sequence
from operator import not_
from typing import Annotated, NamedTuple, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from hfc_design.core.records import Finite, Label, Positive, Record, ordered
from hfc_design.motion.axis_path import Bounds


class MovedAxis(NamedTuple):
    """Axis of the machine as a program needs it."""

    name: str
    unit: float  # size of the unit of position [mm or deg]; 0: neither a length nor an angle
    rotary: bool
    top_speed: float  # of its drive [mm/s or deg/s]


class AxisLimits(Record):
    """Limits of an axis of a program, in mm or deg."""

    #: largest velocity [(mm or deg)/min]; left out: that of the drive
    velocity_per_min: Positive | None = None
    rapid_per_min: Positive | None = None  # velocity of G0 [(mm or deg)/min]; left out: the largest
    #: largest acceleration; this, or acceleration_time_s [(mm or deg)/s2]
    acceleration_per_s2: Positive | None = None
    acceleration_time_s: Positive | None = None  # time to reach the velocity of G0 [s]
    #: largest jerk on straight lines [(mm or deg)/s3]; left out: unlimited
    jerk_per_s3: Positive | None = Field(None, exclude_if=not_)
    #: travel from and to [mm or deg]; left out: unlimited
    travel: Annotated[tuple[Finite, Finite], ordered] | None = None

    @model_validator(mode="after")
    def _one_acceleration(self) -> "AxisLimits":
        if (self.acceleration_per_s2 is None) == (self.acceleration_time_s is None):
            raise ValueError(
                "acceleration_per_s2: exactly one of this and acceleration_time_s must be given"
            )
        fastest = self.velocity_per_min or np.inf
        if self.rapid_per_min is not None and self.rapid_per_min > fastest:
            raise ValueError(
                f"rapid_per_min = {self.rapid_per_min}: is more than velocity_per_min = {fastest}"
            )
        return self

    def bounds(self, top_speed: float) -> tuple[float, float, float, float]:
        """Return velocity (default: ``top_speed``), that of G0, acceleration, jerk [mm or deg]."""
        velocity = self.velocity_per_min / 60.0 if self.velocity_per_min else top_speed
        rapid = self.rapid_per_min / 60.0 if self.rapid_per_min else velocity
        acceleration = self.acceleration_per_s2 or rapid / (self.acceleration_time_s or np.inf)
        return velocity, rapid, acceleration, self.jerk_per_s3 or np.inf


#: Table ``[reference.limits]`` of a scenario: limits of each axis by its name.
Limits: TypeAlias = dict[Label, AxisLimits]


def bounds_of(limits: Mapping[str, AxisLimits], axes: Sequence[MovedAxis]) -> Bounds:
    """Return the limits of all ``axes``, in their order."""
    return Bounds(*np.array([limits[axis.name].bounds(axis.top_speed) for axis in axes]).T)
