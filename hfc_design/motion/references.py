"""What one axis is to follow, and what loads it, as a user writes them."""

import warnings
from abc import abstractmethod
from operator import not_
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field, ValidationInfo

from hfc_design.core.records import Finite, Label, NotNegative, Positive, Record
from hfc_design.core.shapes import Floats


def table_of(path: Path) -> tuple[Floats, Floats]:
    """The two columns of a CSV file.

    Raises:
        ValueError: the file cannot be read, or is not two finite columns with rising time.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # an empty file is refused below
            data = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    except OSError as error:
        raise ValueError(f"cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        raise ValueError(f"is no table of numbers: {error}") from None
    if data.shape[1] != 2 or len(data) < 2:
        raise ValueError(f"needs two columns and at least two rows, not {data.shape[::-1]}")
    if not np.isfinite(data).all():
        raise ValueError("has a number that is not finite")
    if not (np.diff(data[:, 0]) > 0).all():
        raise ValueError("needs a first column (time in s) that rises from row to row")
    return data[:, 0], data[:, 1]


def _readable(file: Path, info: ValidationInfo) -> Path:
    """A relative path starts at the folder of the file that names it."""
    path = Path((info.context or {}).get("folder", "")) / file
    table_of(path)
    return path


CsvFile = Annotated[Path, AfterValidator(_readable)]


class Profile(Record):
    """A reference of one axis; each kind gives the three in its own way."""

    @abstractmethod
    def at(self, time: Floats) -> Floats:
        """Reference."""

    def rate(self, time: Floats) -> Floats:
        """Reference velocity: zero, also at a jump."""
        return np.zeros_like(time)

    def acceleration_at(self, time: Floats) -> Floats:
        """Reference acceleration: zero, also at corners and jumps."""
        return np.zeros_like(time)


class Table(Profile):
    """Two columns of a CSV file with a header, linear in between, constant at both ends."""

    kind: Literal["csv"] = "csv"
    file: CsvFile  # time [s], reference

    def at(self, time: Floats) -> Floats:
        """Reference."""
        return np.interp(time, *table_of(self.file))

    def rate(self, time: Floats) -> Floats:
        """Reference velocity: the right-hand slope at a corner, 0 beyond the ends."""
        times, values = table_of(self.file)
        slopes = np.concatenate([[0.0], np.diff(values) / np.diff(times), [0.0]])
        return np.asarray(slopes[np.searchsorted(times, time, side="right")])


class Ramp(Profile):
    """Constant velocity from rest at zero."""

    kind: Literal["ramp"] = "ramp"
    velocity: Finite = 0.02

    def at(self, time: Floats) -> Floats:
        """Reference."""
        return self.velocity * time

    def rate(self, time: Floats) -> Floats:
        """Reference velocity."""
        return np.full_like(time, self.velocity)


class Sine(Profile):
    """``amplitude sin(frequency t)``."""

    kind: Literal["sine"] = "sine"
    amplitude: Finite
    frequency_rad_s: Positive

    def at(self, time: Floats) -> Floats:
        """Reference."""
        return np.asarray(self.amplitude * np.sin(self.frequency_rad_s * time))

    def rate(self, time: Floats) -> Floats:
        """Reference velocity."""
        peak = self.amplitude * self.frequency_rad_s
        return np.asarray(peak * np.cos(self.frequency_rad_s * time))

    def acceleration_at(self, time: Floats) -> Floats:
        """Reference acceleration."""
        return np.asarray(-(self.frequency_rad_s**2) * self.at(time))


class Step(Profile):
    """A jump, then hold."""

    kind: Literal["step"] = "step"
    height: Finite
    time_s: NotNegative = 0.0

    def at(self, time: Floats) -> Floats:
        """Reference."""
        return np.where(time >= self.time_s, self.height, 0.0)


class Trapezoidal(Profile):
    """A move from rest to rest with limited velocity and acceleration, then hold."""

    kind: Literal["trapezoidal"] = "trapezoidal"
    distance: Finite
    velocity: Positive
    acceleration: Positive

    def _phases(self) -> tuple[float, float, float]:
        """Peak velocity, time of acceleration [s], time at constant velocity [s]."""
        distance = abs(self.distance)
        peak = min(self.velocity, np.sqrt(distance * self.acceleration))
        rise = peak / self.acceleration
        cruise = distance / peak - rise if peak > 0 else 0.0
        return peak, rise, cruise

    def at(self, time: Floats) -> Floats:
        """Reference."""
        peak, rise, cruise = self._phases()
        up = np.clip(time, 0.0, rise)
        even = np.clip(time - rise, 0.0, cruise)
        down = np.clip(time - rise - cruise, 0.0, rise)
        half = 0.5 * self.acceleration
        path = half * up**2 + peak * even + peak * down - half * down**2
        return np.asarray(np.sign(self.distance) * path)

    def rate(self, time: Floats) -> Floats:
        """Reference velocity."""
        peak, rise, cruise = self._phases()
        falling = 2 * rise + cruise - time
        slope = self.acceleration * np.minimum(time, falling)
        return np.asarray(np.sign(self.distance) * np.clip(slope, 0.0, peak))

    def acceleration_at(self, time: Floats) -> Floats:
        """Reference acceleration."""
        _, rise, cruise = self._phases()
        falling = 2 * rise + cruise - time
        up, down = (time >= 0) & (time < rise), (falling > 0) & (falling <= rise)
        return np.asarray(np.sign(self.distance) * self.acceleration * (1.0 * up - down))


Reference = Annotated[Ramp | Sine | Step | Trapezoidal | Table, Field(discriminator="kind")]


class EachAxis(Record):
    """A reference of its own for every axis of a machine."""

    kind: Literal["per-axis"] = "per-axis"
    axes: dict[Label, Reference]


class LoadSine(Record):
    """``amplitude sin(frequency t + phase)``."""

    amplitude: Finite
    frequency_rad_s: Positive
    phase_rad: Finite = 0.0


class AxisLoad(Record):
    """Load of an axis: a constant, any number of sines and a table, added up (LL eq. 7)."""

    constant: Finite = 0.0
    sines: tuple[LoadSine, ...] = ()
    file: CsvFile | None = None  # time [s], load

    def at(self, time: Floats) -> Floats:
        """Load."""
        total = np.full_like(time, self.constant)
        for sine in self.sines:
            total += sine.amplitude * np.sin(sine.frequency_rad_s * time + sine.phase_rad)
        if self.file is not None:
            total += np.interp(time, *table_of(self.file))
        return total


class Load(AxisLoad):
    """Load of every axis; ``axes`` has those that have a load of their own instead."""

    axes: dict[Label, AxisLoad] = Field({}, exclude_if=not_)

    def of(self, axis: str) -> AxisLoad:
        """The load of one axis."""
        return self.axes.get(axis, self)
