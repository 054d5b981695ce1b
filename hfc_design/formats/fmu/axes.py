"""Models of a design's machine for FMUs: the plant alone, or the closed loop with its controller.

They contain the variables of each axis and, in a loop, its sensors and its converter.
"""

from hfc_design.controllers.connected import SWITCHES
from hfc_design.controllers.controller import FOLLOWED, units_of
from hfc_design.core.numbers import Json, State
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import machine, own_scenario, with_converter
from hfc_design.files.machine import Axis, measured_apart
from hfc_design.files.motions import started
from hfc_design.files.scenario import Scenario
from hfc_design.formats import code, plant_code
from hfc_design.formats.connection import connect
from hfc_design.formats.fmu.control import commands_machine, part, path_variables
from hfc_design.formats.fmu.description import LEAST, TIME, Model, Variable
from plants import Drive

#: Output of a loop -> description, with the sample to which the value belongs.
MOMENTS = {
    "command": "that acted on the drive in the sample before",
    "error": "at the start of the sample before, not rounded to sensors.encoder_resolution",
}
#: Keys of ``limits`` that the code of a connected controller applies.
APPLIED = ("command", "command_rate", "resolution")
#: Magnitude of the values that are tried to find the allowed sign of a parameter.
TINY = 1e-9


def plant(design: Design) -> Model:
    """Return the model of a design's machine alone: inputs are commands and loads.

    Raises:
        UserError: no C code can be made of the machine, or the design's scenario cannot run here.
    """
    scenario, axes = _machine(design)
    variables, parts = [TIME], []
    for k, axis in enumerate(axes):
        head, drive = _head(axis, axes), axis.drive
        part, of_axis = _axis(k, axis, head, drive.initial_state(0.0))
        states = plant_code.state_units(drive)
        others = [name for name in plant_code.signals(drive) if name not in states]
        places = dict.fromkeys(states, "seen") | dict.fromkeys(others, "signals")
        units = drive.units | states
        meaning = drive.meanings.get("command", "what the drive is to do")
        variables.append(Variable(f"{head}command", "input", units["command"], meaning))
        variables += [_load(drive, head), *of_axis]
        for name in places:
            what = drive.meanings.get(name, f"{_words(name)}, as the drive's sensors read it")
            variables.append(Variable(f"{head}{name}", "output", units[name], what))
        readings = {f"{head}{name}": f"{record}.{name}" for name, record in places.items()}
        parts.append(part | {"readings": readings, "command": f"{head}command"})
    what = f"plant {design.plant.name} of the design {design.name}"
    return _model("plant", what, scenario, axes, design, variables, {"axes": parts})


def loop(design: Design) -> Model:
    """Return the model of the closed loop: inputs are references, loads and sensor noise.

    Raises:
        UserError: as for ``plant`` and ``code.sources``; or the delay or lag is not supported.
    """
    scenario, axes = _machine(design)
    states = started(scenario.machine, scenario.start, scenario.places)
    controllers, files = _controllers(design, scenario, axes)
    whole = commands_machine(design)
    path = path_variables(design)[:3]
    variables, parts = [TIME, *path], []
    for k, axis in enumerate(axes):
        head, drive, law = _head(axis, axes), axis.drive, controllers[0 if whole else k]
        part, of_axis = _axis(k, axis, head, states[k])
        sensed, noises = _sensing(scenario, axis, head, law["reads"])
        units = units_of(drive.units)
        followed = [x for x in FOLLOWED if x in law["reads"] or x == "reference"]
        variables += [Variable(f"{head}{x}", "input", units[x], FOLLOWED[x]) for x in followed]
        variables += [_load(drive, head), *noises, *of_axis]
        for name, what in MOMENTS.items():
            one = Variable(f"{head}{name}", "output", drive.units[name], what, discrete=True)
            variables.append(one)
        moments = [f"{head}{name}" for name in MOMENTS]
        parts.append(part | sensed | {"controller": law, "moments": moments})
    values: Json = {"axes": parts, "controllers": controllers}
    if whole:
        values["whole"] = {"name": controllers[0]["name"], "path": [x.name for x in path]}
    what = f"closed loop of the design {design.name} and its plant {design.plant.name}"
    model = _model("loop", what, scenario, axes, design, variables, values)
    return model._replace(sources=files | model.sources)


def _machine(design: Design) -> tuple[Scenario, list[Axis]]:
    """Return a design's scenario with its first motion only, and the axes of its machine."""
    every = design.controller.sample_time_s
    loop_scenario = own_scenario(design, design.name, [f"simulation.sample_time_s={every!r}"])
    scenario = with_converter(loop_scenario, design).each_motion()[0]
    pairs = zip(machine(design, scenario).each(), scenario.machine.drives, strict=True)
    axes = [axis._replace(drive=drive) for axis, drive in pairs]
    for axis in axes:
        plant_code.check(axis.drive, design)
    return scenario, axes


def _head(axis: Axis, axes: list[Axis]) -> str:
    """Return the prefix of an axis' variable names; "" for a single axis."""
    return f"{axis.name}." if len(axes) > 1 else ""


def _words(name: str) -> str:
    return name.replace("_", " ")


def _load(drive: Drive, head: str) -> Variable:
    what = "against positive motion, held for a sample"
    return Variable(f"{head}load", "input", drive.units["load"], what)


def _axis(k: int, axis: Axis, head: str, start: State) -> tuple[Json, list[Variable]]:
    """Return the template values of an axis, and the variables of its parameters and states."""
    drive, units = axis.drive, plant_code.state_units(axis.drive)
    parameters = {name: f"{head}{name}" for name in axis.parameters._fields}
    starts = {f"{head}start.{name}": name for name in units}
    states = {f"{head}state.{name}": name for name in units}
    variables = [_parameter(drive, x, name, axis) for x, name in parameters.items()]
    for name, field in starts.items():
        value, what = float(getattr(start, field)), f"{_words(field)} before the first sample"
        variables.append(Variable(name, "parameter", units[field], what, value, fixed=True))
    for name, field in states.items():
        variables.append(Variable(name, "output", units[field], f"{_words(field)} as it is"))
    part: Json = {"k": k, "plant": plant_code.name_of(drive), "load": f"{head}load"}
    part |= {"parameters": [*parameters.values()], "states": states, "starts": starts}
    return part | {"delayed": False, "moments": [], "readings": {}}, variables


def _parameter(drive: Drive, key: str, name: str, axis: Axis) -> Variable:
    """Return the variable of a plant parameter, bounded by 0 if the drive refuses a sign."""
    value = float(getattr(axis.parameters, key))
    unit, what = drive.parameter_units.get(key, ""), f"{_words(key)} of the {drive.name}"
    variable = Variable(name, "parameter", unit, what, value)
    least = LEAST if drive.fault({key: 0.0}) else 0.0
    if value >= 0.0 and drive.fault({key: -TINY}):
        return variable._replace(lowest=least)
    if value <= 0.0 and drive.fault({key: TINY}):
        return variable._replace(highest=0.0 - least)
    return variable


def _sensing(
    scenario: Scenario, axis: Axis, head: str, reads: list[str]
) -> tuple[Json, list[Variable]]:
    """Return template values for the inputs ``reads`` of an axis' controller, and noise variables.

    Raises:
        UserError: ``delay_samples`` is neither 0 nor 1, or ``lag_s`` is set.
    """
    drive, sensors = axis.drive, scenario.sensors.of(axis.name)
    limits = scenario.limits.of(axis.name)
    left = limits.other_than(*APPLIED, *(["delay_samples"] if limits.delay_samples == 1.0 else []))
    for key, value in left.items():
        rule = "0 or 1" if key == "limits.delay_samples" else "left out"
        message = f"{key} = {value:g}: must be {rule} in an FMU of a machine"
        raise UserError(f"scenario {scenario.name}: {message}")
    units = drive.units | plant_code.state_units(drive)
    deviations = dict.fromkeys(drive.encoders, sensors.noise)
    deviations |= {name: reading.noise for name, reading in sensors.readings.items()}
    noises = {}
    for name, deviation in deviations.items():
        if deviation:
            what = f"added to what is measured, of standard deviation {deviation:g} in the scenario"
            noises[name] = Variable(f"{head}noise.{name}", "input", units[name], what)

    def given(name: str) -> Json:
        """Return an input as a C expression and a variable that is added to it; "" for none."""
        if name in SWITCHES:
            return {"place": "1.0" if name == "enable" else "0.0", "variable": ""}
        if name in FOLLOWED:
            return {"place": "", "variable": f"{head}{name}"}
        place = f"{'signals' if name in measured_apart(drive) else 'seen'}.{name}"
        return {"place": place, "variable": noises[name].name if name in noises else ""}

    values: Json = {"inputs": [given(name) for name in reads], "turn": sensors.turn}
    values |= {"position": given(drive.seen[0]), "reference": f"{head}reference"}
    return values | {"delayed": limits.delay_samples > 0}, [*noises.values()]


def _model(
    part: str,
    what: str,
    scenario: Scenario,
    axes: list[Axis],
    design: Design,
    variables: list[Variable],
    values: Json,
) -> Model:
    """Return the model of a plant or a loop (``part``) from its variables and template values."""
    sources: dict[str, str] = {}
    for drive in {plant_code.name_of(axis.drive): axis.drive for axis in axes}.values():
        sources |= plant_code.sources(drive, design)
    coupled = ""  # name of the common step function if axes are coupled
    if scenario.machine.forces is not None:
        both = plant_code.coupled(scenario.machine, design)
        coupled = next(file.removesuffix(".h") for file in both if file.endswith(".h"))
        sources |= both
    name, substeps = f"{code.c_name(design)}_{part}", scenario.simulation.substeps
    common: Json = {"whole": None, "controllers": [], "coupled": coupled, "substeps": substeps}
    common["faulty"] = "the machine and its control stay as they were"
    return Model(part, name, what, variables, sources, common | values)


def _controllers(
    design: Design, scenario: Scenario, axes: list[Axis]
) -> tuple[list[Json], dict[str, str]]:
    """Return template values of the machine's controller, or of one per axis, and all C files."""
    if commands_machine(design):
        connected = connect(design, scenario)
        return [part(connected, "controller")], code.sources(connected)
    parts: list[Json] = []
    files: dict[str, str] = {}
    each = design.by_axis()
    for k, axis in enumerate(axes):
        connected = each.get(axis.name, design)
        if axis.name not in each and len(axes) > 1:  # sensors of axes may differ
            connected = connected.model_copy(update={"name": f"{design.name}-{axis.name}"})
            connected._axis = axis.name
        connected = connect(connected, scenario)
        files |= code.sources(connected)
        parts.append(part(connected, f"controller_{k}"))
    return parts, files
