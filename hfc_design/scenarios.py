"""A scenario: the plant, what it follows, what disturbs it, what counts as good, how to search.

The records here are what a user writes as TOML; they are checked once, when they are read.
"""

import copy
import tomllib
from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import tomli_w
from pydantic import BeforeValidator, Field, ValidationInfo, model_validator

from hfc_design.controllers import Layout
from hfc_design.controllers.hierarchical import PREVIOUS
from hfc_design.feed_records import AflcDesign, FlcDesign
from hfc_design.fitness import Fitness, contour, lin_lee, settled_samples
from hfc_design.fuzzy import LIN_LEE_TERMS, Term
from hfc_design.hierarchy import MAX_INPUTS
from hfc_design.paths.trajectories import (
    PathReference,
    Trajectory,
    check_speed,
    largest_drive_speed,
)
from hfc_design.records import (
    TERMS,
    Finite,
    Name,
    NotNegative,
    Positive,
    Record,
    UserError,
    checked,
)
from hfc_design.rulebase import (
    AdaptationRecord,
    InputRecord,
    Label,
    TermRecord,
    check_adaptation,
    named_design,
)
from hfc_design.search.settings import LinLeeSettings as SearchLinLee
from hfc_design.search.settings import RaceSettings, SearchSettings
from hfc_design.signals import AxisSamples, Load, PathFrame, Ramp, Reference, Samples, Simulation
from plants import PLANTS, Plant
from plants.feed_drive import FeedDriveParameters

MAX_STEPS = 10_000_000


class PlantSettings(Record):
    """Which plant, and the parameters that differ from its nominal machine.

    A machine of several axes names them in ``axes``, each with what differs once more.
    """

    name: str = "c-axis"
    parameters: dict[str, Finite] = {}
    axes: dict[Label, dict[str, Finite]] = {}

    @model_validator(mode="after")
    def _known(self) -> "PlantSettings":
        if self.name not in PLANTS:
            raise ValueError(f"name {self.name!r} is no plant; there is {', '.join(PLANTS)}")
        for place, changes in self._changes().items():
            fault = self.plant.fault(changes)
            if fault:
                raise ValueError(place + fault)
        return self

    def _changes(self) -> dict[str, dict[str, float]]:
        """What differs from the nominal machine in each axis, with its place in a message."""
        own = {f"axes.{name}: ": changes for name, changes in self.axes.items()}
        return {place: self.parameters | changes for place, changes in (own or {"": {}}).items()}

    @property
    def plant(self) -> Plant:
        """The plant's functions."""
        return PLANTS[self.name]

    def values(self) -> tuple[Any, ...]:
        """The parameter record of each axis."""
        return tuple(self.plant.parameters(**changes) for changes in self._changes().values())


class Limits(Record):
    """Limits of the drive, in the units of the plant."""

    command: Positive | None = None


class SensorSettings(Record):
    """What the controller sees of the machine, in the units of the plant; ideal without any."""

    encoder_resolution: NotNegative = 0.0
    noise: NotNegative = 0.0  # standard deviation of every encoder reading
    seed: int = Field(0, ge=0)
    velocity: Literal["tachometer", "encoder"] = "tachometer"


class LinLeeSettings(Record):
    """Weights a and b of LL eq. 5, and from when on the metrics look at the settled motion."""

    kind: Literal["lin-lee"] = "lin-lee"
    error: NotNegative = 3.0
    error_rate: NotNegative = 0.1
    settled_after_s: NotNegative = 1.0

    @model_validator(mode="after")
    def _weighs_something(self) -> "LinLeeSettings":
        if not self.error and not self.error_rate:
            raise ValueError("one of the two weights has to be positive")
        return self

    def fitness(self) -> Fitness:
        """The same as functions."""
        return lin_lee(self.error, self.error_rate)


class ContourSettings(Record):
    """Contour error of an X-Y machine; see ``fitness.contour``."""

    kind: Literal["contour"] = "contour"
    worst: NotNegative = 0.3
    settled_after_s: NotNegative = 1.0

    def fitness(self) -> Fitness:
        """The same as functions."""
        return contour(self.worst)


FitnessSettings = Annotated[LinLeeSettings | ContourSettings, Field(discriminator="kind")]


class RunSettings(Record):
    """How to compute; the same seed on the same machine gives the same bits."""

    seed: int = Field(0, ge=0)
    precision: Literal["float32", "float64"] = "float32"


def _default_inputs() -> tuple[InputRecord, ...]:
    layout = Layout()
    pairs = zip(layout.inputs, layout.scales, strict=True)
    return tuple(InputRecord(name=name, scale=scale) for name, scale in pairs)


class HierarchicalSettings(Record):
    """Inputs, scales and terms of the hierarchical fuzzy controller."""

    kind: Literal["pd+hierarchical-fuzzy"] = "pd+hierarchical-fuzzy"
    inputs: tuple[InputRecord, ...] = Field(
        default_factory=_default_inputs, min_length=2, max_length=MAX_INPUTS
    )
    output_scale: Positive = 10.0
    terms: tuple[TermRecord, ...] = Field(
        tuple(TermRecord(**term._asdict()) for term in LIN_LEE_TERMS),
        min_length=TERMS,
        max_length=TERMS,
    )
    adaptation: AdaptationRecord | None = None  # of the root; None: its table stays

    @model_validator(mode="after")
    def _can_adapt(self) -> "HierarchicalSettings":
        check_adaptation(self.adaptation, self.inputs)
        return self

    def layout(self) -> Layout:
        """The same for the closed loop."""
        return Layout(
            tuple(item.name for item in self.inputs),
            tuple(item.scale for item in self.inputs),
            self.output_scale,
            tuple(Term(**term.model_dump()) for term in self.terms),
            self.adaptation.law() if self.adaptation else None,
        )


def _controller_of(start: Any, info: ValidationInfo) -> Any:
    """The controller of the design that ``start`` names; a record stays one."""
    if not isinstance(start, str):
        return start
    path = Path((info.context or {}).get("folder", "")) / start
    try:
        design = named_design(str(path) if path.exists() else start)
    except UserError as error:
        raise ValueError(str(error)) from None
    return design.controller.model_dump()


Start = BeforeValidator(_controller_of)


class _FuzzySettings(Record):
    """Bounds of a search that begins with a fuzzy controller, or with a design's."""

    symmetric: bool = True  # both directions are treated alike
    largest_integral_gain: NotNegative = 8.0  # [units/(BLU s)]


class FlcSettings(_FuzzySettings):
    """A fuzzy controller of a feed drive."""

    kind: Literal["flc"]
    start: Annotated[FlcDesign, Start] = Field("jee-koren-2004-flc", validate_default=True)


class AflcSettings(_FuzzySettings):
    """A fuzzy controller of a feed drive that adapts."""

    kind: Literal["aflc"]
    start: Annotated[AflcDesign, Start] = Field("jee-koren-2004-aflc", validate_default=True)


ControllerSettings = Annotated[
    HierarchicalSettings | FlcSettings | AflcSettings, Field(discriminator="kind")
]


def _with_kind(fitness: Any) -> Any:
    return {"kind": "lin-lee"} | fitness if isinstance(fitness, dict) else fitness


def _with_controller(controller: Any) -> Any:
    if isinstance(controller, dict):
        return {"kind": "pd+hierarchical-fuzzy"} | controller
    return controller


def _with_preset(search: Any) -> Any:
    return {"preset": "race"} | search if isinstance(search, dict) else search


class Scenario(Record):
    """Everything that a design run needs, with the defaults of LL section 4."""

    name: Name
    description: str = ""
    plant: PlantSettings = PlantSettings()
    simulation: Simulation = Simulation()
    reference: Annotated[Reference | PathReference, Field(discriminator="kind")] = Ramp()
    load: Load = Load()
    limits: Limits = Limits()
    sensors: SensorSettings = SensorSettings()
    fitness: Annotated[FitnessSettings, BeforeValidator(_with_kind)] = LinLeeSettings()
    controller: Annotated[ControllerSettings, BeforeValidator(_with_controller)] = (
        HierarchicalSettings()
    )
    search: Annotated[SearchSettings, BeforeValidator(_with_preset)] = RaceSettings()
    run: RunSettings = RunSettings()

    @model_validator(mode="after")
    def _consistent(self) -> "Scenario":
        if not 1 <= self.simulation.steps <= MAX_STEPS:
            raise ValueError(
                f"simulation: {self.simulation.duration_s} s in samples of "
                f"{self.simulation.sample_time_s} s are {self.simulation.steps} samples; "
                f"allowed are 1 to {MAX_STEPS}"
            )
        self._can_follow()
        if isinstance(self.controller, HierarchicalSettings):
            self._can_read(self.controller)
        else:
            self._can_search(self.controller)
        return self

    def _can_read(self, controller: HierarchicalSettings) -> None:
        known = input_names(self.plant.plant)
        names = [item.name for item in controller.inputs]
        for name in names:
            if name not in known:
                raise ValueError(
                    f"controller.inputs: {name!r} is no signal of the {self.plant.name}; "
                    f"there is {', '.join(known)}"
                )
            if names.count(name) > 1:
                raise ValueError(f"controller.inputs: {name!r} stands there twice")

    def _can_search(self, controller: FlcSettings | AflcSettings) -> None:
        if not isinstance(self.plant.values()[0], FeedDriveParameters):
            raise ValueError(
                f"controller.kind = {controller.kind!r}: is for a feed drive, not for the "
                f"{self.plant.name}"
            )
        if controller.start.sample_time_s != self.simulation.sample_time_s:
            raise ValueError(
                f"controller.start: runs every {controller.start.sample_time_s} s, "
                f"simulation.sample_time_s is {self.simulation.sample_time_s}"
            )
        for key in ("error_terms", "error_change_terms"):
            middle = getattr(controller.start, key)[TERMS // 2]
            if middle.centre != 0.0:
                raise ValueError(
                    f"controller.start: {middle.label} of its {key} is centred on "
                    f"{middle.centre}; a search keeps it on 0"
                )
        if isinstance(self.search, SearchLinLee):
            raise ValueError("search.preset = 'lin-lee-1999': searches hierarchies; use race")

    def _can_follow(self) -> None:
        axes = self.plant.values()
        if isinstance(self.reference, Trajectory) != (len(axes) == 2):
            raise ValueError(
                f"reference.kind = {self.reference.kind!r}: a machine of {len(axes)} axes follows "
                f"{'a path in X-Y' if len(axes) == 2 else 'a reference for one axis'}"
            )
        if isinstance(self.fitness, ContourSettings) and len(axes) != 2:
            raise ValueError("fitness.kind = 'contour': a machine of one axis has no contour")
        if isinstance(self.reference, Trajectory):
            fastest = min(largest_drive_speed(axis.gain, axis.coulomb) for axis in axes)
            try:
                check_speed(self.reference, fastest, "reference")
            except UserError as error:
                raise ValueError(str(error)) from None
            return
        speed = float(np.abs(self.reference.rate(self.simulation.time)).max())
        step = self.simulation.sample_time_s / self.simulation.substeps
        limit = min(self.plant.plant.fastest(axis, step) for axis in axes)
        if speed > limit:
            unit = self.plant.plant.units["error_rate"]
            needed = int(np.ceil(self.simulation.substeps * speed / limit))
            raise ValueError(
                f"simulation.substeps = {self.simulation.substeps}: a reference of up to "
                f"{speed:.3g} {unit} needs at least {needed} with this friction and sample time"
            )

    def samples(self) -> Samples:
        """What happens to the loop, sampled, in float64."""
        time = self.simulation.time
        points = np.arange(2 * self.simulation.substeps + 1) / (2 * self.simulation.substeps)
        axes = self.plant.values()
        generator = np.random.default_rng(self.sensors.seed)
        shape = (len(axes), len(self.plant.plant.encoders), len(time))
        noise = self.sensors.noise * generator.standard_normal(shape)
        loads = np.stack([self.load.at(time + p * self.simulation.sample_time_s) for p in points])
        settled = settled_samples(time, self.fitness.settled_after_s).astype(float)
        if not isinstance(self.reference, Trajectory):
            angle, rate = self.reference.at(time), self.reference.rate(time)
            found = (AxisSamples(angle, rate, loads, noise[0], angle),)
            return Samples(found, None, settled, self.simulation.sample_time_s)
        way, blu = self.reference.samples(time), axes[0].blu
        target = (way.position - way.position[:, :1]) / blu  # the machine starts where it stands
        both = tuple(
            AxisSamples(np.round(place), velocity / blu, loads, noise_of_axis, place)
            for place, velocity, noise_of_axis in zip(target, way.velocity, noise, strict=True)
        )
        frame = PathFrame(way.tangent[0], way.tangent[1], way.curvature * blu)
        return Samples(both, frame, settled, self.simulation.sample_time_s)


def input_names(plant: Plant) -> list[str]:
    """Every signal of ``plant`` that can be an input of the hierarchy."""
    names = [name for name in plant.units if name not in ("command", "load")]
    return names + [f"{PREVIOUS}{name}" for name in names]


def builtin_names() -> list[str]:
    """Names of the scenarios that come with the package."""
    found = (files("hfc_design") / "builtin_scenarios").iterdir()
    return sorted(entry.name.removesuffix(".toml") for entry in found if entry.name[0] != "_")


def load_scenario(name: str, changes: Iterable[str] = ()) -> Scenario:
    """The scenario with a built-in name or at a path, with ``changes`` like "key.sub=value".

    Raises:
        UserError: no such scenario, or its text, a value or a change is not allowed.
    """
    if name in builtin_names():
        source, text = (
            name,
            (files("hfc_design") / "builtin_scenarios" / f"{name}.toml").read_text(),
        )
        folder = Path()
    elif Path(name).is_file():
        source, folder = name, Path(name).parent
        try:
            text = Path(name).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise UserError(f"{name}: cannot be read: {error}") from None
    else:
        known = ", ".join(builtin_names())
        raise UserError(f"{name}: no such scenario; built in are {known}, or give a TOML file")
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"{source}: is not valid TOML: {error}") from None
    data = changed({"name": Path(source).stem} | data, changes)
    return checked(Scenario, data, source, folder)


def changed(data: dict[str, Any], changes: Iterable[str]) -> dict[str, Any]:
    """``data`` with values set by "dotted.key=value"; a value is TOML, or else a bare string.

    Raises:
        UserError: a change is not of that form, or its key runs through something else.
    """
    data = copy.deepcopy(data)
    for change in changes:
        key, equals, text = change.partition("=")
        if not equals or not key.strip():
            raise UserError(f"--set {change}: has to look like simulation.duration_s=5")
        try:
            value = tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError:
            value = text.strip()
        *path, last = key.strip().split(".")
        place = data
        for part in path:
            place = place.setdefault(part, {})
            if not isinstance(place, dict):
                raise UserError(f"--set {change}: {part} is not a table")
        place[last] = value
    return data


def scenario_toml(scenario: Scenario) -> str:
    """The scenario in full as TOML, every default spelled out."""
    return tomli_w.dumps(scenario.model_dump(mode="json", exclude_none=True))
