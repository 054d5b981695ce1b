"""A scenario: the plant, what it follows, what disturbs it, what counts as good, how to search.

The records here are what a user writes as TOML; they are checked once, when they are read.
"""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import tomli_w
from pydantic import BeforeValidator, Field, model_validator

from hfc_design.controllers.hierarchical.law import PREVIOUS
from hfc_design.core.dotted import Changes, changed
from hfc_design.core.records import TERMS, Name, Record, UserError, checked
from hfc_design.files.controller import (
    AflcSettings,
    ControllerSettings,
    FlcSettings,
    HierarchicalSettings,
    LawSettings,
)
from hfc_design.files.machine import Limits, PlantSettings, SensorSettings
from hfc_design.motion.signals import (
    AxisSamples,
    Load,
    PathFrame,
    Ramp,
    Reference,
    Samples,
    Simulation,
)
from hfc_design.motion.trajectories import (
    PathReference,
    Trajectory,
    check_speed,
    largest_drive_speed,
)
from hfc_design.objectives.judge import Judge, judge
from hfc_design.objectives.metrics import Window, settled_samples
from hfc_design.objectives.registry import FitnessSettings, objective_of
from hfc_design.search.settings import LinLeeSettings as SearchLinLee
from hfc_design.search.settings import RaceSettings, SearchSettings
from plants import Plant
from plants.feed_drive import FeedDriveParameters

MAX_STEPS = 10_000_000
#: The scenarios that come with the package, and the files that they name.
BUILTIN = Path(__file__).parent / "scenarios"


class RunSettings(Record):
    """How to compute; the same seed on the same machine gives the same bits."""

    seed: int = Field(0, ge=0)
    precision: Literal["float32", "float64"] = "float32"


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
    fitness: FitnessSettings = Field({}, validate_default=True)
    controller: Annotated[ControllerSettings, BeforeValidator(_with_controller)] = (
        HierarchicalSettings()
    )
    search: Annotated[SearchSettings, BeforeValidator(_with_preset)] = RaceSettings()
    run: RunSettings = RunSettings()
    windows: tuple[Window, ...] = ()

    @model_validator(mode="after")
    def _consistent(self) -> "Scenario":
        if not 1 <= self.simulation.steps <= MAX_STEPS:
            raise ValueError(
                f"simulation: {self.simulation.duration_s} s in samples of "
                f"{self.simulation.sample_time_s} s are {self.simulation.steps} samples; "
                f"allowed are 1 to {MAX_STEPS}"
            )
        self._has_windows()
        self._can_follow()
        if isinstance(self.controller, HierarchicalSettings):
            self._can_read(self.controller)
        elif isinstance(self.search, SearchLinLee):
            raise ValueError("search.preset = 'lin-lee-1999': searches hierarchies; use race")
        elif not isinstance(self.controller, LawSettings):
            self._can_start(self.controller)
        return self

    def _has_windows(self) -> None:
        names = [window.name for window in self.windows]
        for k, window in enumerate(self.windows):
            if names.count(window.name) > 1:
                raise ValueError(f"windows.{k}.name = {window.name!r}: stands there twice")
            if len(self.simulation.time[window.part(self.simulation)]) < 2:
                raise ValueError(
                    f"windows.{k}: from_s = {window.from_s}, to_s = {window.to_s} hold fewer than "
                    f"two samples of a simulation of {self.simulation.duration_s} s"
                )

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

    def _can_start(self, controller: FlcSettings | AflcSettings) -> None:
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

    def _can_follow(self) -> None:
        axes = self.plant.values()
        if isinstance(self.reference, Trajectory) != (len(axes) == 2):
            raise ValueError(
                f"reference.kind = {self.reference.kind!r}: a machine of {len(axes)} axes follows "
                f"{'a path in X-Y' if len(axes) == 2 else 'a reference for one axis'}"
            )
        if fault := objective_of(self.fitness).fault(len(axes)):
            raise ValueError(f"fitness.kind = {self.fitness.kind!r}: {fault}")
        if isinstance(self.reference, Trajectory):
            if not isinstance(axes[0], FeedDriveParameters):
                raise ValueError(
                    f"reference.kind = {self.reference.kind!r}: is for feed drives, not for the "
                    f"{self.plant.name}"
                )
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

    def judge(self) -> Judge:
        """How its closed loops are judged, by a search and by everybody else."""
        return judge(objective_of(self.fitness), getattr(self.search, "stick_penalty", 0.0))

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
            place, rate = self.reference.at(time), self.reference.rate(time)
            told = self.plant.plant.commanded(place)
            found = (AxisSamples(told, rate, loads, noise[0], place),)
            return Samples(found, None, settled, self.simulation.sample_time_s)
        way, blu = self.reference.samples(time), axes[0].blu
        target = (way.position - way.position[:, :1]) / blu  # the machine starts where it stands
        both = tuple(
            AxisSamples(told, velocity / blu, loads, noise_of_axis, place)
            for told, place, velocity, noise_of_axis in zip(
                self.plant.plant.commanded(target), target, way.velocity, noise, strict=True
            )
        )
        frame = PathFrame(way.tangent[0], way.tangent[1], way.curvature * blu)
        return Samples(both, frame, settled, self.simulation.sample_time_s)


def input_names(plant: Plant) -> list[str]:
    """Every signal of ``plant`` that can be an input of the hierarchy."""
    names = [name for name in plant.units if name not in ("command", "load")]
    return names + [f"{PREVIOUS}{name}" for name in names]


def builtin_names() -> list[str]:
    """Names of the scenarios that come with the package."""
    found = (entry.name for entry in BUILTIN.iterdir())
    return sorted(name.removesuffix(".toml") for name in found if name.endswith(".toml"))


def load_scenario(name: str, changes: Changes = ()) -> Scenario:
    """The scenario with a built-in name or at a path, with some keys changed.

    Raises:
        UserError: no such scenario, or its text, a value or a change is not allowed.
    """
    if name in builtin_names():
        source, folder = name, Path()
        text = (BUILTIN / f"{name}.toml").read_text()
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
    own = data.get("reference", {})
    if name in builtin_names() and "file" in own:  # a file in a change lies where the user is
        own["file"] = str(BUILTIN / own["file"])
    data = changed({"name": Path(source).stem} | data, changes)
    return checked(Scenario, data, source, folder)


def renamed(scenario: Scenario, name: Callable[[str, Path], Path]) -> Scenario:
    """The scenario with other paths, ``name(key, file)``, to the files that it names."""
    changes: dict[str, Any] = {}
    for key in ("reference", "load"):
        record = getattr(scenario, key)
        file = getattr(record, "file", None)
        if file is not None:
            changes[key] = record.model_copy(update={"file": name(key, file)})
    return scenario.model_copy(update=changes)


def scenario_toml(scenario: Scenario) -> str:
    """The scenario in full as TOML, every default spelled out."""
    return tomli_w.dumps(scenario.model_dump(mode="json", exclude_none=True))
