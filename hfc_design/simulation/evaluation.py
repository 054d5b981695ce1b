"""One design on one scenario, in float64: its merit, its metrics, its whole motion."""

from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np

from hfc_design.controllers.controller import Controller
from hfc_design.core.dotted import Changes, changed
from hfc_design.core.records import UserError, checked
from hfc_design.files.design import Design, changed_design, named_design
from hfc_design.files.machine import PlantSettings
from hfc_design.files.scenario import Scenario, load_scenario, scenario_of
from hfc_design.motion.metrics import (
    Contour,
    contour,
    contour_meanings,
    contour_metrics,
    during,
)
from hfc_design.motion.samples import AxisSamples, Samples
from hfc_design.motion.trajectories import Trajectory
from hfc_design.objectives import metrics
from hfc_design.objectives.judge import Judge, Judged
from hfc_design.simulation import population
from hfc_design.simulation.closed_loop import Recorded, axis_signals, closed_loop
from plants import Drive, Machine, in_a_name


class AxisMotion(NamedTuple):
    """What one axis of the machine was to do, and did; in the units of its drive."""

    name: str
    drive: Drive
    parameters: Any
    happens: AxisSamples
    motion: Recorded  # leaves (steps,)
    readings: dict[str, np.ndarray]  # the drive's signals, each (steps,)

    @property
    def reference(self) -> np.ndarray:
        """(steps,) what the control was told."""
        return np.asarray(self.happens.reference)

    @property
    def load(self) -> np.ndarray:
        """(steps,)."""
        return np.asarray(self.happens.loads[0])

    def told(self) -> dict[str, np.ndarray]:
        """What the axis told the control by its own sensors, signal -> (steps,)."""
        fixed = self.drive.coefficients(self.parameters)
        seen = self.drive.measured(fixed, self.motion.state)
        found = axis_signals(self.drive, fixed, seen, self.happens)
        return {name: np.asarray(value) for name, value in found.items()}

    @property
    def velocity(self) -> np.ndarray:
        """(steps,) of the position."""
        return np.asarray(getattr(self.motion.state, self.drive.velocity))


class Evaluation(NamedTuple):
    """What a design does on a scenario."""

    fitness: float  # -inf where it diverged
    merit: float  # what it is ranked by, see ``Scenario.judge``; -inf where it diverged
    diverged: bool
    machine: Machine
    metrics: dict[str, float | None]
    time: np.ndarray  # (steps,) [s]
    axes: tuple[AxisMotion, ...]
    contour: Contour | None  # of an X-Y machine on a path

    def score(self, judge: Judge) -> dict[str, Any]:
        """Fitness, merit and metrics as a file has them: None where there is no number."""
        fitness, merit = (None if self.diverged else x for x in (self.fitness, self.merit))
        return {"fitness": fitness, "merit": merit, "judged_by": judge.title, **self.metrics}


def evaluate(design: Design, scenario: Scenario) -> Evaluation:
    """Simulate ``design`` on ``scenario``.

    The plant is the design's, with the parameters that the scenario sets laid over it.

    Raises:
        UserError: the two are made for different plants or sample times.
    """
    parameters = machine(design, scenario).values()
    controller, gains = controller_of(design, scenario)
    loop = closed_loop(scenario, controller)
    samples = scenario.samples()
    machines = population.one_machine(parameters)
    judged, motions = population.trajectory(loop, machines, samples, gains)
    return evaluation(scenario, parameters, samples, picked(judged, 0), individual(motions, 0))


def controller_of(design: Design, scenario: Scenario) -> tuple[Controller, Any]:
    """The controller of a design on the axes of a scenario, and its gains for one individual."""
    limits = design.axis_limits(scenario.plant.machine.axes)
    controller = design.kind.controller_of(design.controller, limits)
    return controller, population_of_one(design.kind.gains(design.controller))


def population_of_one(gains: Any) -> Any:
    """A record of numbers and tables with an axis of individuals behind each."""
    if gains is None:
        return None
    if hasattr(gains, "_fields"):
        return type(gains)(*(population_of_one(part) for part in gains))
    if isinstance(gains, tuple) and any(hasattr(part, "_fields") for part in gains):
        return tuple(population_of_one(part) for part in gains)  # of each axis
    table = np.array(gains)
    return table.astype(np.int32 if table.dtype.kind == "i" else np.float64)[..., None]


def evaluation(
    scenario: Scenario,
    parameters: tuple[Any, ...],
    samples: Samples,
    judged: Judged,
    motions: tuple[Recorded, ...],
) -> Evaluation:
    """What is read off one motion, of one individual: of each axis parameters and trajectory."""
    own = scenario.plant.machine
    axes = tuple(
        _axis(*each)
        for each in zip(own.axes, own.drives, parameters, samples.axes, motions, strict=True)
    )
    time = scenario.simulation.time
    path = _contour(scenario, axes)

    def over(part: slice) -> dict[str, float | None]:
        if path is not None:
            errors = np.stack([axis.motion.error[part] for axis in axes])
            commands = np.stack([axis.motion.command[part] for axis in axes])
            wanted = _path_meanings(scenario)
            return contour_metrics(wanted, during(path, time, part), errors, commands)
        found: dict[str, float | None] = {}
        for axis, happens in zip(axes, samples.axes, strict=True):
            before = f"{axis.name}_" if len(axes) > 1 else ""
            values = metrics.metrics(
                axis.drive,
                jax.tree.map(lambda leaf: leaf[part], axis.motion),
                axis.velocity[part],
                happens.reference_rate[part],
                time[part],
                scenario.fitness.settled_after_s,
            )
            found |= {before + key: value for key, value in values.items()}
        return found

    found = over(slice(None))
    diverged = bool(judged.failed) or not all(
        np.isfinite(part).all()
        for axis in axes
        for part in (axis.motion.error, axis.motion.command, axis.velocity)
    )
    for window in scenario.windows:
        part = window.part(scenario.simulation)
        found |= {f"{window.name}_{key}": value for key, value in over(part).items()}
    numbers = (float(judged.values[0]), float(judged.merit))
    fitness, merit = (-np.inf, -np.inf) if diverged else numbers
    return Evaluation(fitness, merit, diverged, own, found, time, axes, path)


def meanings(scenario: Scenario) -> dict[str, str]:
    """Meaning and unit of every metric that an evaluation on a scenario has."""
    machine = scenario.plant.machine
    if scenario.follows_path:
        own = _path_meanings(scenario)
    else:
        several = len(machine.axes) > 1
        own = {
            (f"{axis}_" if several else "") + key: (f"{axis}: " if several else "") + text
            for axis, drive in zip(machine.axes, machine.drives, strict=True)
            for key, text in metrics.meanings(drive).items()
        }
    parts = {f"{window.name}_": f"{window.name}: " for window in scenario.windows}
    every = {"": "", **parts}
    return {head + key: told + own[key] for head, told in every.items() for key in own}


def _path_meanings(scenario: Scenario) -> dict[str, str]:
    units = scenario.plant.machine.drives[0].units
    return contour_meanings(units["error"], units["command"])


def _contour(scenario: Scenario, axes: tuple[AxisMotion, ...]) -> Contour | None:
    """How far an X-Y machine was off its path; None where it follows none."""
    if not scenario.follows_path:
        return None
    positions = np.stack([getattr(axis.motion.state, axis.drive.position) for axis in axes])
    length = scenario.lengths[0]
    assert length is not None  # the scenario has been checked
    unit = axes[0].drive.units["error"]
    assert isinstance(scenario.reference, Trajectory)
    return contour(scenario.reference, scenario.simulation.time, positions, unit, length)


def _axis(
    name: str, drive: Drive, parameters: Any, happens: AxisSamples, motion: Recorded
) -> AxisMotion:
    readings = drive.signals(drive.coefficients(parameters), motion.state)
    return AxisMotion(
        name,
        drive,
        parameters,
        happens,
        motion,
        {name: np.asarray(value) for name, value in readings.items()},
    )


def picked(judged: Any, which: Any) -> Any:
    """Some of a population's records, its individuals in the leading axis."""
    return jax.tree.map(lambda leaf: leaf[which], judged)


def individual(motions: tuple[Recorded, ...], k: int) -> Any:
    """The motion of every axis of one of a population, leaves (steps,)."""
    return jax.tree.map(lambda leaf: leaf[:, k], motions)


def load_design(name: str, changes: Changes = ()) -> Design:
    """The design with a built-in name, in a file or in a run folder, with a plant that can run.

    ``changes`` are of dotted keys, as in ``controller.integral_gain``.

    Raises:
        UserError: there is no such design, or it is not one that can run.
    """
    design = named_design(name)
    if changes:
        design = changed_design(design, changes, name)
    checked(PlantSettings, design.plant.model_dump(), f"{name}: plant", Path(name).parent)
    return design


#: Plant -> the scenario of a design that does not name its own.
DEFAULT_SCENARIOS = {"c-axis": "c-axis-ramp", "feed-drive": "feed-drive-circle"}


def own_scenario(design: Design, name: str, changes: Changes = ()) -> Scenario:
    """The scenario that ``design`` was made for, or a default of its plant.

    Raises:
        UserError: the provenance holds a scenario that is not valid, or there is none at all.
    """
    data = design.provenance.get("scenario", DEFAULT_SCENARIOS.get(design.plant.name))
    if data is None:
        raise UserError(f"{name}: names no scenario; give one with --scenario")
    if isinstance(data, str):
        return load_scenario(data, changes)
    source = f"{name}: provenance.scenario"
    if not isinstance(data, dict):
        raise UserError(f"{source}: has to be a name or a scenario")
    path = Path(name)
    folder = path if path.is_dir() else path.parent
    return scenario_of(changed(data, changes), source, folder)


def machine(design: Design, scenario: Scenario) -> PlantSettings:
    """The plant of ``design`` with what ``scenario`` sets laid over it.

    Raises:
        UserError: the two are made for different plants or sample times.
    """
    if design.plant.name != scenario.plant.name:
        raise UserError(
            f"design {design.name} is for the plant {design.plant.name}, "
            f"scenario {scenario.name} has {scenario.plant.name}"
        )
    sample_time = scenario.simulation.sample_time_s
    if design.controller.sample_time_s != sample_time:
        raise UserError(
            f"design {design.name} runs every {design.controller.sample_time_s} s, "
            f"scenario {scenario.name} has simulation.sample_time_s = {sample_time}"
        )
    own, wanted = design.plant, scenario.plant
    both = {
        "name": own.name,
        "parameters": own.parameters | wanted.parameters,
        "axes": {
            axis: own.axes.get(axis, {}) | wanted.parameters | wanted.axes.get(axis, {})
            for axis in wanted.machine.axes
            if axis in own.axes or axis in wanted.axes
        },
    }
    return checked(PlantSettings, both, f"design {design.name}: plant", Path())


def trajectory_csv(evaluation: Evaluation) -> str:
    """The motion as CSV with units in the header, one row a control sample."""
    columns = {"time_s": evaluation.time}
    several = len(evaluation.axes) > 1
    for axis in evaluation.axes:
        own = _columns(axis, every=not several)
        columns |= {(f"{axis.name}_" if several else "") + key: x for key, x in own.items()}
    if evaluation.contour is not None:
        columns[f"contour_error_{in_a_name(evaluation.contour.unit)}"] = evaluation.contour.error
    lines = [",".join(columns)]
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    lines += [",".join(map(repr, row)) for row in rows]
    return "\n".join(lines) + "\n"


def _columns(axis: AxisMotion, every: bool) -> dict[str, np.ndarray]:
    """One axis; ``every`` adds what a table of several has no room for."""
    drive, state = axis.drive, axis.motion.state
    unit = {signal: in_a_name(unit) for signal, unit in drive.units.items()}
    columns = {
        f"reference_{unit['error']}": axis.reference,
        f"{drive.position}_{unit['error']}": getattr(state, drive.position),
        f"error_{unit['error']}": axis.motion.error,
        f"{drive.velocity}_{unit['error_rate']}": getattr(state, drive.velocity),
    }
    if "deflection" in axis.readings and every:
        columns[f"deflection_{unit['deflection']}"] = axis.readings["deflection"]
    columns[f"{drive.command_name}_{unit['command']}"] = axis.motion.command
    if every:
        columns[f"{drive.load_name}_{unit['load']}"] = axis.load
    return columns
