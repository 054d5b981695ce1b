"""Definition of a machine: named axes, each with its own drive, and the forces between them.

A single drive counts as a machine of one axis; ``side_by_side`` puts drives next to each other,
``coupled`` adds forces between them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from operator import add
from typing import Any, TypeAlias

import jax
from jax import lax, tree
from jax import numpy as jnp

from plants.drive import NAME, NAMED, Drive, Scalar, called, drive_fault, fed_back

#: Name of the axis of a machine with one axis.
ONLY = "axis"
#: Tuple with one item per axis: parameters, coefficients, states, commands or loads.
Each: TypeAlias = tuple[Any, ...]
#: Forces(fixed, states, commands) -> addition to the load of each axis, in its unit.
Forces: TypeAlias = Callable[[Each, Each, Each], Each]


@dataclass(frozen=True, eq=False)  # compared by identity: a machine is a key of compiled code
class Machine:
    """Axes side by side, or coupled; every function computes one machine, with scalars."""

    name: str
    axes: tuple[str, ...]
    drives: tuple[Drive, ...]
    #: Forces between the axes; None: the axes are independent.
    forces: Forces | None = None

    def __repr__(self) -> str:
        return f"Machine({self.name!r}: axes {', '.join(self.axes)})"

    def only(self, k: int) -> "Machine":
        """Return axis ``k`` alone."""
        return Machine(self.name, (self.axes[k],), (self.drives[k],))

    def with_feedback(self, encoders: tuple[str | None, ...]) -> "Machine":
        """Return the machine with feedback from ``encoders``, one an axis; None: unchanged."""
        if not any(encoders):
            return self
        pairs = zip(self.drives, encoders, strict=True)
        drives = tuple(fed_back(drive, encoder) if encoder else drive for drive, encoder in pairs)
        return _beside(self.name, self.axes, drives, self.forces)

    def coefficients(self, parameters: Each) -> Each:
        """Return the quantities that a step needs of the parameters of each axis."""
        pairs = zip(self.drives, parameters, strict=True)
        return tuple(drive.coefficients(axis_parameters) for drive, axis_parameters in pairs)

    def initial_state(self, zero: Scalar) -> Each:
        """Return the state of each axis at rest."""
        return tuple(drive.initial_state(zero) for drive in self.drives)

    def moved(
        self, fixed: Each, states: Each, commands: Each, loads: Each, time: Scalar, substeps: int
    ) -> Each:
        """Return the states ``time`` [s] later, after ``substeps`` steps under held commands.

        ``loads`` has for each axis the load at the start, the middle and the end of every substep
        (2 substeps + 1).
        """
        dt = time / substeps
        if substeps == 1:
            return self.step(fixed, states, commands, loads, dt)
        points = [jnp.stack(axis_loads) for axis_loads in loads]

        def substep(k: Scalar, states: Each) -> Each:
            here = tuple(
                (axis_loads[2 * k], axis_loads[2 * k + 1], axis_loads[2 * k + 2])
                for axis_loads in points
            )
            return self.step(fixed, states, commands, here, dt)

        return tuple(lax.fori_loop(0, substeps, substep, states))

    def step(self, fixed: Each, states: Each, commands: Each, loads: Each, dt: Scalar) -> Each:
        """Return the states after a step of the integrator; ``loads`` has three loads per axis."""

        def pushed(loads: Each) -> Each:
            each = zip(self.drives, fixed, states, commands, loads, strict=True)
            return tuple(drive.step(c, x, u, load, dt) for drive, c, x, u, load in each)

        if self.forces is None:
            return pushed(loads)
        # The forces at the end are those after a trial step, so that the step is of second order.
        before = self.forces(fixed, states, commands)
        held_forces = tuple((force, force, force) for force in before)
        after = self.forces(fixed, pushed(tree.map(add, loads, held_forces)), commands)
        rising = tuple((a, 0.5 * (a + b), b) for a, b in zip(before, after, strict=True))
        return pushed(tree.map(add, loads, rising))


_beside = cache(Machine)  # always the same object for equal drives: it is a key of compiled code


def machine_of(plant: Drive | Machine) -> Machine:
    """Return the machine of a plant: a drive is a machine of one axis."""
    return plant if isinstance(plant, Machine) else _beside(plant.name, (ONLY,), (plant,))


def side_by_side(name: str = "", **drives: Drive) -> Machine:
    """Return a machine of independent axes, as in ``side_by_side(x=DRIVE, y=DRIVE)``.

    ``name`` is its name in scenarios; "": the names of its drives.
    """
    names = dict.fromkeys(getattr(drive, "name", "") for drive in drives.values())
    machine_name = name or "-".join(names) or "machine"
    return _beside(machine_name, tuple(drives), tuple(drives.values()))


def coupled(plant: Drive | Machine, forces: Forces, name: str = "") -> Machine:
    """Return the machine with ``forces`` between its axes, under a new ``name`` if it is not ""."""
    machine = machine_of(plant)
    return Machine(name or machine.name, machine.axes, machine.drives, forces)


def plant_fault(plant: Drive | Machine) -> str | None:
    """Return a line on why a plant cannot work; None if no fault is found without a simulation."""
    machine = machine_of(plant)
    for fault_of in (drive_fault, step_fault):
        if fault := next(filter(None, map(fault_of, machine.drives)), None):
            return fault
    if not machine.axes or len(machine.axes) != len(machine.drives):
        return "must have a drive for each of its axes"
    if wrong := [axis for axis in machine.axes if not NAME.fullmatch(axis)]:
        return f"its axis {wrong[0]!r} must be {NAMED}"
    if machine.forces is None:
        return None
    fixed = machine.coefficients(tuple(drive.parameters() for drive in machine.drives))
    zeros = (0.0,) * len(machine.axes)
    forces = called(machine, "forces", fixed, machine.initial_state(0.0), zeros)
    if not isinstance(forces, tuple) or len(forces) != len(machine.axes):
        return f"its forces must be a tuple of {len(machine.axes)}, one per axis"
    return None


def step_fault(drive: Drive) -> str | None:
    """Return a line on what is wrong with the result of a step; None if it is right.

    None also if the step raises: the simulation reports that, with the line of the user's code.
    """
    fixed = called(drive, "coefficients", drive.parameters())
    before = called(drive, "initial_state", 0.0)
    if not hasattr(before, "_fields"):
        return "initial_state must return a NamedTuple"
    try:
        after = jax.eval_shape(drive.step, fixed, before, 0.0, (0.0, 0.0, 0.0), 1e-3)
    except Exception:  # whatever the user's code raises
        return None
    if type(after) is not type(before):
        wrong = f"it returns {_kind(after)}"
    else:
        values = {name: getattr(after, name) for name in before._fields}
        each = [f"{name} is {_kind(x)}" for name, x in values.items() if not _is_float(x)]
        wrong = ", ".join(each)
    fields = ", ".join(before._fields)
    message = f"step must return the record {type(before).__name__} with {fields}, each a float"
    return f"{message}: {wrong}" if wrong else None


def _is_float(value: Any) -> bool:
    return hasattr(value, "dtype") and jnp.issubdtype(value.dtype, jnp.floating)


def _kind(value: Any) -> str:
    """Return the kind of a value of the wrong type."""
    if value is None:
        return "None"
    return str(value.dtype) if hasattr(value, "dtype") else f"a {type(value).__name__}"
