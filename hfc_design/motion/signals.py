"""What the world does to the closed loop: reference, load and sensor noise, sampled.

Positions, loads and commands count in the units of the plant (``Plant.units``): rad, N m and V
for the C-axis; BLU and units of the converter for a feed drive.
"""

import warnings
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, ValidationInfo

from hfc_design.core.records import Finite, NotNegative, Positive, Record

Floats = NDArray[np.float64]


class AxisSamples(NamedTuple):
    """What happens to one axis, one column a control sample."""

    reference: Any  # (steps,) what the control is told, in whole steps if it counts
    reference_rate: Any  # (steps,)
    loads: Any  # (2 substeps + 1, steps) load where the integrator needs it
    noise: Any  # (encoders, steps) added to the encoders' readings
    target: Any  # (steps,) where the axis should be


class PathFrame(NamedTuple):
    """The path of an X-Y machine where it should be, one column a control sample."""

    tangent_x: Any  # (steps,) unit vector along the path
    tangent_y: Any
    curvature: Any  # (steps,) positive to the left [1 / unit of the position]


class Samples(NamedTuple):
    """Everything that happens to the loop, one column a control sample."""

    axes: tuple[AxisSamples, ...]
    path: PathFrame | None  # None for a machine of one axis
    settled: Any  # (steps,) 1 once the loop should have settled, before that 0
    sample_time: Any  # scalar [s]


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


class Table(Record):
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


class Ramp(Record):
    """Constant velocity from rest at zero."""

    kind: Literal["ramp"] = "ramp"
    velocity: Finite = 0.02

    def at(self, time: Floats) -> Floats:
        """Reference."""
        return self.velocity * time

    def rate(self, time: Floats) -> Floats:
        """Reference velocity."""
        return np.full_like(time, self.velocity)


class Sine(Record):
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


class Step(Record):
    """A jump, then hold."""

    kind: Literal["step"] = "step"
    height: Finite
    time_s: NotNegative = 0.0

    def at(self, time: Floats) -> Floats:
        """Reference."""
        return np.where(time >= self.time_s, self.height, 0.0)

    def rate(self, time: Floats) -> Floats:
        """Reference velocity: zero, also at the jump."""
        return np.zeros_like(time)


class Trapezoidal(Record):
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


Reference = Annotated[Ramp | Sine | Step | Trapezoidal | Table, Field(discriminator="kind")]


class LoadSine(Record):
    """``amplitude sin(frequency t + phase)``."""

    amplitude: Finite
    frequency_rad_s: Positive
    phase_rad: Finite = 0.0


class Load(Record):
    """Load: a constant, any number of sines and a table, added up (LL eq. 7)."""

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


class Simulation(Record):
    """Duration and step: LL prints neither; one RK4 step a millisecond is exact to 1e-8 rad."""

    duration_s: Positive = 10.0
    sample_time_s: Positive = 0.001
    substeps: int = Field(1, ge=1, le=1000)

    @property
    def steps(self) -> int:
        """Number of control samples."""
        return round(self.duration_s / self.sample_time_s)

    @property
    def time(self) -> Floats:
        """(steps,) time of each sample [s]."""
        return np.arange(self.steps, dtype=np.float64) * self.sample_time_s
