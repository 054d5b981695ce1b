"""What is asked of a log: of which machine, in which loop, and which parameters are looked for."""

from collections.abc import Sequence
from typing import NamedTuple

from hfc_design.core.dotted import Changes, changed
from hfc_design.core.numbers import NUMBER
from hfc_design.core.records import UserError
from hfc_design.files.design import AnyDesign, Design
from hfc_design.files.machine import ALL_PLANTS, Axis
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.pairing import load_design, own_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.identify.parameters import LATE, LOAD, Free, free


class Task(NamedTuple):
    """What is to be identified, and how."""

    scenario: Scenario  # its plant with the values to start from, sensors, limits
    axis: int  # which one
    design: Design | None  # the controller in the loop that recorded the logs
    names: Sequence[str] | None  # parameters that are looked for; None: all that may be
    bandwidth: float | None  # of the observer [Hz]; 0: open loop; None: that of the least residual
    seed: int = 0
    made: bool = False  # the scenario says no more than which machine it is
    known: frozenset[str] = frozenset()  # what stays as it is; see ``known``

    @property
    def one(self) -> Axis:
        """The axis, with the encoder that its sensors feed back."""
        found = self.scenario.plant.each()[self.axis]
        return found._replace(drive=self.scenario.machine.drives[self.axis])


def known(changes: Changes, axis: str) -> frozenset[str]:
    """What somebody has set of an axis: parameters, the load that is always there, ``LATE``."""
    told = changed({}, changes)

    plant, load, limits = (told.get(table, {}) for table in ("plant", "load", "limits"))
    axes = [part.get("axes", {}).get(axis, {}) for part in (plant, load, limits)]
    names = {*plant.get("parameters", {}), *axes[0], *({*limits, *axes[2]} & {*LATE})}
    return frozenset(names | ({LOAD} if "constant" in (*load, *axes[1]) else set()))


def looked_for(task: Task) -> Free:
    """The parameters that are looked for.

    Raises:
        UserError: one is unknown, is known already, or has no value to start from.
    """
    start = task.one
    nominal = start.drive.parameters()._asdict()
    own = {k: x for k, x in start.parameters._asdict().items() if x != nominal[k]}
    named = [name.partition("=") for name in task.names or ()]
    names = [name.strip() for name, *_ in named]
    limits, load = task.scenario.limits.of(start.name), task.scenario.load.of(start.name).constant
    lag = limits.lag_s / task.scenario.simulation.sample_time_s  # [samples]
    try:
        begun = {name.strip(): _number(name.strip(), x) for name, told, x in named if told}
        if both := task.known & {*names}:
            one = min(both, key=names.index)
            raise ValueError(f"{one}: is known by --set; leave out one of them")
        around = begun.pop(LOAD, load), limits.delay_samples + lag, lag
        if begun.keys() <= nominal.keys() and (fault := start.drive.fault(own | begun)):
            raise ValueError(fault.removeprefix("parameters."))
        return free(start.drive, own | begun, names or None, task.known, around)
    except ValueError as error:
        raise UserError(f"--free {error}") from None


def _number(name: str, text: str) -> float:
    if not NUMBER.fullmatch(text.strip()):
        told = f"has to begin at a number, as in {name}=0.1 (got {text[:40]!r})"
        raise ValueError(f"{name}: {told}")
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
    """What is asked, before any log is read; ``api.identify`` says of what.

    Raises:
        UserError: there is no such machine, axis or parameter.
    """
    design = load_design(controller) if controller is not None else None
    name = ALL_PLANTS.resolve(plant).name if plant else None
    made = scenario is None and design is None
    if scenario is not None:
        found = load_scenario(scenario, changes)
    elif design is not None:
        told = design.name if controller is design else str(controller)
        found = own_scenario(design, told, changes)
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
    number = axes.index(axis) if axis else 0
    own = known(changes, axes[number])
    task = Task(found, number, design, free, bandwidth, seed, made, own)
    looked_for(task)
    return task
