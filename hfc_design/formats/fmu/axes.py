"""An axis of a machine in an FMU: its variables, its sensors, its converter.

And the plant of a design as an FMU, alone or under its controller.
"""

from hfc_design.controllers.connected import SWITCHES
from hfc_design.controllers.controller import FOLLOWED, units_of
from hfc_design.core.numbers import Json, State
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.machine import Axis, measured_apart
from hfc_design.files.motions import started
from hfc_design.files.pairing import machine, own_scenario, with_converter
from hfc_design.files.scenario import Scenario
from hfc_design.formats import code, plant_code
from hfc_design.formats.connection import connect
from hfc_design.formats.fmu.control import commands_machine, part, path_variables
from hfc_design.formats.fmu.description import LEAST, TIME, Model, Variable
from plants import Drive

#: Of which the sign is tried that a parameter may have.
TINY = 1e-9


def head_of(axis: Axis, axes: list[Axis]) -> str:
    """What the names of an axis' variables begin with; nothing where there is one."""
    return f"{axis.name}." if len(axes) > 1 else ""


def axis_of(k: int, axis: Axis, head: str, start: State) -> tuple[Json, list[Variable]]:
    """What the template reads of an axis, and its parameters and states."""
    drive, own = axis.drive, plant_code.name_of(axis.drive)
    units = plant_code.state_units(drive)
    parameters = {name: f"{head}{name}" for name in axis.parameters._fields}
    states = {f"{head}state.{name}": name for name in units}
    starts = {f"{head}start.{name}": name for name in units}
    told: Json = {
        "k": k,
        "plant": own,
        "parameters": list(parameters.values()),
        "states": states,
        "starts": starts,
        "load": f"{head}load",
        "state": [f"{own}_state axis_{k}"],
        "delayed": False,
        "moments": [],
        "readings": {},
    }
    variables = [_parameter(drive, x, name, axis) for x, name in parameters.items()]
    for name, field in starts.items():
        begun, unit = float(getattr(start, field)), units[field]
        what = f"{_words(field)} before the first sample"
        variables.append(Variable(name, "parameter", unit, what, begun, fixed=True))
    for name, field in states.items():
        variables.append(Variable(name, "output", units[field], f"{_words(field)} as it is"))
    return told, variables


def _parameter(drive: Drive, key: str, name: str, axis: Axis) -> Variable:
    """A parameter of the plant, which may be negative or positive where the drive says so."""
    value = float(getattr(axis.parameters, key))
    unit = drive.parameter_units.get(key, "")
    found = Variable(name, "parameter", unit, f"{_words(key)} of the {drive.name}", value)
    least = LEAST if drive.fault({key: 0.0}) else 0.0
    if value >= 0.0 and drive.fault({key: -TINY}):
        return found._replace(lowest=least)
    if value <= 0.0 and drive.fault({key: TINY}):
        return found._replace(highest=0.0 - least)
    return found


def load_of(drive: Drive, head: str) -> Variable:
    """The load of an axis, an input."""
    what = "against positive motion, held for a sample"
    return Variable(f"{head}load", "input", drive.units["load"], what)


def reading_of(drive: Drive, head: str, name: str, unit: str) -> Variable:
    """What a drive tells of itself, an output."""
    what = drive.meanings.get(name, f"{_words(name)}, as the drive's sensors read it")
    return Variable(f"{head}{name}", "output", unit, what)


def followed(drive: Drive, head: str, reads: list[str]) -> list[Variable]:
    """What a loop follows."""
    units = units_of(drive.units)
    told = {name: what for name, what in FOLLOWED.items() if name in reads or name == "reference"}
    return [Variable(f"{head}{x}", "input", units[x], what) for x, what in told.items()]


def moments(drive: Drive, head: str) -> list[Variable]:
    """What a loop tells of the sample that it has just done."""
    what = "that acted on the drive in the sample before"
    error = "by the machine's own scale at the start of the sample before"
    return [
        Variable(f"{head}command", "output", drive.units["command"], what, discrete=True),
        Variable(f"{head}error", "output", drive.units["error"], error, discrete=True),
    ]


def _words(name: str) -> str:
    return name.replace("_", " ")


def sensing(
    scenario: Scenario, axis: Axis, head: str, reads: list[str]
) -> tuple[Json, list[Variable]]:
    """What the template gives a controller that ``reads`` an axis, and the noise of its sensors.

    Raises:
        UserError: the converter delays by a part of a sample, or has a lag.
    """
    wanted, limits, drive = (
        scenario.sensors.of(axis.name),
        scenario.limits.of(axis.name),
        axis.drive,
    )
    if limits.delay_samples not in (0.0, 1.0) or limits.lag_s:
        raise UserError(
            f"scenario {scenario.name}: limits.delay_samples must be 0 or 1 and limits.lag_s 0 in "
            f"an FMU of a machine (got {limits.delay_samples:g} and {limits.lag_s:g})"
        )
    units = drive.units | plant_code.state_units(drive)
    deviations = dict.fromkeys(drive.encoders, wanted.noise)
    deviations |= {name: own.noise for name, own in wanted.readings.items()}
    found = {
        name: Variable(
            f"{head}noise.{name}",
            "input",
            units[name],
            f"added to what is measured, of standard deviation {off:g} in the scenario",
        )
        for name, off in deviations.items()
        if off
    }

    def given(name: str) -> Json:
        """The place in C, and the variable that is added to that."""
        if name in SWITCHES:
            return {"place": "1.0" if name == "enable" else "0.0", "variable": ""}
        if name in FOLLOWED:
            return {"place": "", "variable": f"{head}{name}"}
        place = f"{'signals' if name in measured_apart(drive) else 'seen'}.{name}"
        return {"place": place, "variable": found[name].name if name in found else ""}

    values = {
        "inputs": [given(name) for name in reads],
        "delayed": limits.delay_samples > 0,
        "position": given(drive.seen[0]),
        "reference": f"{head}reference",
        "turn": wanted.turn,
        "moments": [f"{head}command", f"{head}error"],
    }
    return values, [*found.values()]


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
    values: Json = {"axes": told, "controllers": []}
    return _model(f"{code.c_name(design)}_plant", what, scenario, axes, design, variables, values)


def loop(design: Design) -> Model:
    """The machine under its controller, from the reference to where it is.

    Raises:
        UserError: as ``plant``, or as ``code.sources``.
    """
    scenario, axes = _machine(design)
    states = started(scenario.machine, scenario.start, scenario.places)
    parts, files = _controllers(design, scenario, axes)
    whole = commands_machine(design)
    path = path_variables(design)[:3]
    variables, told = [TIME, *path], []
    for k, axis in enumerate(axes):
        head, law = head_of(axis, axes), parts[0 if whole else k]
        own, of_axis = axis_of(k, axis, head, states[k])
        sensed, noises = sensing(scenario, axis, head, law["reads"])
        variables += followed(axis.drive, head, law["reads"])
        variables += [load_of(axis.drive, head), *noises, *of_axis, *moments(axis.drive, head)]
        told.append(own | sensed | {"controller": law})
    values: Json = {"axes": told, "controllers": parts, "whole": None}
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
    names = {plant_code.name_of(axis.drive): axis.drive for axis in axes}
    sources: dict[str, str] = {}
    for drive in names.values():
        sources |= plant_code.sources(drive, design)
    coupled: list[str] = []
    if scenario.machine.forces is not None:
        both = plant_code.coupled(scenario.machine, design)
        coupled = [file.removesuffix(".h") for file in both if file.endswith(".h")]
        sources |= both
    controllers = values["controllers"]
    files = [
        f"{own}.h" for own in (*names, *coupled, *dict.fromkeys(x["name"] for x in controllers))
    ]
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
            "coupled": coupled[0] if coupled else "",
        },
    )
    return model._replace(values=model.values | {"inputs": model.of("input")})


def _controllers(
    design: Design, scenario: Scenario, axes: list[Axis]
) -> tuple[list[Json], dict[str, str]]:
    """The controller of the machine, or that of each axis, and the files of all."""
    if commands_machine(design):
        own = connect(design, scenario)
        return [part(own, "controller")], code.sources(own)
    parts: list[Json] = []
    files: dict[str, str] = {}
    each = design.by_axis()
    for k, axis in enumerate(axes):
        own = each.get(axis.name, design)
        if axis.name not in each and len(axes) > 1:  # whose sensors may be others
            own = own.model_copy(update={"name": f"{design.name}-{axis.name}"})
            own._axis = axis.name
        own = connect(own, scenario)
        files |= code.sources(own)
        parts.append(part(own, f"controller_{k}"))
    return parts, files
