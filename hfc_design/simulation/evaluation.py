"""One design on one scenario, in float64: its merit, its metrics, its whole motion."""

from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np

from hfc_design.controllers import kinds as controllers
from hfc_design.core.dotted import Changes, changed
from hfc_design.core.records import UserError, checked
from hfc_design.files.design import Design, changed_design, named_design
from hfc_design.files.machine import PlantSettings
from hfc_design.files.scenario import Scenario, load_scenario
from hfc_design.motion.metrics import CONTOUR_METRICS, Contour, contour, contour_metrics, during
from hfc_design.motion.signals import AxisSamples, Samples
from hfc_design.motion.trajectories import Trajectory
from hfc_design.objectives import metrics
from hfc_design.objectives.judge import Judge, Judged
from hfc_design.simulation import population as simulate
from hfc_design.simulation.closed_loop import Recorded, closed_loop
from plants import Plant, in_a_name


class AxisMotion(NamedTuple):
    """What one axis of the machine was to do, and did; in the units of the plant."""

    reference: np.ndarray  # (steps,) what the control was told
    load: np.ndarray  # (steps,)
    motion: Recorded  # leaves (steps,)
    readings: dict[str, np.ndarray]  # the plant's signals, each (steps,)


class Evaluation(NamedTuple):
    """What a design does on a scenario."""

    fitness: float  # -inf where it diverged
    merit: float  # what it is ranked by, see ``Scenario.judge``; -inf where it diverged
    diverged: bool
    plant: Plant
    metrics: dict[str, float | None]
    time: np.ndarray  # (steps,) [s]
    axes: tuple[AxisMotion, ...]
    contour: Contour | None  # of an X-Y machine

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
    plants = machine(design, scenario).values()
    controller, gains = controllers.from_design(design.controller)
    loop = closed_loop(scenario, controller)
    samples = scenario.samples()
    judged, motions = simulate.trajectory(loop, plants, samples, gains)
    return evaluation(scenario, plants, samples, picked(judged, 0), individual(motions, 0))


def evaluation(
    scenario: Scenario,
    plants: tuple[Any, ...],
    samples: Samples,
    judged: Judged,
    motions: tuple[Recorded, ...],
) -> Evaluation:
    """What is read off one motion, of one individual: of each axis parameters and trajectory."""
    plant = scenario.plant.plant
    axes = tuple(
        _axis(plant, parameters, happens, found)
        for parameters, happens, found in zip(plants, samples.axes, motions, strict=True)
    )
    time = scenario.simulation.time
    path = _contour(scenario, axes, plants)

    def over(part: slice) -> dict[str, float | None]:
        if path is not None:
            errors = np.stack([axis.motion.error[part] for axis in axes])
            commands = np.stack([axis.motion.command[part] for axis in axes])
            return contour_metrics(during(path, time, part), errors, commands)
        (axis,) = axes
        speed, commanded = axis.readings[plant.velocity], samples.axes[0].reference_rate
        motion = jax.tree.map(lambda leaf: leaf[part], axis.motion)
        settled = scenario.fitness.settled_after_s
        return metrics.metrics(plant, motion, speed[part], commanded[part], time[part], settled)

    found = over(slice(None))
    diverged = bool(judged.failed) or next(iter(found.values())) is None
    for window in scenario.windows:
        part = window.part(scenario.simulation)
        found |= {f"{window.name}_{key}": value for key, value in over(part).items()}
    numbers = (float(judged.values[0]), float(judged.merit))
    fitness, merit = (-np.inf, -np.inf) if diverged else numbers
    return Evaluation(fitness, merit, diverged, plant, found, time, axes, path)


def meanings(scenario: Scenario) -> dict[str, str]:
    """Meaning and unit of every metric that an evaluation on a scenario has."""
    path = isinstance(scenario.reference, Trajectory)
    own = CONTOUR_METRICS if path else metrics.meanings(scenario.plant.plant)
    parts = {f"{window.name}_": f"{window.name}: " for window in scenario.windows}
    every = {"": "", **parts}
    return {head + key: told + own[key] for head, told in every.items() for key in own}


def _contour(
    scenario: Scenario, axes: tuple[AxisMotion, ...], plants: tuple[Any, ...]
) -> Contour | None:
    """How far an X-Y machine was off its path; None for a machine of one axis."""
    reference = scenario.reference
    if not isinstance(reference, Trajectory):
        return None
    position = scenario.plant.plant.position
    positions = np.stack([getattr(axis.motion.state, position) for axis in axes])
    return contour(reference, scenario.simulation.time, positions, plants[0].blu)


def _axis(plant: Plant, parameters: Any, happens: AxisSamples, motion: Recorded) -> AxisMotion:
    readings = plant.signals(plant.coefficients(parameters), motion.state)
    return AxisMotion(
        happens.reference,
        happens.loads[0],
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
    return checked(Scenario, changed(data, changes), source, folder)


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
            for axis in wanted.axes
        },
    }
    return checked(PlantSettings, both, f"design {design.name}: plant", Path())


def trajectory_csv(evaluation: Evaluation) -> str:
    """The motion as CSV with units in the header, one row a control sample."""
    columns = _one_axis(evaluation) if evaluation.contour is None else _two_axes(evaluation)
    lines = [",".join(columns)]
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    lines += [",".join(map(repr, row)) for row in rows]
    return "\n".join(lines) + "\n"


def _one_axis(evaluation: Evaluation) -> dict[str, np.ndarray]:
    (axis,) = evaluation.axes
    plant, state = evaluation.plant, axis.motion.state
    unit = {signal: in_a_name(unit) for signal, unit in plant.units.items()}
    columns = {
        "time_s": evaluation.time,
        f"reference_{unit['error']}": axis.reference,
        f"{plant.position}_{unit['error']}": getattr(state, plant.position),
        f"error_{unit['error']}": axis.motion.error,
        f"{plant.velocity}_{unit['error_rate']}": getattr(state, plant.velocity),
    }
    if "deflection" in axis.readings:
        columns[f"deflection_{unit['deflection']}"] = axis.readings["deflection"]
    columns[f"{plant.command_name}_{unit['command']}"] = axis.motion.command
    columns[f"{plant.load_name}_{unit['load']}"] = axis.load
    return columns


def _two_axes(evaluation: Evaluation) -> dict[str, np.ndarray]:
    assert evaluation.contour is not None
    columns = {"time_s": evaluation.time}
    for name, axis in zip("xy", evaluation.axes, strict=True):
        columns |= {
            f"{name}_reference_BLU": axis.reference,
            f"{name}_position_BLU": axis.motion.state.position,
            f"{name}_error_BLU": axis.motion.error,
            f"{name}_velocity_BLU_s": axis.motion.state.velocity,
            f"{name}_command_unit": axis.motion.command,
        }
    return columns | {"contour_error_BLU": evaluation.contour.error}
