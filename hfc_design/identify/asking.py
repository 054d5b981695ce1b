"""What somebody asks of a log: which machine it is of, which columns it has, what to look for."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from hfc_design.core.dotted import Changes
from hfc_design.core.records import UserError
from hfc_design.files.design import AnyDesign, Design
from hfc_design.files.machine import ALL_PLANTS
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.pairing import load_design, own_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.identify.identified import identify
from hfc_design.identify.result import Identified
from hfc_design.identify.search import Tell
from hfc_design.identify.sources import Source, recordings, sources
from hfc_design.identify.task import Task, known, looked_for


class Question(NamedTuple):
    """What is looked for, and logs that are not read yet, by their names."""

    task: Task
    logs: dict[str, Source]


def asked(
    log: Path,
    *,
    plant: str | None,
    scenario: AnyScenario | None,
    changes: Changes,
    axis: str | None,
    controller: AnyDesign | None,
    free: Sequence[str] | None,
    bandwidth: float | None,
    columns: Sequence[str],
    check_log: Path | None,
    check_columns: Sequence[str],
    seed: int,
) -> Question:
    """What is asked of a log, before anything of it is read; ``api.identify`` says of what.

    Raises:
        UserError: there is no such machine, axis or parameter, or a column is none of its signals.
    """
    where, design, made = _machine(plant, scenario, changes, axis, controller)
    axes = where.plant.machine.axes
    number = axes.index(axis) if axis else 0
    own = known(changes, axes[number])
    task = Task(where, number, design, free, bandwidth, seed, made, own)
    looked_for(task)
    drive = where.machine.drives[number]
    return Question(task, sources(log, drive, columns, check_columns, check_log))


def answered(question: Question, sample_time: float | None, tell: Tell) -> Identified:
    """What the logs tell.

    Raises:
        UserError: one cannot be read, has not what is needed, or no replay of it stays finite.
    """
    task = question.task
    drive = task.scenario.machine.drives[task.axis]
    logs, scenario = recordings(question.logs, task.scenario, drive, sample_time)
    return identify(task._replace(scenario=scenario), logs, tell)


def _machine(
    plant: str | None,
    scenario: AnyScenario | None,
    changes: Changes,
    axis: str | None,
    controller: AnyDesign | None,
) -> tuple[Scenario, Design | None, bool]:
    """The scenario of the one axis, the controller, and whether the scenario is made up here."""
    design = load_design(controller) if controller is not None else None
    name = ALL_PLANTS.resolve(plant).name if plant else None
    made = scenario is None and design is None
    if scenario is not None:
        found = load_scenario(scenario, changes)
    elif design is not None:
        called = design.name if controller is design else str(controller)
        found = own_scenario(design, called, changes)
    elif name is not None:
        # Of these only the plant counts.
        still = {"kind": "step", "height": 0.0}
        log = {"name": "log", "plant": {"name": name}, "reference": still}
        found = load_scenario(log, changes)
    else:
        raise UserError("which machine is it? say --plant, --scenario or --controller")
    if name is not None and found.plant.name != name:
        raise UserError(f"--plant {plant}: the scenario is for the plant {found.plant.name}")
    axes = found.plant.machine.axes
    if len(axes) > 1 and (axis not in axes or made):
        told = f"{found.plant.name} has the axes {', '.join(axes)}"
        why = "; say --scenario too" if axis in axes else ""
        raise UserError(f"--axis {axis}: {told}{why}" if axis else f"--axis: which one? {told}")
    if len(axes) == 1 and axis is not None:
        raise UserError(f"--axis {axis}: {found.plant.name} has only one")
    return found, design, made
