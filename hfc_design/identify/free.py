"""What is asked of a log: of which machine, in which loop, and which parameters are looked for."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from hfc_design.core.dotted import Changes, changed
from hfc_design.core.numbers import NUMBER, Floats, Parameters, Scalar
from hfc_design.core.records import UserError
from hfc_design.core.wording import one_of
from hfc_design.files.design import AnyDesign, Design
from hfc_design.files.machine import ALL_PLANTS, Axis
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.pairing import load_design, own_scenario
from hfc_design.files.scenario import Scenario
from plants import Drive

#: How far from where it began whatever a log does not tell may be.
FACTOR = 30.0
#: Factors of wrong units, mm or um for m, turns a minute, degrees. Others say nothing: a fit may
#: have begun with the values of quite another machine.
UNITS = np.log([1e3, 1e6, 60.0, 57.3])
#: Size of what may have either sign, and is 0 where it begins [its unit].
SMALL = 0.1
#: A load that is always there, beside the parameters; and those that are one, of some drives.
LOAD, OFFSETS = "load", frozenset({"offset", "unbalance", "gravity", "bias"})
#: Numbers behind those of the names: by how many samples the command acts late in all, and which
#: part of that is a first-order lag, of either sign.
LATE = ("delay_samples", "lag_s")


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Free:
    """The parameters that are looked for, and the ``LOAD``.

    Their numbers are logarithms where a sign is known, and shares of their sizes elsewhere; those
    of ``LATE`` follow. Names are compiled in, values not.
    """

    drive: Drive = field(metadata={"static": True})
    names: tuple[str, ...] = field(metadata={"static": True})
    start: Parameters  # everything, numbers
    load: Floats  # () where it begins
    scale: Floats  # (names,) size of each, in its unit
    positive: Floats  # (names,) 1 where it is more than zero, whatever it is
    begun: Floats  # (names + 2,) the numbers of the start
    near: Floats  # (names + 2,) the same where a search begins
    sought: Floats  # (2,) 1 where one of ``LATE`` may be looked for, 0 where it is known

    def parts(self, numbers: Scalar) -> tuple[Parameters, Scalar, Scalar, Scalar]:
        """The record with ``numbers`` (names + 2,) in it, late, lag and load; traced ones too."""
        own = numbers[:-2]
        values = jnp.where(self.positive > 0, self.scale * jnp.exp(own), self.scale * own)
        found = {name: values[k] for k, name in enumerate(self.names)}
        load = found.pop(LOAD, self.load) if LOAD not in self.start._fields else self.load
        return self.start._replace(**found), numbers[-2], jnp.abs(numbers[-1]), load

    @property
    def starts(self) -> dict[str, float]:
        """Where everything begins, what is not looked for too."""
        return {LOAD: float(self.load)} | {k: float(x) for k, x in self.start._asdict().items()}

    def unit(self, name: str) -> str:
        """What a parameter counts in; "" where the drive does not say it."""
        told = self.drive.parameter_units
        return told.get(name, self.drive.units["load"] if name == LOAD else "")

    def values(self, numbers: Floats) -> Floats:
        """(names,) in units of the drive."""
        own = np.asarray(numbers)[:-2]
        with np.errstate(over="ignore"):
            return np.where(self.positive > 0, self.scale * np.exp(own), self.scale * own)

    def shares(self, numbers: Floats) -> Floats:
        """(names,) by which share of itself each value changes with its number.

        What may have either sign, and ended near 0, by which share of where it began.
        """
        size = np.maximum(np.abs(np.asarray(numbers)[:-2]), 1.0)
        return np.where(self.positive > 0, 1.0, 1.0 / size)

    def rest(self) -> str:
        """What is not looked for and taken as it is, in a line; "" if there is nothing."""
        nominal = {LOAD: 0.0} | self.drive.parameters()._asdict()
        usual = {LOAD, *self.drive.exact}  # not worth a word where they are as they always are
        left = {k: x for k, x in self.starts.items() if k not in self.names}
        left = {k: x for k, x in left.items() if k not in usual or x != nominal[k]}
        known = "; set plant.parameters.NAME if you know better"
        return f"not looked for: {self._listed(left)}{known}" if left else ""

    def wanted(self) -> str:
        """What is looked for, with where it begins, in a line."""
        each = {name: self.starts[name] for name in self.names}
        late = zip(LATE, self.begun[-2:], self.sought, strict=True)
        return f"looked for, from: {self._listed(each)}" + "".join(
            f"; {name} {'from ' if open_ else 'known to be '}{x:.4g} samples"
            for name, x, open_ in late
            if open_ or x
        )

    def _listed(self, values: Mapping[str, float]) -> str:
        units = {name: self.unit(name) for name in values}
        told = (f"{k} {x:.6g} {units[k] if units[k] != '1' else ''}" for k, x in values.items())
        return ", ".join(map(str.strip, told))

    def away(self, numbers: Floats) -> dict[str, float]:
        """By which factor each parameter has left its start, of those that units may explain."""
        each = zip(self.names, self.values(numbers), self.positive, strict=True)
        factors = {name: float(x) / self.starts[name] for name, x, signed in each if x and signed}
        return {k: x for k, x in factors.items() if np.abs(abs(np.log(x)) - UNITS).min() < 0.1}


def free(
    drive: Drive,
    changes: Mapping[str, float],
    names: Sequence[str] | None = None,
    known: Collection[str] = (),
    around: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Free:
    """The parameters ``names`` of a drive, of which ``LOAD`` may be one.

    Args:
        drive: whose parameters.
        changes: values to start from.
        names: None: all that are neither exact nor 0 nor ``known``, and the load of a drive
            without one of ``OFFSETS`` among them.
        known: what stays as it is, of ``LATE`` too.
        around: the load [its unit], lateness and lag [samples] to start from.

    Raises:
        ValueError: one is unknown, or has no value to start from.
    """
    there = (*drive.parameters._fields, LOAD)
    if unknown := [name for name in (*changes, *(names or ())) if name not in there]:
        told = f"{drive.name} has no such parameter; {one_of(unknown[0], there)}"
        raise ValueError(f"{unknown[0][:60]}: {told}")
    start, fixed = drive.parameters(**changes), {*drive.exact, *known}
    if names is None:
        names = [x for x in start._fields if x not in fixed and getattr(start, x) != 0]
        if LOAD not in (*known, *start._fields) and OFFSETS.isdisjoint((*names, *known)):
            names.append(LOAD)
    sizes, signs, begun = [], [], []
    for name in (names := [*dict.fromkeys(names)]):
        own = name in start._fields
        value = float(getattr(start, name)) if own else around[0]
        signed = not own or drive.fault({**changes, name: -(value or SMALL)}) is None
        if value == 0.0 and not signed:
            raise ValueError(f"{name}: is 0; give it a value to start from: --free {name}=0.1")
        sizes.append(abs(value) or SMALL)
        signs.append(0.0 if signed else 1.0)
        begun.append(value / sizes[-1] if signed else 0.0)
    if not sizes:
        raise ValueError(f"names no parameter; {drive.name} has {', '.join(start._fields)}")
    sought = [float(name not in known) for name in LATE]
    begun += around[1:]
    numbers = (np.array(own) for own in (around[0], sizes, signs, begun, begun, sought))
    return Free(drive, tuple(names), start, *numbers)


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
