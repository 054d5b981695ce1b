"""The plant of a design as an FMU, alone or under its controller."""

from hfc_design.core.numbers import Json
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.machine import Axis
from hfc_design.files.motions import started
from hfc_design.files.pairing import check_drives, machine, own_scenario, with_converter
from hfc_design.files.scenario import Scenario
from hfc_design.formats import code, machine_code, plant_code
from hfc_design.formats.fmu.axes import (
    axis_of,
    converter,
    followed,
    given,
    head_of,
    load_of,
    moments,
    reading_of,
    sensing,
)
from hfc_design.formats.fmu.control import commands_machine, part, path_variables
from hfc_design.formats.fmu.description import TIME, Model, Variable

STAYS = "the machine and its control stay as they were"


def plant(design: Design) -> Model:
    """The machine of a design alone: from commands and loads to where it is.

    Raises:
        UserError: there is no C of it, or the scenario of the design cannot be read.
    """
    scenario, axes = _machine(design)
    variables, told = [TIME], []
    for k, axis in enumerate(axes):
        head, drive = head_of(axis, axes), axis.drive
        states = plant_code.state_units(drive)
        others = [name for name in plant_code.signals(drive) if name not in states]
        places = {f"{head}{name}": f"seen.{name}" for name in states}
        places |= {f"{head}{name}": f"signals.{name}" for name in others}
        own, of_axis = axis_of(k, axis, head, drive.initial_state(0.0))
        meaning = drive.meanings.get("command", "what the drive is to do")
        units = drive.units | states
        variables += [
            Variable(f"{head}command", "input", units["command"], meaning),
            load_of(drive, head),
            *of_axis,
            *(reading_of(drive, head, name, units[name]) for name in (*states, *others)),
        ]
        told.append(own | {"readings": places, "command": f"{head}command"})
    what = f"plant {design.plant.name} of the design {design.name}"
    values: Json = {"axes": told, "controllers": [], "quantized": False}
    return _model(f"{code.c_name(design)}_plant", what, scenario, axes, design, variables, values)


def loop(design: Design) -> Model:
    """The machine under its controller, from the reference to where it is.

    Raises:
        UserError: as ``plant``, as ``machine_code.sources``, or a drive is slower than commands.
    """
    scenario, axes = _machine(design)
    check_drives(design, scenario)
    states = started(scenario.machine, scenario.start, scenario.places)
    parts, files = _controllers(design, axes)
    whole = commands_machine(design)
    path = path_variables(design)[:-1] if whole and machine_code.sees_path(design) else []
    variables, told = [TIME, *path], []
    for k, axis in enumerate(axes):
        head, law = head_of(axis, axes), parts[0 if whole else k]
        own, of_axis = axis_of(k, axis, head, states[k])
        sensed, noises = sensing(scenario, axis, head)
        variables += followed(axis.drive, head, law["reads"])
        variables += [load_of(axis.drive, head), *noises, *of_axis, *moments(axis.drive, head)]
        signals = [given(name, k, head) for name in law["reads"]]
        told.append(own | sensed | converter(scenario, axis) | {"told": signals, "controller": law})
    steps = [own["step"] for own in told]
    steps += [x["resolution"] for own in told for x in (*own["encoders"], *own["apart"])]
    values: Json = {"axes": told, "controllers": parts, "quantized": any(steps), "whole": None}
    if whole:
        values["whole"] = {"name": parts[0]["name"], "path": [x.name for x in path]}
    what = f"closed loop of the design {design.name} and its plant {design.plant.name}"
    name = f"{code.c_name(design)}_loop"
    model = _model(name, what, scenario, axes, design, variables, values)
    return model._replace(sources=files | model.sources)


def _machine(design: Design) -> tuple[Scenario, list[Axis]]:
    """What a design was made for, in its first motion, and its axes as they are fed back."""
    every = design.controller.sample_time_s
    found = own_scenario(design, design.name, [f"simulation.sample_time_s={every!r}"])
    scenario = with_converter(found, design).each_motion()[0]
    own = machine(design, scenario)
    if own.machine.forces is not None:
        told = f"there is no C of the plant {own.name}, whose axes act on one another"
        raise UserError(f"design {design.name}: {told}; there is of {plant_code.LISTED}")
    pairs = zip(own.each(), scenario.machine.drives, strict=True)
    axes = [axis._replace(drive=drive) for axis, drive in pairs]
    for axis in axes:
        plant_code.check(axis.drive, design)
    return scenario, axes


def _model(
    name: str,
    what: str,
    scenario: Scenario,
    axes: list[Axis],
    design: Design,
    variables: list[Variable],
    values: Json,
) -> Model:
    """The model with what is the same of a plant and of a loop."""
    names = {plant_code.CODES[axis.drive.name].name: axis.drive for axis in axes}
    sources: dict[str, str] = {}
    for drive in names.values():
        sources |= plant_code.sources(drive, design)
    controllers = values["controllers"]
    files = [f"{own}.h" for own in (*names, *dict.fromkeys(x["name"] for x in controllers))]
    state = [f"{x['name']}_state {x['member']}" for x in controllers]
    for own in values["axes"]:
        state += own.pop("state")
    model = Model(
        "loop" if controllers else "plant",
        name,
        what,
        design.controller.sample_time_s,
        variables,
        sources,
        "fmu/machine.c.j2",
        {
            **values,
            "headers": files,
            "state": state,
            "faulty": STAYS,
            "substeps": scenario.simulation.substeps,
        },
    )
    return model._replace(values=model.values | {"inputs": model.of("input")})


def _controllers(design: Design, axes: list[Axis]) -> tuple[list[Json], dict[str, str]]:
    """The controller of the machine, or that of each axis, and the files of all."""
    if commands_machine(design):
        return [part(design, "controller")], machine_code.sources(design)
    parts: list[Json] = []
    files: dict[str, str] = {}
    each = design.by_axis()
    for k, axis in enumerate(axes):
        own = each.get(axis.name, design)
        files |= machine_code.sources(own)
        parts.append(part(own, f"controller_{k}"))
    return parts, files
