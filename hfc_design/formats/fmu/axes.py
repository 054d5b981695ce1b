"""An axis of a machine in an FMU: its variables, its sensors, its converter."""

from hfc_design.controllers.controller import units_of
from hfc_design.core.numbers import Json, State
from hfc_design.core.records import UserError
from hfc_design.files.machine import Axis
from hfc_design.files.scenario import Scenario
from hfc_design.formats import plant_code
from hfc_design.formats.fmu.description import LEAST, Variable
from hfc_design.simulation.sensors import largest_command, sensors_of
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


def sensing(scenario: Scenario, axis: Axis, head: str) -> tuple[Json, list[Variable]]:
    """What the template reads of the sensors of an axis, and their noise, where they have some."""
    wanted, drive = scenario.sensors.of(axis.name), axis.drive
    sensors = sensors_of(wanted, scenario.simulation.sample_time_s)
    units = drive.units | plant_code.state_units(drive)
    found: list[Variable] = []

    def noise(name: str, deviation: float) -> str:
        if not deviation:
            return ""
        what = f"added to what is measured, of standard deviation {deviation:g} in the scenario"
        found.append(Variable(f"{head}noise.{name}", "input", units[name], what))
        return found[-1].name

    encoders = [
        {
            "angle": angle,
            "velocity": velocity,
            "resolution": wanted.encoder_resolution,
            "noise": noise(angle, wanted.noise),
        }
        for angle, velocity in (drive.encoders.items() if sensors else ())
    ]
    apart = [
        {"name": name, "resolution": own.resolution, "noise": noise(name, own.noise)}
        for name, own in wanted.readings.items()
    ]
    carried = encoders if wanted.velocity != "tachometer" else []
    values = {
        "encoders": encoders,
        "carried": carried,
        "apart": apart,
        "velocity_of": wanted.velocity,
        "samples": wanted.difference_samples,
        "observer": sensors.observer if sensors else (0.0, 0.0),
        "seen": drive.seen,
        "reference": f"{head}reference",
        "reference_rate": f"{head}reference_rate",
        "moments": [f"{head}command", f"{head}error"],
    }
    return values, found


def converter(scenario: Scenario, axis: Axis) -> Json:
    """What the template reads of the converter of an axis.

    Raises:
        UserError: its delay is none of a whole sample, or it has a lag.
    """
    limits = scenario.limits.of(axis.name)
    if limits.delay_samples not in (0.0, 1.0) or limits.lag_s:
        raise UserError(
            f"scenario {scenario.name}: limits.delay_samples must be 0 or 1 and limits.lag_s 0 in "
            f"an FMU of a machine (got {limits.delay_samples:g} and {limits.lag_s:g})"
        )
    return {
        "limit": largest_command(limits),
        "step": limits.resolution,
        "delayed": limits.delay_samples > 0,
    }
