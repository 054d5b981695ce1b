"""The machine of a scenario: its drives and its sensors."""

from collections.abc import Iterable
from operator import not_
from typing import Annotated, Any, Literal, NamedTuple, Self

from pydantic import (
    Field,
    ValidationError,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    field_validator,
    model_validator,
)

from hfc_design.core import devices
from hfc_design.core.numbers import Floats, Json, Parameters
from hfc_design.core.plugins import Group
from hfc_design.core.records import Finite, Label, NotNegative, Positive, Record
from hfc_design.core.validation_errors import MOST, with_lines
from hfc_design.core.wording import one_of
from hfc_design.files.design import PerAxisRecord
from hfc_design.motion.limits import MovedAxis
from hfc_design.motion.samples import Simulation
from hfc_design.motion.shapers import impulses
from plants import PLANTS, Drive, Machine, machine_of, plant_fault, side_by_side

devices.configure()  # before anybody computes with a drive

#: Every drive and machine that a scenario can name.
ALL_PLANTS: Group[Drive | Machine] = Group(
    "plant", (Drive, Machine), "hfc_design.plants", PLANTS, fault=plant_fault
)


class Axis(NamedTuple):
    """One axis of a machine."""

    name: str
    drive: Drive
    parameters: Parameters

    @property
    def length(self) -> float | None:
        """Length of a unit of the position [mm]; None if the position is not a length."""
        return self.drive.millimetres and self.drive.millimetres(self.parameters)

    @property
    def resolution(self) -> float:
        """Step of the encoder that is fed back, as the plant has it [unit]; 0: no steps."""
        name = self.drive.resolutions.get(self.drive.seen[0])
        return float(getattr(self.parameters, name)) if name else 0.0

    @property
    def moved(self) -> MovedAxis:
        """Data of the axis that a program needs."""
        degrees, top_speed = self.drive.degrees, self.drive.top_speed(self.parameters)
        rotary = self.drive.millimetres is None and degrees is not None
        unit = (degrees(self.parameters) if degrees and rotary else self.length) or 0.0
        return MovedAxis(self.name, unit, rotary, top_speed * unit)


class PlantSettings(Record):
    """The drive or machine, and the parameters that differ from its defaults.

    If one drive moves several axes, ``axes`` names them, each with its own differences; a machine
    already has names for its axes.
    """

    name: str = "c-axis"  # drive or machine
    #: values that differ from the nominal machine, by parameter [of the parameter]
    parameters: dict[str, Finite] = {}
    #: values that differ in one axis [of the parameter]; several axes of one drive make a machine
    axes: dict[Label, dict[str, Finite]] = {}

    @field_validator("name")
    @classmethod
    def _there(cls, name: str) -> str:
        ALL_PLANTS.named("", name)  # reported together with mistakes in the parameters
        return name

    @field_validator("parameters", mode="wrap")
    @classmethod
    def _checked_names(
        cls, given: Any, handler: ValidatorFunctionWrapHandler, info: ValidationInfo
    ) -> Any:
        """Check the parameters; unknown names are reported together with wrong values."""
        plant = info.data.get("name")
        drives = machine_of(ALL_PLANTS.get(plant)).drives if plant else ()
        unknown = _unknown(drives, given) if isinstance(given, dict) else {}
        try:
            parameters: dict[str, float] = handler(given)
        except ValidationError as error:
            raise with_lines(error, unknown.values()) from None
        if unknown:
            rest = {name: x for name, x in parameters.items() if name not in unknown}
            wrong = filter(None, (drive.fault(rest) for drive in drives))
            values = dict.fromkeys(one.removeprefix("parameters.") for one in wrong)
            raise with_lines(None, [*unknown.values(), *values])
        return parameters

    @model_validator(mode="after")
    def _known(self) -> "PlantSettings":
        machine = self.machine
        check_axes("axes", self.axes, machine.axes)
        for axis, drive in zip(machine.axes, machine.drives, strict=True):
            if fault := drive.fault(self._changes(axis)):
                raise ValueError((f"axes.{axis}: " if axis in self.axes else "") + fault)
        return self

    def _changes(self, axis: str) -> dict[str, float]:
        """Return the parameters of an axis that differ from the nominal drive."""
        return self.parameters | self.axes.get(axis, {})

    @property
    def machine(self) -> Machine:
        """The machine: names of its axes, and their drives with the equations."""
        plant = ALL_PLANTS.get(self.name)
        if isinstance(plant, Drive) and self.axes:
            return side_by_side(plant.name, **dict.fromkeys(self.axes, plant))
        return machine_of(plant)

    def each(self) -> list[Axis]:
        """Return the axes of the machine, with all parameters."""
        pairs = zip(self.machine.axes, self.machine.drives, strict=True)
        return [Axis(name, drive, drive.parameters(**self._changes(name))) for name, drive in pairs]

    def values(self) -> tuple[Parameters, ...]:
        """Return the parameter record of each axis."""
        return tuple(axis.parameters for axis in self.each())

    def in_full(self) -> Json:
        """Return settings with every parameter: a file then does not depend on plants' defaults."""
        axes = {axis.name: axis.parameters._asdict() for axis in self.each()}
        if len(axes) == 1 and not self.axes:
            return {"name": self.name, "parameters": next(iter(axes.values()))}
        return {"name": self.name, "parameters": {}, "axes": axes}


def _unknown(drives: Iterable[Drive], names: Iterable[str]) -> dict[str, str]:
    """Return name -> line for each of ``names`` that is not a parameter of every drive."""
    unknown = dict[str, str]()
    for known in {drive.parameters._fields for drive in drives}:
        for name in names:
            if name not in known and name not in unknown:  # many suggestions would take minutes
                suggestion = f"; {one_of(name, known)}" if len(unknown) < MOST else ""
                unknown[name] = f"{name}: unknown{suggestion}"
    return unknown


def check_axes(key: str, named: Iterable[str], known: Iterable[str]) -> None:
    """Check that every axis that a file names is one of the machine's; ValueError: one is not."""
    for axis in named:
        if axis not in known:
            known_axes = one_of(axis, known, "the machine has")
            raise ValueError(f"{key}.{axis}: unknown axis; {known_axes}")


class ReadingSettings(Record):
    """Measurement of a signal that does not come from an encoder, in its unit."""

    resolution: NotNegative = 0.0  # step of the sensor; 0: ideal [signal]
    noise: NotNegative = 0.0  # standard deviation [signal]


class SensorSettings(PerAxisRecord):
    """Sensors of the controller, in the units of the plant; by default they are ideal."""

    encoder_resolution: NotNegative = 0.0  # step of all encoders [error]; 0: only that of the plant
    noise: NotNegative = 0.0  # standard deviation of every encoder reading [error]
    seed: int = Field(0, ge=0)  # random seed of the noise
    #: source of velocities: an ideal tachometer, the difference of two encoder readings, or a
    #: tracking observer for every encoder
    velocity: Literal["tachometer", "encoder", "observer"] = "tachometer"
    #: bandwidth of the observer; needed for velocity = 'observer' [Hz]
    observer_hz: Positive | None = None
    #: samples over which velocity = 'encoder' takes the difference of two readings
    difference_samples: int = Field(1, ge=1, le=64, exclude_if=(1).__eq__)
    #: one turn of an endless rotary axis, whose error takes the short way [error]; 0: not endless
    turn: NotNegative = Field(0.0, exclude_if=not_)
    #: sensor of a signal that is not from an encoder, by its name
    readings: dict[Label, ReadingSettings] = Field({}, exclude_if=not_)
    #: encoder whose position is fed back; left out: that of the drive
    feedback: Label | None = Field(None, exclude_if=not_)

    @model_validator(mode="after")
    def _has_bandwidth(self) -> Self:
        if self.velocity == "observer" and self.observer_hz is None:
            raise ValueError("observer_hz: is missing; velocity = 'observer' needs its bandwidth")
        if self.difference_samples > 1 and self.velocity != "encoder":
            setting = f"difference_samples = {self.difference_samples}"
            raise ValueError(f"{setting}: needs velocity = 'encoder', not {self.velocity!r}")
        return self


class ShaperSettings(PerAxisRecord):
    """Input shaper: impulses with which references are convolved, so that a mode stays calm."""

    #: shaper, from the shortest to the most tolerant
    kind: Literal["none", "zv", "mzv", "zvd", "ei", "2hump_ei", "3hump_ei"] = "none"
    hz: Positive | None = None  # frequency of the mode without damping [Hz]
    damping: Annotated[float, Field(ge=0, le=0.2)] = 0.02  # damping ratio of the mode [1]

    def impulses(self, simulation: Simulation) -> Floats:
        """Return sizes and delays [s] of the impulses; ValueError: they do not fit the motion."""
        half, got = 0.5 / simulation.sample_time_s, f"(got {self.hz or 'none'})"
        if self.kind != "none" and not (self.hz and self.hz < half):
            raise ValueError(f"shaper.hz: must be below {half:g} Hz, half the sampling rate {got}")
        shaper = impulses(self.kind, self.hz or 1.0, self.damping)
        if shaper[1, -1] >= simulation.duration_s:
            raise ValueError(f"shaper.hz: its shaper must be shorter than the motion {got}")
        return shaper


def feedback_fault(drive: Drive, encoder: str | None) -> str | None:
    """Return an error line if a drive cannot feed back an ``encoder``, else None."""
    if encoder is None or encoder in drive.encoders:
        return None
    known = ", ".join(drive.encoders)
    return f"feedback = {encoder!r}: must be an encoder of the {drive.name}; available: {known}"


def measured_apart(drive: Drive) -> list[str]:
    """Return the signals of a drive that come from no encoder."""
    return unmoved(drive, drive.encoders)


def unmoved(drive: Drive, encoders: Iterable[str]) -> list[str]:
    """Return the signals of a drive that do not depend on these ``encoders`` or their rates."""
    fixed, state = drive.coefficients(drive.parameters()), drive.initial_state(0.0)
    state = type(state)(*(0.1 + 0.01 * k for k in range(len(state))))
    moved = {
        key: 1.7 * getattr(state, key) for one in encoders for key in (one, drive.encoders[one])
    }
    before, after = drive.signals(fixed, state), drive.signals(fixed, state._replace(**moved))
    return [name for name, value in before.items() if value == after[name]]


def reading_fault(drive: Drive, names: Iterable[str]) -> str | None:
    """Return an error line if one of ``names`` is not a signal with its own sensor, else None."""
    signals = measured_apart(drive)
    for name in names:
        if name in signals:
            continue
        has = f"; available: {', '.join(signals)}" if signals else ""
        if name in drive.inputs:
            return (
                f"{name}: is derived from encoders; set encoder_resolution and noise instead{has}"
            )
        return f"{name}: must be a measured signal{has}"
    return None
