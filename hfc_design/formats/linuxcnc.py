"""LinuxCNC export: a HAL component, the files that wire it, and a simulated machine.

The component includes the C code of ``--to c``, so that the control law is written only once.
"""

import hashlib
import re

import numpy as np

from hfc_design.controllers.connected import SWITCHES
from hfc_design.controllers.controller import units_of
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Json
from hfc_design.core.records import UserError, harmless, option
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import check_drives, machine, own_scenario
from hfc_design.files.machine import ALL_PLANTS, PlantSettings
from hfc_design.formats import code, plant_code, saving
from hfc_design.formats.deployment import folder as deployment
from hfc_design.formats.deployment.signal_conditioning import scene
from hfc_design.formats.writing import Content, Format, meanings_of, rendered
from plants import Drive
from plants.drive import fed_back

#: Largest number of characters of a name in HAL.
LONGEST = 47
#: Further input of a component whose controller feeds the acceleration forward.
ACCELERATION = "reference_acceleration"


def components(design: Design) -> dict[str, Content]:
    """Return a folder with everything that halcompile and halrun need.

    If the design names no scenario and the default one of its plant does not fit, the folder has no
    loop on a simulated machine, and README.md says why.

    Raises:
        UserError: the design cannot run on HAL, or the scenario that it names cannot be run here,
            for example because a file is missing.
    """
    to_c, bare = option("to", "c"), option("bare", True)
    if design.kind.controller and not design.kind.axis_records:
        message = f"it commands a whole machine, but a component has one axis; use {to_c}"
        raise UserError(f"design {design.name} is of kind {design.kind.name}: {message}")
    values, sources = _values(design), code.sources(design)
    files: dict[str, Content] = {**sources}
    templates = {f"{values['component']}.comp": "controller.comp"}
    templates |= {name: name for name in ("controller.hal", "README.md")}
    try:
        loop, files["reference.txt"] = _simulated_loop(design)
    except UserError as error:
        if "scenario" in design.provenance:
            raise UserError(f"{error.message}; {to_c} with {bare} exports only the law") from None
        reason = re.sub("[<>`]", "_", harmless(error.typed))
        values |= {"machine": None, "axes": [""], "reason": reason}
    else:
        values |= {"machine": loop, "axes": list(loop["axes"])}
        templates |= {"loop.hal": "loop.hal", f"{values['plant']}.comp": "plant.comp"}
        files |= plant_code.sources(values["drive"], design)
    values["deployment"] = filled = deployment.values(design, sources)
    for name, template in templates.items():
        files[name] = rendered(f"linuxcnc/{template}.j2", design, **values)
    return files | deployment.checked(design, filled)


def component_name(design: Design) -> str:
    """Return the name of the component: hfc_ and the design's name, shortened if too long."""
    name = f"hfc_{identifier(design.name)}"
    longest_pin = ACCELERATION if ACCELERATION in code.signals(design) else "spindle_velocity"
    longest = LONGEST - len(f".0.{longest_pin}")
    if len(name) <= longest:
        return name
    digest = hashlib.sha256(design.name.encode()).hexdigest()[:7]
    return f"{name[: longest - 8]}_{digest}"


def _values(design: Design) -> Json:
    """Return the values for all templates."""
    if design.plant.name not in ALL_PLANTS.names():
        raise UserError(f"design {design.name}: unknown plant {design.plant.name}")
    plant = PlantSettings(**design.plant.model_dump())
    axes = [axis for axis in plant.each() if design.axis in ("", axis.name)]
    axis, *others = axes or plant.each()
    if any(other.drive is not axis.drive for other in others):
        message = f"the plant must be a drive of one axis (got {design.plant.name})"
        raise UserError(f"design {design.name}: {message}")
    plant_code.check(axis.drive, design)
    drive = _followed(design, axis.drive)
    every = design.controller.sample_time_s
    if not 1e-6 <= every <= 1.0:
        allowed = "must be 1e-6 to 1, the period of a HAL thread"
        raise UserError(f"design {design.name}: controller.sample_time_s = {every}: {allowed}")
    values: Json = {"component": component_name(design), "controller": code.c_name(design)}
    values |= {"nanoseconds": round(every * 1e9), "saved": (saved := saving.learning(design))}
    values["digits"] = len(str(saved.learnt - 1)) if saved else 0
    values["turn"] = max((one.sensors.turn for one in scene(design, ()).each), default=0.0)
    values |= {"plant": f"hfc_{identifier(drive.name)}", "plant_code": plant_code.name_of(drive)}
    values |= {"drive": drive, "millimetres": axis.length, "counts": plant_code.counts(drive)}
    values["coefficients"] = plant_code.coefficients(drive.coefficients(drive.parameters()))
    values["states"] = states = plant_code.state_units(drive)
    values["told"] = [name for name in plant_code.signals(drive) if name not in states]
    return values | _signals(design, drive)


def _followed(design: Design, drive: Drive) -> Drive:
    """Return the drive with the encoder of the design's scenario; UserError: axes have others."""
    encoders = sorted({one.position for one in scene(design, ()).each} or {drive.position})
    if len(encoders) > 1:
        message = f"sensors.feedback must be one encoder for all axes (got {', '.join(encoders)})"
        each = "with limits.axes each axis gets a component"
        raise UserError(f"design {design.name}: {message}; {each}")
    return drive if encoders == [drive.position] else fed_back(drive, encoders[0])


def _signals(design: Design, plant: Drive) -> Json:
    """Return template values of the inputs; an error is the difference of two pins."""
    read, units = code.signals(design), units_of(plant.units)
    if connection := design.connected:
        switches = [name for name in read if name in SWITCHES and name != "enable"]
        return {
            "position": plant.seen[0],
            "switches": {name: read[name] for name in switches},
            "inputs": {name: f"{name}_" for name in read},
            "pins": {name: unit for name, unit in read.items() if name not in SWITCHES},
            "meanings": connection.meanings,
        }
    for name in read:
        if name not in units:
            message = f"reads {name}, which is not a signal of the {plant.name}"
            raise UserError(f"design {design.name}: {message}")
    position, velocity = plant.seen
    pairs = {"error": ("reference", position), "error_rate": ("reference_rate", velocity)}
    sources = {name: pairs.get(name, (name,)) for name in read}
    units[position] = units["error"]
    return {
        "position": position,
        "switches": None,
        "inputs": {name: " - ".join(f"{pin}_" for pin in pins) for name, pins in sources.items()},
        "pins": {pin: units[pin] for pins in sources.values() for pin in pins},
        "meanings": meanings_of(plant)
        | {
            "reference": "where the axis should be",
            "reference_rate": "how fast it should be",
            ACCELERATION: "how fast that should change",
            plant.position: "where it is",
            plant.velocity: "how fast it is",
        },
    }


def _simulated_loop(design: Design) -> tuple[Json, str]:
    """Return template values of the loop on a simulated machine, and the text of reference.txt.

    A row is a sample: reference, its rate, load and, if read, reference acceleration of each axis.

    Raises:
        UserError: the scenario cannot be run here.
    """
    every = design.controller.sample_time_s
    scenario = own_scenario(design, design.name, [f"simulation.sample_time_s={every!r}"])
    plant = machine(design, scenario)
    if not design.connected:
        check_drives(design, scenario)
    ahead = ACCELERATION in code.signals(design)
    columns, axes = [], {}  # prefix of names in HAL -> parameters and limit
    for axis, axis_samples in zip(plant.each(), scenario.samples().axes, strict=True):
        if design.axis not in ("", axis.name):
            continue  # that axis has its own controller and folder
        columns += [axis_samples.reference, axis_samples.reference_rate, _mean(axis_samples.loads)]
        if ahead:
            columns.append(np.asarray(axis_samples.reference_acceleration))
        fixed = plant_code.coefficients(axis.drive.coefficients(axis.parameters))
        name = f"{identifier(axis.name)}-" if plant.axes else ""
        axes[name] = {"set": fixed, "limit": scenario.limits.of(axis.name).command}
        _check_length(axis.name, fixed, ahead)
    table = np.stack(columns, axis=1)
    loop: Json = {"scenario": scenario.name, "rows": len(table)}
    loop |= {"axes": axes, "substeps": scenario.simulation.substeps}
    return loop, "".join(" ".join(map(repr, row)) + "\n" for row in table.tolist())


def _check_length(axis: str, coefficients: Json, ahead: bool) -> None:
    """Check the lengths of an axis' names in HAL; UserError: one is too long."""
    behind = [f"machine.{name}" for name in coefficients]
    behind += [f"controller.{ACCELERATION}"] if ahead else []
    longest = LONGEST - max(len(f"-{name}") for name in behind)
    if len(axis) > longest:
        allowed = f"must have at most {longest} characters for the names of HAL"
        raise UserError(f"plant.axes.{axis}: {allowed}")


def _mean(loads: np.ndarray) -> np.ndarray:
    """Return the load (steps,) of each sample: Simpson's mean of loads (2 substeps + 1, steps)."""
    weights = np.full(len(loads), 2.0)
    weights[1::2] = 4.0
    weights[[0, -1]] = 1.0
    return np.asarray(weights @ loads / weights.sum())


HAL = "a folder with a HAL component and a simulated machine"
FORMATS = (Format("linuxcnc", HAL, components, companions=deployment.of_axes, connects=True),)
