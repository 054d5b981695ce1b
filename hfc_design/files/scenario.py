"""A scenario: the plant, what it follows, what disturbs it, what counts as good, how to search.

The records here are what a user writes as TOML; they are checked once, when they are read.
"""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import tomli_w
from pydantic import Field, SerializeAsAny, model_validator

from hfc_design.controllers.kind import ControllerSettings, Target
from hfc_design.controllers.kinds import KINDS
from hfc_design.core.dotted import Changes, changed
from hfc_design.core.plugins import chosen
from hfc_design.core.records import Name, Record, UserError, checked
from hfc_design.core.shapes import Parameters
from hfc_design.files.design import Design, named_design
from hfc_design.files.limits import Limits
from hfc_design.files.machine import PlantSettings, SensorSettings, check_axes
from hfc_design.motion.references import EachAxis, Load, Ramp, Reference
from hfc_design.motion.samples import Samples, Simulation
from hfc_design.motion.trajectories import PathReference, Trajectory, speed_fault
from hfc_design.objectives.judge import FitnessSettings, Judge, judge, objective_of
from hfc_design.objectives.metrics import Window, settled_samples
from hfc_design.search.loop import STRATEGIES, SearchSettings
from plants import Drive

MAX_STEPS = 10_000_000
#: The scenarios that come with the package, and the files that they name.
BUILTIN = Path(__file__).parent / "scenarios"
#: Of a controller that does not say its kind.
DEFAULT_KIND = "pd+hierarchical-fuzzy"


class RunSettings(Record):
    """How to compute; the same seed on the same machine gives the same bits."""

    seed: int = Field(0, ge=0)
    precision: Literal["float32", "float64"] = "float32"


class Scenario(Record):
    """Everything that a design run needs, with the defaults of LL section 4."""

    name: Name
    description: str = ""
    plant: PlantSettings = PlantSettings()
    simulation: Simulation = Simulation()
    reference: Annotated[Reference | PathReference | EachAxis, Field(discriminator="kind")] = Ramp()
    load: Load = Load()
    limits: Limits = Limits()
    sensors: SensorSettings = SensorSettings()
    fitness: FitnessSettings = Field({}, validate_default=True)
    controller: Annotated[
        SerializeAsAny[ControllerSettings], chosen(KINDS, "settings", default=DEFAULT_KIND)
    ] = Field(default={}, validate_default=True)
    search: SearchSettings = Field({}, validate_default=True)
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
        self._can_be_judged()
        if fault := self.controller.fault(self.target):
            raise ValueError(fault)
        preset = self.search.preset
        if fault := STRATEGIES.get(preset).fault(self.search, self.controller):
            raise ValueError(f"search.preset = {preset!r}: {fault}")
        return self

    @property
    def target(self) -> Target:
        """What a controller is designed for."""
        machine = self.plant.machine
        limits = {axis: self.limits.of(axis).command for axis in machine.axes}
        every = self.simulation.sample_time_s
        return Target(machine, self.plant.values(), every, limits, self.search)

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

    def _can_follow(self) -> None:
        """Whether the machine has the axes that other parts speak of, and can follow."""
        axes = self.plant.machine.axes
        check_axes("limits.axes", self.limits.axes, axes)
        check_axes("sensors.axes", self.sensors.axes, axes)
        check_axes("load.axes", self.load.axes, axes)
        reference = self.reference
        if isinstance(reference, Trajectory):
            self._can_follow_path(reference)
            return
        if isinstance(reference, EachAxis):
            check_axes("reference.axes", reference.axes, axes)
            if missing := [axis for axis in axes if axis not in reference.axes]:
                raise ValueError(f"reference.axes.{missing[0]}: is missing")
        elif len(axes) > 1:
            raise ValueError(
                f"reference.kind = {reference.kind!r}: a machine of {len(axes)} axes follows "
                f"{'a path in X-Y, or ' if len(axes) == 2 else ''}kind 'per-axis'"
            )
        for drive, own, parameters in self._axes():
            self._is_slow_enough(drive, self.reference_of(own), parameters)

    def _can_be_judged(self) -> None:
        axes = len(self.plant.machine.axes)
        if fault := objective_of(self.fitness).fault(axes, self.follows_path):
            raise ValueError(f"fitness.kind = {self.fitness.kind!r}: {fault}")

    def _can_follow_path(self, path: Trajectory) -> None:
        key, axes = f"reference.kind = {path.kind!r}", self._axes()
        if len(axes) != 2:
            raise ValueError(f"{key}: a machine of {len(axes)} axes follows {ONE_AXIS}")
        x, y = self.lengths
        for (drive, _, _), length in zip(axes, (x, y), strict=True):
            if length is None:
                raise ValueError(f"{key}: is for feed drives, not for the {drive.name}")
        assert x is not None
        if x != y:
            raise ValueError(
                f"{key}: the axes of a path have to count in the same length, not in "
                f"{x:g} and {y:g} mm"
            )
        if fault := speed_fault(path, [drive.top_speed(own) * x for drive, _, own in axes]):
            raise ValueError(f"reference: {fault}")

    def _is_slow_enough(self, drive: Drive, reference: Reference, parameters: Parameters) -> None:
        """Whether the steps of the integration are short enough for the fastest reference."""
        speed = float(np.abs(reference.samples(self.simulation.time).reference_rate).max())
        substeps = self.simulation.substeps
        limit = drive.fastest(parameters, self.simulation.sample_time_s / substeps)
        if speed > limit:
            needed = int(np.ceil(substeps * speed / limit))
            raise ValueError(
                f"simulation.substeps = {substeps}: a reference of up to "
                f"{speed:.3g} {drive.units['error_rate']} needs at least {needed} with this "
                "friction and sample time"
            )

    def _axes(self) -> list[tuple[Drive, str, Parameters]]:
        """Drive, name and parameters of each axis."""
        machine = self.plant.machine
        return list(zip(machine.drives, machine.axes, self.plant.values(), strict=True))

    @property
    def follows_path(self) -> bool:
        """Whether it is an X-Y machine on a path."""
        return isinstance(self.reference, Trajectory)

    @property
    def lengths(self) -> list[float | None]:
        """Length of a unit of the position of each axis [mm]; None where it is none."""
        return [
            None if drive.millimetres is None else drive.millimetres(own)
            for drive, _, own in self._axes()
        ]

    def reference_of(self, axis: str) -> Reference:
        """The reference of one axis of a machine that follows no path."""
        assert not isinstance(self.reference, Trajectory)
        return self.reference.axes[axis] if isinstance(self.reference, EachAxis) else self.reference

    def judge(self) -> Judge:
        """How its closed loops are judged, by a search and by everybody else."""
        return judge(objective_of(self.fitness), getattr(self.search, "stick_penalty", 0.0))

    def samples(self) -> Samples:
        """What happens to the loop, sampled, in float64."""
        time, path = self.simulation.time, self.reference
        settled = settled_samples(time, self.fitness.settled_after_s).astype(float)
        generator = np.random.default_rng(self.sensors.seed)
        frame = None
        if isinstance(path, Trajectory):
            told, frame = path.axis_samples(time, self.lengths[0])
        else:
            told = [self.reference_of(axis).samples(time) for _, axis, _ in self._axes()]
        axes = []
        for motion, (drive, axis, _) in zip(told, self._axes(), strict=True):
            noise = generator.standard_normal((len(drive.encoders), len(time)))
            load = self.load.of(axis)
            loads = np.stack([load.at(moment) for moment in self.simulation.moments])
            own = {"loads": loads, "noise": self.sensors.of(axis).noise * noise}
            axes.append(motion._replace(reference=drive.commanded(motion.target), **own))
        return Samples(tuple(axes), frame, settled, self.simulation.sample_time_s)


#: What a machine that has not two axes follows.
ONE_AXIS = "a reference for one axis, or kind 'per-axis'"


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
    return scenario_of(changed({"name": Path(source).stem} | data, changes), source, folder)


def scenario_of(data: Any, source: str | Path, folder: Path) -> Scenario:
    """The scenario in ``data``, which a file in ``folder`` says.

    Raises:
        UserError: its text or a value is not allowed.
    """

    def beside(name: str) -> Design:
        path = folder / name
        return named_design(str(path) if path.exists() else name)

    return checked(Scenario, data, source, folder, named_design=beside)


def renamed(scenario: Scenario, name: Callable[[str, Path], Path]) -> Scenario:
    """The scenario with other paths, ``name(key, file)``, to the files that it names."""
    changes = {}
    for key in ("reference", "load"):
        record = getattr(scenario, key)
        if (file := getattr(record, "file", None)) is not None:
            changes[key] = record.model_copy(update={"file": name(key, file)})
    return scenario.model_copy(update=changes)


def scenario_toml(scenario: Scenario) -> str:
    """The scenario in full as TOML, every default spelled out."""
    return tomli_w.dumps(scenario.model_dump(mode="json", exclude_none=True))
