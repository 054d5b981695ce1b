"""References and loads of one axis, as a user writes them."""

import re
import warnings
from abc import abstractmethod
from operator import not_
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from hfc_design.core.embedded_files import WRITTEN, AnyFile, content_of, readable_by
from hfc_design.core.numbers import LARGEST_NUMBER, Floats, passed
from hfc_design.core.records import Finite, Label, NotNegative, Positive, Record
from hfc_design.core.texts import LARGEST_TABLE, decoded
from hfc_design.motion.paths import Motion, Path, line, motion
from hfc_design.motion.samples import AxisSamples


def table_of(file: AnyFile) -> tuple[Floats, Floats]:
    """Return the two columns of a CSV file; a first line without a number at its start is a header.

    Raises:
        ValueError: the file cannot be read, or is not two finite columns with rising time.
    """
    lines = decoded(content_of(file, LARGEST_TABLE), "utf-8-sig").splitlines()
    header = int(bool(lines) and not re.match(r"\s*[-+.]*[0-9]", lines[0]))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # an empty file is refused below
            data = np.loadtxt(lines, delimiter=",", skiprows=header, ndmin=2)
    except ValueError as error:
        raise ValueError(f"is not a table of numbers: {error}") from None
    if data.shape[1] != 2 or len(data) < 2:
        raise ValueError(
            "must have 2 columns and at least 2 rows (got {1} and {0})".format(*data.shape)
        )
    if not (np.abs(data) <= LARGEST_NUMBER).all():
        raise ValueError(f"must have finite numbers up to {LARGEST_NUMBER:g}")
    if not (np.diff(data[:, 0]) > 0).all():
        raise ValueError("must have a first column (time in s) that rises from row to row")
    return data[:, 0], data[:, 1]


CsvFile = Annotated[WRITTEN, readable_by(table_of)]


class Profile(Record):
    """Reference of one axis; each subclass is a kind of motion."""

    def samples(self, time: Floats) -> AxisSamples:
        """Return the reference at ``time`` (steps,) [s], not yet in steps of the drive."""
        place, rate, acceleration = self._motion(time)
        return AxisSamples(place, rate, None, None, place, acceleration)

    @abstractmethod
    def _motion(self, time: Floats) -> tuple[Floats, Floats, Floats]:
        """Return place, rate (0 at jumps) and acceleration (0 at jumps and corners)."""


class Table(Profile):
    """Two columns of a CSV file; before the first row and after the last one the axis rests.

    Between rows the table is linear, or a cubic spline, which has an acceleration to feed forward.
    """

    kind: Literal["csv"] = "csv"
    file: CsvFile  # CSV of two columns: time [s], reference [error]
    #: interpolation between rows: linear, or a cubic spline, which gives an acceleration for
    #: feed-forward
    interpolation: Literal["linear", "cubic"] = Field("linear", exclude_if="linear".__eq__)

    def _motion(self, time: Floats) -> tuple[Floats, Floats, Floats]:
        times, values = table_of(self.file)
        if self.interpolation == "cubic":
            from hfc_design.motion.splines import spline  # SciPy takes a while to import

            way, begun = spline(times, values), passed(times, time)
            place = way(np.clip(time, times[0], times[-1]))
            moves = (begun > 0) & (begun < len(times))
            now = np.maximum(time, times[begun - 1])  # at a row, in the piece after it
            rate, change = (np.where(moves, way(now, order), 0.0) for order in (1, 2))
            return place, rate, change
        slopes = np.concatenate([[0.0], np.diff(values) / np.diff(times), [0.0]])
        rate = slopes[passed(times, time)]  # at a row, the slope after it
        return np.interp(time, times, values), rate, np.zeros_like(time)


class Ramp(Profile):
    """Constant velocity from rest at zero."""

    kind: Literal["ramp"] = "ramp"
    velocity: Finite = 0.02  # velocity, from rest at zero [error/s]

    def _motion(self, time: Floats) -> tuple[Floats, Floats, Floats]:
        return self.velocity * time, np.full_like(time, self.velocity), np.zeros_like(time)


class Sine(Profile):
    """``amplitude sin(frequency t)``."""

    kind: Literal["sine"] = "sine"
    amplitude: Finite  # amplitude [error]
    frequency_rad_s: Positive  # angular frequency [rad/s]

    def _motion(self, time: Floats) -> tuple[Floats, Floats, Floats]:
        frequency = self.frequency_rad_s
        place = self.amplitude * np.sin(frequency * time)
        rate = self.amplitude * frequency * np.cos(frequency * time)
        return place, rate, -(frequency**2) * place


class Step(Profile):
    """Jump, then hold."""

    kind: Literal["step"] = "step"
    height: Finite  # height of the step [error]
    time_s: NotNegative = 0.0  # time of the step [s]

    def _motion(self, time: Floats) -> tuple[Floats, Floats, Floats]:
        still = np.zeros_like(time)
        begun = passed(np.array([self.time_s]), time) > 0
        return np.where(begun, self.height, 0.0), still, still


class Trapezoidal(Profile):
    """Move from rest to rest with limited velocity and acceleration, then hold."""

    kind: Literal["trapezoidal"] = "trapezoidal"
    distance: Finite  # distance of the move [error]
    velocity: Positive  # largest velocity [error/s]
    acceleration: Positive  # acceleration and deceleration [error/s2]
    jerk: Positive | None = Field(None, exclude_if=not_)  # largest jerk [error/s3]

    @property
    def duration_s(self) -> float:
        """Duration of the move [s]."""
        return self._along.duration if self.distance else 0.0

    @property
    def _along(self) -> Motion:
        way = line((0.0, 0.0), (abs(self.distance), 0.0), 60.0 * self.velocity)
        return motion(Path.of([way]), self.acceleration, self.jerk)

    @property
    def _parts(self) -> tuple[float, float, float]:
        """Largest velocity, time of acceleration [s] and time at constant velocity [s]."""
        distance = abs(self.distance)
        peak = min(self.velocity, np.sqrt(distance * self.acceleration))
        rise = peak / self.acceleration
        return peak, rise, distance / peak - rise if peak > 0 else 0.0

    def _motion(self, time: Floats) -> tuple[Floats, Floats, Floats]:
        way, (peak, rise, cruise) = np.sign(self.distance), self._parts
        if self.jerk and self.distance:
            place, speed, rate = self._along.at(time)
            return way * place, way * speed, way * rate
        up = np.clip(time, 0.0, rise)
        even = np.clip(time - rise, 0.0, cruise)
        down = np.clip(time - rise - cruise, 0.0, rise)
        half = 0.5 * self.acceleration
        path = half * up**2 + peak * even + peak * down - half * down**2

        falling = 2 * rise + cruise - time
        slope = self.acceleration * np.minimum(time, falling)
        phase = passed(np.array([0.0, rise, rise + cruise, 2.0 * rise + cruise]), time)
        change = way * self.acceleration * np.array([0.0, 1.0, 0.0, -1.0, 0.0])[phase]
        return way * path, way * np.clip(slope, 0.0, peak), change


Reference = Annotated[Ramp | Sine | Step | Trapezoidal | Table, Field(discriminator="kind")]


class EachAxis(Record):
    """Separate reference for every axis of a machine."""

    kind: Literal["per-axis"] = "per-axis"
    axes: dict[Label, Reference]  # reference of each axis by its name


class LoadSine(Record):
    """``amplitude sin(frequency t + phase)``."""

    amplitude: Finite  # amplitude of this sine [load]
    frequency_rad_s: Positive  # angular frequency [rad/s]
    phase_rad: Finite = 0.0  # phase at the start [rad]


class AxisLoad(Record):
    """Load of an axis: a constant, any number of sines and a table, added up (LL eq. 7)."""

    constant: Finite = 0.0  # constant load [load]
    sines: tuple[LoadSine, ...] = ()  # sinusoidal loads, which are added
    #: CSV file of a load that is added, with two columns: time [s], load [load]
    file: CsvFile | None = None

    def at(self, time: Floats) -> Floats:
        """Return the load (steps,) at ``time`` (steps,) [s]."""
        total = np.full_like(time, self.constant)
        for sine in self.sines:
            total += sine.amplitude * np.sin(sine.frequency_rad_s * time + sine.phase_rad)
        if self.file is not None:
            total += np.interp(time, *table_of(self.file))
        return total


class Load(AxisLoad):
    """Load of every axis; ``axes`` lists the axes that have another load instead."""

    #: load of a single axis, by its name, with the same keys
    axes: dict[Label, AxisLoad] = Field({}, exclude_if=not_)

    def of(self, axis: str) -> AxisLoad:
        """Return the load of one axis."""
        return self.axes.get(axis, self)
