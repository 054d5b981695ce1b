"""What stands between the controller and the machine in an FMU: its sensors and its converter."""

from hfc_design.core.numbers import Json
from hfc_design.core.records import UserError
from hfc_design.files.machine import Axis
from hfc_design.files.scenario import Scenario
from hfc_design.formats import plant_code
from hfc_design.formats.fmu.description import Variable
from hfc_design.simulation.sensors import largest_command, sensors_of


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
