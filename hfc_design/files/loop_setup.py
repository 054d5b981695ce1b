"""Setup of a closed loop: a design and a scenario are found, checked and combined."""

from collections.abc import Mapping
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from hfc_design.controllers.controller import FOLLOWED, Controller, rate_limited
from hfc_design.core.numbers import SCALARS, Gains
from hfc_design.core.overrides import Changes, overridden, set_keys
from hfc_design.core.plugins import own_code
from hfc_design.core.records import UserError, checked, option
from hfc_design.files.design import AnyDesign, Design, Limits, changed_design, named_design, naming
from hfc_design.files.machine import ALL_PLANTS, PlantSettings
from hfc_design.files.named_scenario import load_scenario, scenario_of
from hfc_design.files.scenario import Scenario
from hfc_design.search.loop import STRATEGIES
from plants import Machine

#: Plant -> scenario of a design for it that does not record the scenario it was made for.
DEFAULT_SCENARIOS = {
    "c-axis": "c-axis-ramp",
    "feed-drive": "feed-drive-circle",
    "five-axis": "five-axis-program",
    "milling-table": "milling-table-circle",
    "positioning-stage": "positioning-stage-move",
}
#: Limits that belong to the drive and not to the controller.
CONVERTER = ("resolution", "delay_samples", "lag_s")
#: Value of all signals in ``check_laws``: small, but not 0, since a law may divide by a signal.
SMALL = 1e-3


def load_design(name: AnyDesign, changes: Changes | None = None) -> Design:
    """Return a built-in design, or that in a file or run folder; its plant and laws are checked.

    ``changes`` are values of dotted keys such as ``controller.integral_gain``. A ``Design`` without
    changes is returned as it is, unchecked.

    Raises:
        UserError: there is no such design, or it is not one that can run.
    """
    design = named_design(name)
    source = design.name if design is name else str(name)
    if changes:
        design = changed_design(design, changes, source)
    if design is not name:
        with naming(design.provenance):
            settings = design.plant.model_dump()
            plant = checked(PlantSettings, settings, f"{source}: plant", Path(source).parent)
        check_laws(design, plant.machine)
        design = _with_axes(design, source)
    return design


def _with_axes(design: Design, source: str) -> Design:
    """Return the design; if its limits name axes, its plant then names all axes of the machine.

    Raises:
        UserError: the limits are of an axis that the machine does not have.
    """
    if not design.limits.axes:
        return design
    known = axes_of(design)
    for axis in design.limits.axes:
        if axis not in known:
            hint = f"the machine has {', '.join(known)}; plant.axes can add others"
            raise UserError(f"{source}: limits.axes.{axis}: unknown axis, {hint}")
    axes = {axis: design.plant.axes.get(axis, {}) for axis in known}
    return design.model_copy(update={"plant": design.plant.model_copy(update={"axes": axes})})


def check_laws(design: Design, machine: Machine) -> None:
    """Run the law of every axis for one step in plain numbers, as the runtime does.

    Raises:
        UserError: a law reads a signal that its kind or its drive does not list, or has an error.
    """
    for axis, drive in zip(machine.axes, machine.drives, strict=True):
        part = design.by_axis().get(axis, design)
        kind, record, known = part.kind, part.controller, [*drive.inputs, *FOLLOWED]
        if kind.law is None:
            continue
        subject = f"controller {kind.name!r}: its"
        with own_code(", a step of its law", ("controller", kind.name)):
            read = kind.reads(record) if kind.reads else known
            for name in read:
                if name not in known:
                    others = ", ".join(x for x in known if x not in read)
                    why = f"which is not a signal of the plant {drive.name!r}; available: {others}"
                    raise UserError(f"controller {kind.name!r}: reads {name!r}, {why}")
            law, gains = kind.law(record, part.limits.of(axis).command), record.law_gains()
            try:
                law.step(SCALARS, gains, law.begun(SCALARS, 0.0, gains), dict.fromkeys(read, SMALL))
            except KeyError as error:
                why = "which its reads does not list" if kind.reads else "which is not a signal"
                raise UserError(f"{subject} law reads {error}, {why}") from error


def own_scenario(design: Design, name: str, changes: Changes = ()) -> Scenario:
    """Return the scenario that ``design`` was made for, or the default of its plant.

    Raises:
        UserError: the recorded scenario is not valid, or there is neither this nor a default.
    """
    values = changes if isinstance(changes, Mapping) else set_keys(changes, "set")
    plant = values.get("plant.name", design.plant.name)
    if plant != design.plant.name and plant in ALL_PLANTS.names():
        return _on_plant(design, own_scenario(design, name), plant, values)
    data = design.provenance.get("scenario", DEFAULT_SCENARIOS.get(design.plant.name))
    if data is None:
        raise UserError(f"{name}: has no scenario; give one with {option('scenario', ...)}")
    if isinstance(data, str):
        return load_scenario(data, values)
    source, path = f"{name}: provenance.scenario", Path(name)
    if not isinstance(data, dict):
        raise UserError(f"{source}: must be the name of a scenario or a scenario")
    search: Any = data.get("search")
    if isinstance(search, dict) and search.get("preset") not in [None, *STRATEGIES.names()]:
        # Nothing is searched here, so the strategy that found the design need not be installed.
        data = {key: part for key, part in data.items() if key != "search"}
    with naming(design.provenance):
        return scenario_of(overridden(data, values), source, path if path.is_dir() else path.parent)


def _on_plant(design: Design, scenario: Scenario, name: str, changes: Changes) -> Scenario:
    """Return a design's own scenario with another plant, without tolerances of what this one lacks.

    Raises:
        UserError: the plant lacks signals that the design reads, or a change is not allowed.
    """
    plant: Any = {"name": name, "axes": {axis: {} for axis in scenario.plant.axes}}
    _check_signals(design, here := PlantSettings.model_construct(**plant))
    unsaid = {"controller"} - scenario.model_fields_set  # the default one is for another plant
    data = scenario.model_dump(mode="json", exclude_none=True, exclude=unsaid) | {"plant": plant}
    if scenario.robust:
        old, new = (
            {x for parameters in one.values() for x in parameters._fields}
            for one in (scenario.plant, here)
        )
        tolerances = scenario.robust.tolerances.items()
        data["robust"]["tolerances"] = {key: x for key, x in tolerances if key not in old - new}
    return load_scenario(data, changes)


def made_for(design: Design, scenario: Scenario) -> Design:
    """Return the design with ``scenario`` in its provenance as the one that it was made for."""
    origin = {"scenario": scenario.model_dump(mode="json", exclude_none=True)}
    return design.model_copy(update={"provenance": design.provenance | origin})


def axes_of(design: Design) -> tuple[str, ...]:
    """Return the names of a design's axes: of its plant, or of the scenario it was made for.

    If that scenario is missing or cannot run here, the name is that of the plant's only axis.
    """
    if design.axis:
        return (design.axis,)
    plant_machine = PlantSettings(**design.plant.model_dump()).machine
    if len(plant_machine.axes) > 1:
        return plant_machine.axes
    try:
        return machine(design, own_scenario(design, design.name)).machine.axes
    except UserError:
        return plant_machine.axes


def machine(design: Design, scenario: Scenario) -> PlantSettings:
    """Return the plant of ``design``, with the parameters that ``scenario`` sets.

    If the scenario has another plant, return that one as it is, provided that it has the signals
    that the design reads.

    Raises:
        UserError: it lacks signals, or design and scenario have different sample times.
    """
    design_plant, wanted = design.plant, scenario.plant
    if design_plant.name != wanted.name:
        _check_signals(design, wanted)
    sample_time = scenario.simulation.sample_time_s
    if design.controller.sample_time_s != sample_time:
        raise UserError(
            f"design {design.name} runs every {design.controller.sample_time_s} s, "
            f"scenario {scenario.name} has simulation.sample_time_s = {sample_time}; set it to "
            f"{design.controller.sample_time_s} in the scenario, or design again with the scenario"
        )
    if design_plant.name != wanted.name:
        return wanted
    axes = {
        axis: design_plant.axes.get(axis, {}) | wanted.parameters | wanted.axes.get(axis, {})
        for axis in wanted.machine.axes
        if axis in design_plant.axes or axis in wanted.axes
    }
    both = {
        "name": design_plant.name,
        "parameters": design_plant.parameters | wanted.parameters,
        "axes": axes,
    }
    return checked(PlantSettings, both, f"design {design.name}: plant", Path())


def _check_signals(design: Design, here: PlantSettings) -> None:
    """Check that a plant has the signals that a design reads; UserError: a name or unit differs."""
    plant_name = design.plant.name
    head = f"design {design.name} is for the plant {plant_name} and cannot run on {here.name}"
    try:
        made, machine = PlantSettings(**design.plant.model_dump()).machine, here.machine
    except ValueError:  # the plant is of a plug-in that is not loaded
        raise UserError(f"{head}: unknown plant {plant_name}") from None
    parts, drives = design.by_axis(), dict(zip(made.axes, made.drives, strict=True))
    if "" not in parts and {*parts} != {*machine.axes}:
        mismatch = f"axes must be {', '.join(parts)} (got {', '.join(machine.axes)})"
        raise UserError(f"{head}: {mismatch}")
    for axis, drive in zip(machine.axes, machine.drives, strict=True):
        part = parts.get(axis, design)
        read = part.kind.reads(part.controller) if part.kind.reads else drive.inputs
        units = drives.get(axis, made.drives[0]).units
        for name in ("error", "command", "load", *read):
            unit, got = units.get(name), drive.units.get(name)
            if None not in (unit, got) and unit != got:
                raise UserError(f"{head}: {name} must be in {unit} (got {got})")
    try:
        check_laws(design, machine)
    except UserError as error:
        raise error.within(head) from None


def with_converter(scenario: Scenario, design: Design) -> Scenario:
    """Return the scenario with the converter of ``design``, as far as the scenario sets none.

    The converter (resolution, delay and lag of the command) belongs to the drive, so it goes with
    the plant. The largest command goes with the controller, which applies it. Sensors, load and
    reference are those of the scenario.

    Raises:
        UserError: the resulting limits contradict one another.
    """
    made_for = {axis: design.limits.of(axis) for axis in scenario.plant.machine.axes}
    inherited = {}
    for axis, design_limits in made_for.items():
        scenario_limits = scenario.limits.of(axis)
        inherited[axis] = {
            key: getattr(design_limits, key)
            for key in CONVERTER
            if key not in scenario_limits.model_fields_set
        }
    if not any(any(converter.values()) for converter in inherited.values()):
        return scenario
    axes = {
        axis: converter | scenario.limits.axes.get(axis, {})
        for axis, converter in inherited.items()
    }
    every = scenario.limits.model_dump(exclude={"axes"}, exclude_none=True)
    source = f"design {design.name} on scenario {scenario.name}: limits"
    limits = checked(Limits, every | {"axes": axes}, source, Path())
    return scenario.model_copy(update={"limits": limits})


def controller_of(design: Design, scenario: Scenario) -> tuple[Controller, Gains]:
    """Return the controller of a design on the axes of a scenario, and gains for one individual.

    The rates of its commands are limited by drives of the scenario that are slower.
    """
    slower = slower_drives(design, scenario)
    controller = design.commanding(slower)
    controller = rate_limited(controller, scenario.limits.commands(slower), slower)
    return controller, population_of_one(design.controller.law_gains())


def slower_drives(design: Design, scenario: Scenario) -> dict[str, float | None]:
    """Return the largest change of a command per sample by axis; None: the design is not faster."""
    axes = scenario.plant.machine.axes
    drives = scenario.limits.changes(axes, scenario.simulation.sample_time_s)
    design_changes = design.changes(axes)
    return {k: x if x and x < (design_changes[k] or inf) else None for k, x in drives.items()}


def check_drives(design: Design, scenario: Scenario) -> None:
    """Check that drives can follow a design's fastest command; UserError: one cannot."""
    for axis, change in slower_drives(design, scenario).items():
        if change:
            rate = scenario.limits.of(axis).command_rate
            raise UserError(
                f"scenario {scenario.name}: limits.command_rate = {rate}: must not be below that "
                f"of design {design.name} in a loop of LinuxCNC; set it in the design too"
            )


def population_of_one(gains: Gains) -> Gains:
    """Return gains with a trailing axis of length 1 (one individual) on each number and table."""
    if gains is None:
        return None
    if hasattr(gains, "_fields"):
        return type(gains)(*map(population_of_one, gains))
    if isinstance(gains, tuple) and any(hasattr(part, "_fields") for part in gains):
        return tuple(map(population_of_one, gains))  # a record for each axis
    table = np.array(gains)
    return table.astype(np.int32 if table.dtype.kind == "i" else np.float64)[..., None]
