"""A scenario: plant, reference, disturbances, criteria of a good design, and search.

The records here are tables of a user's TOML file, which are checked once, when they are read.
"""

from operator import not_
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, SerializeAsAny, model_validator

from hfc_design.controllers.kind import ControllerSettings, Target
from hfc_design.controllers.kinds import KINDS
from hfc_design.core.numbers import SAME
from hfc_design.core.plugins import chosen
from hfc_design.core.records import Asked, Name, Record, UserError, option
from hfc_design.core.tables import line, table
from hfc_design.files.design import Limits
from hfc_design.files.feasibility import check_feasible, motion_of, reference_of
from hfc_design.files.machine import (
    PlantSettings,
    SensorSettings,
    ShaperSettings,
    check_axes,
    feedback_fault,
    reading_fault,
)
from hfc_design.files.motions import AnyReference, Motion, Start, copy_started, started, way
from hfc_design.files.robust import AROUND, RobustSettings, unknown_parameter
from hfc_design.files.stress import ALSO, StressSettings
from hfc_design.motion.phases import Window, late_samples, settled_samples, slides
from hfc_design.motion.program import Program
from hfc_design.motion.references import Load, Ramp
from hfc_design.motion.reversals import turned_back
from hfc_design.motion.samples import Samples, Simulation
from hfc_design.motion.shapers import shaped
from hfc_design.motion.trajectories import Trajectory
from hfc_design.objectives.constraints import Constraints, constraints_on
from hfc_design.objectives.judge import FitnessSettings, Judge, judge, objective_of
from hfc_design.objectives.metric import Units, in_units, path_fault
from hfc_design.objectives.traded import UNITS, Traded, traded
from hfc_design.objectives.verdict import Ensemble
from hfc_design.search.loop import STRATEGIES, SearchSettings
from hfc_design.stability.margins import ASKED
from plants import Machine
from plants.around import Around

MAX_STEPS = 10_000_000
#: Kind of controller of a scenario that does not name one.
DEFAULT_KIND = "pd+hierarchical-fuzzy"


class RunSettings(Record):
    """Settings of the computation; the same seed on the same machine gives the same bits."""

    #: random seed of the search; the same seed on the same computer gives identical results
    seed: int = Field(0, ge=0)
    #: precision of the search; on one machine the final choice is made in float64
    precision: Literal["float32", "float64"] = "float32"
    #: largest number of searches until the answer is yes; 1: a single search
    extend: int = Field(3, ge=1, le=100, exclude_if=(3).__eq__)
    #: steps of the final local optimisation; 0: none
    polish: int = Field(0, ge=0, le=100_000, exclude_if=not_)


class Scenario(Record, metaclass=Asked):
    """Everything that a design run needs, with the defaults of LL section 4."""

    name: Name  # name of the scenario; left out: that of its file
    description: str = ""  # a description in one line
    plant: PlantSettings = PlantSettings()  # the machine
    simulation: Simulation = Simulation()  # duration and step sizes
    reference: AnyReference = Ramp()  # motion that the machine must follow
    #: input shaper of the references; left out: none
    shaper: ShaperSettings = Field(ShaperSettings(), exclude_if=ShaperSettings().__eq__)
    load: Load = Load()  # load against the motion
    #: initial state by state names, with several axes a table for each [of the state]; left out: at
    #: rest at 0
    start: Start = Field({}, exclude_if=not_)
    #: several motions that are judged together; keys left out are those of the scenario
    motions: tuple[Motion, ...] = Field((), exclude_if=not_)
    limits: Limits = Limits()  # limits and delays of the drives
    #: sensors of the machine; left out: ideal
    sensors: SensorSettings = SensorSettings()
    fitness: FitnessSettings = Field({}, validate_default=True)  # measure of a good motion
    #: controller to search for
    controller: Annotated[
        SerializeAsAny[ControllerSettings], chosen(KINDS, "settings", default=DEFAULT_KIND)
    ] = Field(default={}, validate_default=True)
    search: SearchSettings = Field({}, validate_default=True)  # search strategy
    run: RunSettings = RunSettings()  # computation
    windows: tuple[Window, ...] = ()  # parts of the motion with additional metrics
    #: metrics by name, each with its largest allowed value: a number, or a string with a unit [of
    #: the metric]; band: the width for band_time; for the linearised loop the largest
    #: sensitivity, closed_loop_peak (Mt) and compliance, and the smallest gain_margin,
    #: phase_margin_deg, delay_margin_samples and bandwidth_hz
    constraints: Constraints = Field({}, exclude_if=not_)
    #: perturbed machines on which every candidate is tested; left out: only the nominal machine
    robust: RobustSettings | None = Field(None, exclude_if=not_)
    #: stress tests beyond these machines; left out: the defaults, which apply only with robust
    stress: StressSettings = Field(StressSettings(), exclude_if=StressSettings().__eq__)

    def __repr__(self) -> str:
        return line("Scenario", self._summary())

    __str__ = __repr__

    def _repr_html_(self) -> str:
        return table("Scenario", {"description": self.description} | self._summary())

    def _summary(self) -> dict[str, object]:
        fields = {"name": self.name, "plant": self.plant.name, "controller": self.controller.kind}
        simulation = self.simulation
        more = {"motions": ", ".join(one.name for one in self.motions)} if self.motions else {}
        return {
            **fields,
            "duration_s": simulation.duration_s,
            "sample_time_s": simulation.sample_time_s,
            **more,
        }

    @model_validator(mode="after")
    def _tolerances_of_parameters(self) -> "Scenario":
        if fault := unknown_parameter(self.plant, self.robust.tolerances if self.robust else ()):
            raise ValueError(f"robust.tolerances.{fault}")
        also = self.robust.tolerances if self.robust else {}
        if self.stress.load is not None:
            in_units("stress.load", self.stress.load, "load", self.units)
        for name in ALSO:
            size = getattr(self.stress, name)
            if name in self.stress.model_fields_set and name in also:
                raise ValueError(
                    f"stress.{name} = {size}: robust.tolerances.{name} = {also[name]:g} "
                    "is set too; leave one of them out"
                )
        return self

    @model_validator(mode="after")
    def _consistent(self) -> "Scenario":
        names = [motion.name for motion in self.motions]
        if self.motions and all(self.nominal_only):
            raise ValueError("motions: at least one must have machines = 'all'")
        for k, motion in enumerate(self.each_motion()):
            if names[k : k + 1] and names[k] in names[:k]:
                raise ValueError(f"motions.{k}.name = {names[k]!r}: is listed twice")
            try:
                if self.motions:
                    self.motions[k].ends_settled(motion.simulation.duration_s)
                motion._can_be_simulated()
            except ValueError as error:
                raise ValueError(f"motions.{k}: {error}" if self.motions else str(error)) from None
        objective, preset = objective_of(self.fitness.on(self.units)), self.search.preset
        if self.ensemble and not objective.positive:
            raise ValueError(
                f"fitness.kind = {self.fitness.kind!r}: may be negative, which motions, "
                "constraints and robust cannot rank; declare your own objective with "
                "positive=True if it never is"
            )
        for motion in self.each_motion():
            if fault := objective.fault(len(self.plant.machine.axes), motion.follows_path):
                raise ValueError(f"fitness.kind = {self.fitness.kind!r}: {fault}")
            bounds = [bound.metric for bound in constraints_on(self.constraints, self.units)]
            if fault := path_fault(bounds, motion.follows_path):
                raise ValueError(f"constraints.{fault}")
        if "controller" in self.model_fields_set and (fault := self.unfit):
            raise ValueError(fault)
        if fault := STRATEGIES.get(preset).fault(self.search, self.controller):
            raise ValueError(f"search.preset = {preset!r}: {fault}")
        self._can_trade()
        if self.run.polish and self.traded:
            reason = f"run.polish = {self.run.polish}: improves a single design; "
            raise ValueError(f"{reason}search.preset = {preset!r} searches for a front")
        return self

    @property
    def unfit(self) -> str | None:
        """Reason why the controller cannot be designed for the machine; None: it can."""
        return self.controller.fault(self.target)

    def _can_trade(self) -> None:
        try:
            names = [one.name for one in self.traded]
        except ValueError as error:
            raise ValueError(f"search.objectives: {error}") from None
        if UNITS in names and KINDS.get(self.controller.kind).units_that_matter is None:
            raise ValueError(
                f"search.objectives: {UNITS}: needs a hierarchical controller (got kind "
                f"{self.controller.kind!r})"
            )

    def each_motion(self) -> tuple["Scenario", ...]:
        """Return a scenario of one motion for each of ``motions``; without these, only itself."""
        return tuple(map(self._alone, self.motions)) or (self,)

    def motion(self, name: str | None) -> "Scenario":
        """Return the scenario of the motion with a name (None: the first); UserError: unknown."""
        names = [motion.name for motion in self.motions]
        if name is not None and name not in names:
            known = ", ".join(names) or "a single motion without a name"
            raise UserError(f"{option('motion', name, 'name')}: scenario {self.name} has {known}")
        return self.each_motion()[names.index(name) if name is not None else 0]

    def _alone(self, motion: Motion) -> "Scenario":
        overrides = {key: getattr(motion, key) for key in ("reference", "load", "start")}
        changes: dict[str, Any] = {key: x for key, x in overrides.items() if x is not None}
        if motion.duration_s is not None:
            duration = {"duration_s": motion.duration_s}
            changes["simulation"] = self.simulation.model_copy(update=duration)
        if motion.settled_after_s is not None:
            settled = {"settled_after_s": motion.settled_after_s}
            changes["fitness"] = self.fitness.model_copy(update=settled)
        name = f"{self.name}.{motion.name}"
        return self.model_copy(update={"name": name, "motions": (), **changes})

    def _can_be_simulated(self) -> None:
        """Check that the machine can perform the only motion; ValueError: it cannot."""
        duration, every = self.simulation.duration_s, self.simulation.sample_time_s
        steps = np.round(duration / every)
        if not 1 <= steps <= MAX_STEPS:
            raise ValueError(
                f"simulation: {duration} s in samples of {every} s are {steps:.15g} "
                f"samples; must be 1 to {MAX_STEPS}"
            )
        for axis in self.plant.machine.axes:
            delay = self.limits.of(axis).delay_samples
            if delay >= steps:
                fault = (
                    f"limits.delay_samples = {delay:g}: must be less than the length of the motion"
                )
                raise ValueError(f"{fault} of {steps:.0f} samples")
        self._has_windows()
        self._speaks_of_its_axes()
        check_feasible(self.plant, self.reference, self.simulation)
        started(self.plant.machine, self.start, self.places)

    @property
    def machine(self) -> Machine:
        """The machine, with feedback from the encoders named in ``sensors``."""
        machine = self.plant.machine
        return machine.with_feedback(tuple(self.sensors.of(axis).feedback for axis in machine.axes))

    @property
    def around(self) -> tuple[Around, ...]:
        """Delay and lag around the drive of each axis."""
        each = (self.limits.of(axis) for axis in self.plant.machine.axes)
        return tuple(Around(axis_limits.delay_samples, axis_limits.lag_s) for axis_limits in each)

    @property
    def longest_delay(self) -> float | None:
        """Longest delay of a command [samples]; None if no drive has effects around it."""
        around = self.around
        also: dict[str, float] = self.robust.tolerances if self.robust else {}
        if not any(one != Around() for one in around) and not (AROUND.keys() & also):
            return None
        margin = self.robust.margin if self.robust else 1.0
        more = margin * also.get("delay_samples", 0.0)
        return float(max(one.delay_samples for one in around)) + more

    @property
    def target(self) -> Target:
        """Machine and conditions for which the controller is designed."""
        machine, every = self.machine, self.simulation.sample_time_s
        limits = self.limits.commands(machine.axes)
        path = all(motion.follows_path for motion in self.each_motion())
        modes = tuple(one.hz for one in self.stress.modes)
        return Target(machine, self.plant.values(), every, limits, self.search, path, modes)

    def _has_windows(self) -> None:
        names = [window.name for window in self.windows]
        for k, window in enumerate(self.windows):
            if names.count(window.name) > 1:
                raise ValueError(f"windows.{k}.name = {window.name!r}: is listed twice")
            if len(self.simulation.time[window.part(self.simulation)]) < 2:
                raise ValueError(
                    f"windows.{k}: from_s = {window.from_s}, to_s = {window.to_s} must "
                    "include at least two samples of a simulation of "
                    f"{self.simulation.duration_s} s"
                )

    def _speaks_of_its_axes(self) -> None:
        axes = self.plant.machine.axes
        for key in ("limits", "sensors", "load", "shaper"):
            check_axes(f"{key}.axes", getattr(self, key).axes, axes)
        for one in self.plant.each():
            if fault := feedback_fault(one.drive, self.sensors.of(one.name).feedback):
                raise ValueError(f"sensors.{fault}")
            if fault := reading_fault(one.drive, self.sensors.of(one.name).readings):
                raise ValueError(f"sensors.readings.{fault}")
            self.shaper.of(one.name).impulses(self.simulation)

    @property
    def follows_path(self) -> bool:
        """True if the machine follows a path."""
        return isinstance(self.reference, Trajectory)

    @property
    def path(self) -> Trajectory | Program | None:
        """Motion along the path that the machine follows; None: it follows no path."""
        return motion_of(self.reference, self.plant.each(), self.simulation.sample_time_s)

    @property
    def places(self) -> dict[str, float]:
        """Position of each axis before the first sample: the start of a program, otherwise 0."""
        if isinstance(path := self.path, Program):
            return path.start
        return dict.fromkeys(self.plant.machine.axes, 0.0)

    @property
    def units(self) -> Units:
        """Units of the numbers in the scenario: those of the first axis."""
        first = self.plant.each()[0]
        return Units(first.drive.units, first.length)

    @property
    def ensemble(self) -> Ensemble | None:
        """Rules that combine motions and machines to one number; None: no rules are needed."""
        if not (self.motions or self.robust or self.constraints):
            return None
        weights = tuple(motion.weight for motion in self.motions) or (1.0,)
        robust = self.robust or RobustSettings()  # with one machine its values do not matter
        bounds = constraints_on(self.constraints, self.units)
        aggregation = (robust.keep, robust.quantile, robust.forgiven)
        return Ensemble(weights, bounds, *aggregation, self.nominal_only)

    @property
    def margins(self) -> dict[str, float]:
        """Margins that the constraints require of the linearised loop of the nominal machine."""
        return {name: float(x) for name, x in self.constraints.items() if name in ASKED}

    @property
    def nominal_only(self) -> tuple[bool, ...]:
        """For each motion True if only the nominal machine is judged in it."""
        return tuple(motion.machines == "nominal" for motion in self.motions) or (False,)

    @property
    def traded(self) -> tuple[Traded, ...]:
        """Objectives of the front that is searched; () if the search ranks by one number."""
        trades = STRATEGIES.get(self.search.preset).trades
        if trades is None:
            return ()
        each = self.each_motion()
        path = all(motion.follows_path for motion in each)
        return traded(trades(self.search), self.fitness.on(self.units), self.units, path)

    def judge(self) -> Judge:
        """Return the judge of closed loops in this scenario, with all metrics that it needs."""
        fitness = objective_of(self.fitness.on(self.units))
        evaluator = judge(fitness, getattr(self.search, "stick_penalty", 0.0))
        bounds = constraints_on(self.constraints, self.units)
        weighed = [one.metric for one in self.traded if one.metric is not None]
        return evaluator._replace(measured=(*weighed, *(bound.metric for bound in bounds)))

    def samples(self) -> Samples:
        """Return the sampled inputs of the loop in the only motion, in float64."""
        time, path = self.simulation.time, self.path
        settled = settled_samples(time, self.fitness.settled_after_s).astype(float)
        generator = np.random.default_rng(self.sensors.seed)
        each, frame = self.plant.each(), None
        if path is None:
            references = [reference_of(self.reference, axis.name).samples(time) for axis in each]
        elif isinstance(path, Program):
            references, frame = path.axis_samples(time)
        else:
            references, frame = path.axis_samples(time, each[0].length)
        shapers = [self.shaper.of(axis.name).impulses(self.simulation) for axis in each]
        references, frame = shaped(references, frame, time, shapers)
        noises = [
            self.sensors.of(axis.name).noise
            * generator.standard_normal((len(axis.drive.encoders), len(time)))
            for axis in each
        ]
        axes, places = [], self.places
        for motion, axis, noise in zip(references, each, noises, strict=True):
            read = self.sensors.of(axis.name).readings.values()
            others = [one.noise * generator.standard_normal(len(time)) for one in read]
            load = self.load.of(axis.name)
            loads = np.stack([load.at(moment) for moment in self.simulation.moments])
            axis_signals = {"loads": loads, "noise": np.vstack([noise, *others])}
            axis_signals |= {"sliding": settled * slides(motion.reference_rate)}
            end = motion.target[-1]
            gone = end - places[axis.name]  # 0 but for rounding, if the axis has come back
            heading = np.sign(gone) if abs(gone) > SAME * np.ptp(motion.target) else 0.0
            ends = np.full_like(time, end), np.full_like(time, heading)
            if isinstance(path, Program):
                ends = turned_back(motion.target)
            axis_signals |= dict(zip(("end", "heading"), ends, strict=True))
            axes.append(
                motion._replace(reference=axis.drive.commanded(motion.reference), **axis_signals)
            )
        start = started(self.plant.machine, self.start, places)
        rest = (settled, self.simulation.sample_time_s, time, late_samples(time), start)
        begun = zip(axes, places.values(), strict=True)
        ways = [
            way(axis_samples.target - place, axis_samples.reference_rate)
            for axis_samples, place in begun
        ]
        finest = [self.sensors.of(axis.name).encoder_resolution for axis in each]
        return Samples(tuple(axes), frame, *rest, copy_started(each, start, ways, finest))
