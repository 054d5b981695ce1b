"""An axis of a machine in an FMU: its variables, and what the template reads of it."""

from hfc_design.controllers.controller import units_of
from hfc_design.core.numbers import Json, State
from hfc_design.files.machine import Axis
from hfc_design.formats import plant_code
from hfc_design.formats.fmu.description import LEAST, Variable
from plants import Drive

#: Of which the sign is tried that a parameter may have.
TINY = 1e-9


def head_of(axis: Axis, axes: list[Axis]) -> str:
    """What the names of an axis' variables begin with; nothing where there is one."""
    return f"{axis.name}." if len(axes) > 1 else ""


def axis_of(k: int, axis: Axis, head: str, start: State) -> tuple[Json, list[Variable]]:
    """What the template reads of an axis, and its parameters and states."""
    drive, own = axis.drive, plant_code.CODES[axis.drive.name].name
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
        "carried": [],
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
    told = {
        "reference": "where the axis is to be",
        "reference_rate": "how fast it is to be",
        "reference_acceleration": "how fast that is to change",
    }
    if "reference_acceleration" not in reads:
        del told["reference_acceleration"]
    return [Variable(f"{head}{x}", "input", units[x], what) for x, what in told.items()]


def moments(drive: Drive, head: str) -> list[Variable]:
    """What a loop tells of the sample that it has just done."""
    what = "that acted on the drive in the sample before"
    error = "that the control saw at the start of the sample before"
    return [
        Variable(f"{head}command", "output", drive.units["command"], what, discrete=True),
        Variable(f"{head}error", "output", drive.units["error"], error, discrete=True),
    ]


def given(name: str, k: int, head: str) -> Json:
    """Where a signal that a controller reads comes from: a place in C, or a variable."""
    if name in ("error", "error_rate", "reference"):
        return {"place": f"told_{k}.{name}", "variable": None}
    if name.startswith("reference_"):
        return {"place": "", "variable": f"{head}{name}"}
    return {"place": f"told_{k}.signals.{name}", "variable": None}


def _words(name: str) -> str:
    return name.replace("_", " ")
