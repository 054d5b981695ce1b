"""Task of an identification: the machine, the loop, and the parameters to identify."""

from collections.abc import Sequence
from typing import NamedTuple

from hfc_design.core.numbers import NUMBER
from hfc_design.core.overrides import Changes, overridden
from hfc_design.core.records import UserError, either, option
from hfc_design.files.design import AnyDesign, Design
from hfc_design.files.loop_setup import load_design, own_scenario
from hfc_design.files.machine import ALL_PLANTS, Axis
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.identify.parameters import LATE, LOAD, FreeParameters, free_parameters


class Task(NamedTuple):
    """Identification task: scenario, free parameters and settings."""

    scenario: Scenario  # plant with the start values, sensors, limits
    axis: int  # index of the axis to identify
    design: Design | None  # the controller in the loop that recorded the logs
    names: Sequence[str] | None  # parameters to identify, NAME or NAME=START; None: all possible
    bandwidth: float | None  # of the observer [Hz]; 0: open loop; None: that of the least residual
    seed: int = 0
    made: bool = False  # True: the user named only a plant, and the scenario contains no more
    known: frozenset[str] = frozenset()  # names of values that are kept, see the function ``known``

    @property
    def drive_axis(self) -> Axis:
        """The axis to identify; its drive feeds back the encoder that its sensors name."""
        axis = self.scenario.plant.each()[self.axis]
        return axis._replace(drive=self.scenario.machine.drives[self.axis])


def known(changes: Changes, axis: str) -> frozenset[str]:
    """Return the names of an axis' values that the user set: parameters, ``LOAD``, ``LATE``."""
    tables = overridden({}, changes)
    plant, load, limits = (tables.get(name, {}) for name in ("plant", "load", "limits"))
    axes = [table.get("axes", {}).get(axis, {}) for table in (plant, load, limits)]
    names = {*plant.get("parameters", {}), *axes[0], *({*limits, *axes[2]} & {*LATE})}
    return frozenset(names | ({LOAD} if "constant" in (*load, *axes[1]) else set()))


def parameters_of(task: Task) -> FreeParameters:
    """Return the parameters to identify.

    Raises:
        UserError: a parameter is unknown, is known already, or has no value to start from.
    """
    axis = task.drive_axis
    drive, nominal = axis.drive, axis.drive.parameters()._asdict()
    changes = {k: x for k, x in axis.parameters._asdict().items() if x != nominal[k]}
    named = [[x.strip() for x in text.partition("=")] for text in task.names or ()]
    names = [name for name, *_ in named]
    limits, load = task.scenario.limits.of(axis.name), task.scenario.load.of(axis.name).constant
    lag = limits.lag_s / task.scenario.simulation.sample_time_s  # [samples]
    try:
        begun = {name: _number(name, text) for name, equals, text in named if equals}
        if both := [name for name in names if name in task.known]:
            by = option("set", ..., "changes")
            raise ValueError(f"{both[0]}: is given by {by} too; leave one of them out")
        around = begun.pop(LOAD, load), limits.delay_samples + lag, lag
        if begun.keys() <= nominal.keys() and (fault := drive.fault(changes | begun)):
            raise ValueError(fault.removeprefix("parameters."))
        return free_parameters(drive, changes | begun, names or None, task.known, around)
    except ValueError as error:
        raise UserError(either("--free ", "free: ") + str(error)) from None


def _number(name: str, text: str) -> float:
    if not NUMBER.fullmatch(text):
        raise ValueError(
            f"{name}: must have a number as start value, as in {name}=0.1 (got {text[:40]!r})"
        )
    return float(text)


def task_of(
    plant: str | None,
    scenario: AnyScenario | None,
    changes: Changes,
    axis: str | None,
    controller: AnyDesign | None,
    free: Sequence[str] | None,
    bandwidth: float | None,
    seed: int,
) -> Task:
    """Return the task, before any log is read; for the arguments see ``api.identify``.

    Raises:
        UserError: machine, axis or parameter is unknown, or the machine or the axis is missing.
    """
    design = None if controller is None else load_design(controller)
    name = ALL_PLANTS.resolve(plant).name if plant else None
    if scenario is not None:
        loaded = load_scenario(scenario, changes)
    elif design is not None:
        source = design.name if controller is design else str(controller)
        loaded = own_scenario(design, source, changes)
    elif name is not None:
        # Of this scenario only the plant counts.
        rest = {"plant": {"name": name}, "reference": {"kind": "step", "height": 0.0}}
        loaded = load_scenario({"name": "log"} | rest, changes)
    else:
        first, second = (option(x, ...) for x in ("plant", "scenario"))
        raise UserError(f"the machine is missing; give {first}, {second} or a controller")
    if name is not None and loaded.plant.name != name:
        needed = f"must be {loaded.plant.name}, the plant of the scenario"
        raise UserError(f"{option('plant', plant)}: {needed}")
    made = scenario is None and design is None
    number = _axis(loaded, axis, made)
    fixed = known(changes, loaded.plant.machine.axes[number])
    task = Task(loaded, number, design, free, bandwidth, seed, made, fixed)
    parameters_of(task)
    return task


def _axis(scenario: Scenario, axis: str | None, made: bool) -> int:
    """Return the index of an axis; UserError: unknown or missing, or it needs a scenario."""
    plant, axes = scenario.plant.name, scenario.plant.machine.axes
    if len(axes) == 1 and axis is not None:
        raise UserError(f"{option('axis', axis)}: {plant} has only one")
    if len(axes) > 1 and (axis not in axes or made):
        there = f"{plant} has the axes {', '.join(axes)}"
        why = f"; give {option('scenario', ...)} too" if axis in axes else ""
        given = f"{option('axis', axis)}:" if axis else f"{option('axis')}: is missing;"
        raise UserError(f"{given} {there}{why}")
    return axes.index(axis) if axis else 0
