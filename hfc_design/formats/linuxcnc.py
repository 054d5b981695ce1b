"""A component of LinuxCNC's HAL, the files that wire it, and a simulated machine to close the loop.

The component includes the C code of ``--to c``, so there is one control law.
"""

import hashlib
from pathlib import Path
from typing import Any

from hfc_design.controllers.rules import identifier
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.machine import PlantSettings
from hfc_design.formats import c_source
from hfc_design.formats.format import Format
from hfc_design.formats.linuxcnc_loop import Loop, plant_component, simulated_loop
from hfc_design.formats.writing import comment, facts, rendered, write_folder
from plants import Drive

#: Characters of a component's name: its longest pin, NAME.0.spindle-velocity, has to fit into 47.
LONGEST_NAME = 28
#: Plant -> pin of its component with the position itself, not what an encoder makes of it.
TRUE_POSITION = {"c-axis": "spindle_angle", "feed-drive": "true_position"}


def write(design: Design, path: Path) -> None:
    """Write the folder ``path`` with all that halcompile and halrun need.

    Where the design's scenario cannot run from here, because it names a file of its run folder
    for one, there is no loop on a simulated machine, and README.md says why.

    Raises:
        UserError: the design cannot run on HAL.
    """
    values, files = _values(design), {}
    templates = {f"{values['component']}.comp": "controller.comp.j2"}
    templates |= {name: f"{name}.j2" for name in ("controller.hal", "README.md")}
    loop: Loop | None = None
    try:
        loop = simulated_loop(design)
    except UserError as error:
        values["reason"] = comment([str(error)])[0]
    else:
        templates["loop.hal"] = "loop.hal.j2"
        files[f"{values['plant']}.comp"] = plant_component(design)
        files["reference.txt"] = loop.reference
    values |= {"machine": loop, "axes": list(loop.axes) if loop else [""]}
    for name, template in templates.items():
        files[name] = rendered(f"linuxcnc/{template}", design, **values)
    c_source.write(design, path)
    write_folder(path, files)


def component_name(design: Design) -> str:
    """Name of the component: an identifier that no component of LinuxCNC has."""
    name = f"hfc_{identifier(design.name)}"
    if len(name) <= LONGEST_NAME:
        return name
    digest = hashlib.sha256(design.name.encode()).hexdigest()[:7]
    return f"{name[: LONGEST_NAME - 8]}_{digest}"


def _values(design: Design) -> dict[str, Any]:
    """What every template reads."""
    if design.plant.name not in TRUE_POSITION:
        known = f"{design.plant.name}; there is {', '.join(TRUE_POSITION)}"
        raise UserError(f"design {design.name}: HAL has no component of the plant {known}")
    plant = PlantSettings(**design.plant.model_dump())
    drive = plant.machine.drives[0]
    every = design.controller.sample_time_s
    if not 1e-6 <= every <= 1.0:
        told = f"controller.sample_time_s = {every}: the period of a HAL thread is 1e-6 to 1"
        raise UserError(f"design {design.name}: {told}")
    return _signals(design, drive) | {
        "component": component_name(design),
        "controller": c_source.c_name(design),
        "head": comment(facts(design)),
        "every": every,
        "nanoseconds": round(every * 1e9),
        "adapts": getattr(design.controller, "adaptation", None) is not None,
        "plant": f"hfc_{identifier(drive.name)}",
        "plant_name": drive.name,
        "command_unit": drive.units["command"],
        "load_unit": drive.units["load"],
        "millimetres": drive.millimetres and drive.millimetres(plant.values()[0]),
        "true_position": TRUE_POSITION[drive.name],
    }


def _signals(design: Design, plant: Drive) -> dict[str, Any]:
    """What the controller reads; an error comes in as the two values that it is between."""
    read = c_source.signals(design)
    for name in read:
        if name not in plant.units:
            told = f"reads {name}, which is no signal of the {plant.name}"
            raise UserError(f"design {design.name}: {told}")
    pairs = {"error": ("reference", plant.position)}
    pairs["error_rate"] = ("reference_rate", plant.velocity)
    sources = {name: pairs.get(name, (name,)) for name in read}
    units = plant.units | dict.fromkeys(("reference", plant.position), plant.units["error"])
    units["reference_rate"] = plant.units["error_rate"]
    return {
        "position": plant.position,
        "inputs": {name: " - ".join(f"{pin}_" for pin in pins) for name, pins in sources.items()},
        "pins": {pin: units[pin] for pins in sources.values() for pin in pins},
        "meanings": {
            "reference": "where the axis should be",
            "reference_rate": "how fast it should be",
            plant.position: "where it is",
            plant.velocity: "how fast it is",
        },
    }


FORMATS = (Format("linuxcnc", "a folder with a HAL component and a simulated machine", write),)
