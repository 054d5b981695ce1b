"""One design on one scenario, in float64: its merit, its metrics, its whole motion."""

from itertools import starmap
from typing import NamedTuple

import jax
import numpy as np

from hfc_design.controllers.controller import Signals
from hfc_design.core.shapes import Floats, Parameters
from hfc_design.files.design import Design
from hfc_design.files.pairing import controller_of, machine
from hfc_design.files.scenario import Scenario
from hfc_design.motion.metrics import Contour, contour, contour_meanings, contour_metrics, during
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
    parameters: Parameters
    happens: AxisSamples
    motion: Recorded  # leaves (steps,)

    @property
    def reference(self) -> Floats:
        """(steps,) what the control was told."""
        return np.asarray(self.happens.reference)

    @property
    def load(self) -> Floats:
        """(steps,)."""
        return np.asarray(self.happens.loads[0])

    @property
    def velocity(self) -> Floats:
        """(steps,) of the position."""
        return np.asarray(getattr(self.motion.state, self.drive.velocity))

    @property
    def readings(self) -> dict[str, Floats]:
        """The drive's signals, each (steps,)."""
        fixed = self.drive.coefficients(self.parameters)
        return _arrays(self.drive.signals(fixed, self.motion.state))

    def told(self) -> dict[str, Floats]:
        """What the axis told the control by its own sensors, signal -> (steps,)."""
        fixed = self.drive.coefficients(self.parameters)
        seen = self.drive.measured(fixed, self.motion.state)
        return _arrays(axis_signals(self.drive, fixed, seen, self.happens))


def _arrays(signals: Signals) -> dict[str, Floats]:
    return {name: np.asarray(value) for name, value in signals.items()}


class Evaluation(NamedTuple):
    """What a design does on a scenario."""

    fitness: float  # -inf where it diverged
    merit: float  # what it is ranked by, see ``Scenario.judge``; -inf where it diverged
    diverged: bool
    machine: Machine
    metrics: dict[str, float | None]
    time: Floats  # (steps,) [s]
    axes: tuple[AxisMotion, ...]
    contour: Contour | None  # of an X-Y machine on a path

    def score(self, judge: Judge) -> dict[str, float | str | None]:
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
    loop, samples = closed_loop(scenario, controller), scenario.samples()
    machines = population.one_machine(parameters)
    judged, motions = population.trajectory(loop, machines, samples, gains)
    return evaluation(scenario, parameters, samples, judged, motions, 0)


def evaluation(
    scenario: Scenario,
    parameters: tuple[Parameters, ...],
    samples: Samples,
    judged: Judged,
    motions: tuple[Recorded, ...],
    k: int,
) -> Evaluation:
    """What is read off the motion of individual ``k``, whose machine has these parameters."""
    own, time = scenario.plant.machine, scenario.simulation.time
    moved = jax.tree.map(lambda leaf: leaf[:, k], motions)
    each = zip(own.axes, own.drives, parameters, samples.axes, moved, strict=True)
    axes = tuple(starmap(AxisMotion, each))
    path = _contour(scenario, axes)
    found = _metrics(scenario, axes, path, slice(None))
    for window in scenario.windows:
        inside = _metrics(scenario, axes, path, window.part(scenario.simulation))
        found |= {f"{window.name}_{key}": value for key, value in inside.items()}
    diverged = bool(judged.failed[k]) or not all(
        np.isfinite(part).all()
        for axis in axes
        for part in (axis.motion.error, axis.motion.command, axis.velocity)
    )
    numbers = (float(judged.values[k, 0]), float(judged.merit[k]))
    fitness, merit = (-np.inf, -np.inf) if diverged else numbers
    return Evaluation(fitness, merit, diverged, own, found, time, axes, path)


def _metrics(
    scenario: Scenario, axes: tuple[AxisMotion, ...], path: Contour | None, part: slice
) -> dict[str, float | None]:
    """Every metric of a part of the motion."""
    time = scenario.simulation.time
    if path is not None:
        errors = np.stack([axis.motion.error[part] for axis in axes])
        commands = np.stack([axis.motion.command[part] for axis in axes])
        return contour_metrics(_path_meanings(scenario), during(path, time, part), errors, commands)
    found: dict[str, float | None] = {}
    for axis in axes:
        motion = jax.tree.map(lambda leaf: leaf[part], axis.motion)
        speeds = axis.velocity[part], axis.happens.reference_rate[part]
        settled = scenario.fitness.settled_after_s
        values = metrics.metrics(axis.drive, motion, *speeds, time[part], settled)
        before = f"{axis.name}_" if len(axes) > 1 else ""
        found |= {before + key: value for key, value in values.items()}
    return found


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
    length = scenario.plant.each()[0].length
    assert length is not None  # the scenario has been checked
    unit = axes[0].drive.units["error"]
    assert isinstance(scenario.reference, Trajectory)
    return contour(scenario.reference, scenario.simulation.time, positions, unit, length)


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


def _columns(axis: AxisMotion, every: bool) -> dict[str, Floats]:
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
