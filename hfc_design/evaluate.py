"""One design on one scenario, in float64: its score, its metrics, its whole motion."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np

from hfc_design import controllers, fitness, simulate
from hfc_design.paths.metrics import Contour, contour, contour_metrics
from hfc_design.paths.trajectories import Trajectory
from hfc_design.records import UserError, checked
from hfc_design.rulebase import Design, named_design
from hfc_design.scenarios import PlantSettings, Scenario, changed, load_scenario
from hfc_design.signals import AxisSamples, Samples
from plants import Plant


class AxisMotion(NamedTuple):
    """What one axis of the machine was to do, and did."""

    reference: np.ndarray  # (steps,) [rad]
    load: np.ndarray  # (steps,) [N m]
    motion: simulate.Trajectory  # leaves (steps,)
    readings: dict[str, np.ndarray]  # the plant's signals, each (steps,)


class Evaluation(NamedTuple):
    """What a design does on a scenario."""

    fitness: float  # 0 where it diverged
    diverged: bool
    metrics: dict[str, float | None]
    time: np.ndarray  # (steps,) [s]
    axes: tuple[AxisMotion, ...]
    contour: Contour | None  # of an X-Y machine


def evaluate(design: Design, scenario: Scenario) -> Evaluation:
    """Simulate ``design`` on ``scenario``.

    The plant is the design's, with the parameters that the scenario sets laid over it.

    Raises:
        UserError: the two are made for different plants or sample times.
    """
    plants = machine(design, scenario).values()
    controller, gains = controllers.from_design(design.controller)
    loop = simulate.closed_loop(scenario, controller)
    samples = scenario.samples()
    scores, motions = simulate.trajectory(loop, plants, samples, gains)
    return evaluation(scenario, plants, samples, scores[0], individual(motions, 0))


def evaluation(
    scenario: Scenario,
    plants: tuple[Any, ...],
    samples: Samples,
    score: float,
    motions: tuple[simulate.Trajectory, ...],
) -> Evaluation:
    """What is read off one motion: ``score``, and of each axis its parameters and trajectory."""
    plant = scenario.plant.plant
    axes = tuple(
        _axis(plant, parameters, happens, found)
        for parameters, happens, found in zip(plants, samples.axes, motions, strict=True)
    )
    time = scenario.simulation.time
    path = _contour(scenario, axes, plants)
    if path is None:
        found = fitness.metrics(
            axes[0].motion,
            axes[0].readings[plant.velocity],
            samples.axes[0].reference_rate,
            time,
            scenario.fitness.settled_after_s,
        )
    else:
        errors = np.stack([axis.motion.error for axis in axes])
        commands = np.stack([axis.motion.command for axis in axes])
        found = contour_metrics(path, errors, commands)
    diverged = next(iter(found.values())) is None
    return Evaluation(0.0 if diverged else float(score), diverged, found, time, axes, path)


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


def _axis(
    plant: Plant, parameters: Any, happens: AxisSamples, motion: simulate.Trajectory
) -> AxisMotion:
    readings = plant.signals(plant.coefficients(parameters), motion.state)
    return AxisMotion(
        happens.reference,
        happens.loads[0],
        motion,
        {name: np.asarray(value) for name, value in readings.items()},
    )


def individual(motions: tuple[simulate.Trajectory, ...], k: int) -> Any:
    """The motion of every axis of one of a population, leaves (steps,)."""
    return jax.tree.map(lambda leaf: leaf[:, k], motions)


def load_design(name: str) -> Design:
    """The design with a built-in name, in a file or in a run folder, with a plant that can run.

    Raises:
        UserError: there is no such design, or it is not one that can run.
    """
    design = named_design(name)
    checked(PlantSettings, design.plant.model_dump(), f"{name}: plant", Path(name).parent)
    return design


#: Plant -> the scenario of a design that does not name its own.
DEFAULT_SCENARIOS = {"c-axis": "c-axis-ramp", "feed-drive": "feed-drive-circle"}


def own_scenario(design: Design, name: str, changes: Iterable[str] = ()) -> Scenario:
    """The scenario that ``design`` was made for, or a default of its plant.

    Raises:
        UserError: the provenance holds a scenario that is not valid.
    """
    data = design.provenance.get("scenario", DEFAULT_SCENARIOS[design.plant.name])
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
    state = axis.motion.state
    return {
        "time_s": evaluation.time,
        "reference_rad": axis.reference,
        "spindle_angle_rad": state.spindle_angle,
        "error_rad": axis.motion.error,
        "spindle_velocity_rad_s": state.spindle_velocity,
        "deflection_rad": axis.readings["deflection"],
        "voltage_V": axis.motion.command,
        "load_torque_Nm": axis.load,
    }


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
