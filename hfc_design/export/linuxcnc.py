"""A component of LinuxCNC's HAL, the files that wire it, and a simulated machine to close the loop.

The component includes the C code of ``--to c``: there is one control law.
"""

import hashlib
import re
from pathlib import Path
from typing import Any

from hfc_design.export import c_source
from hfc_design.export.linuxcnc_loop import Loop, plant_component, simulated_loop
from hfc_design.export.templates import rendered, write_folder
from hfc_design.export.units import facts, identifier
from hfc_design.records import UserError
from hfc_design.rulebase import Design
from plants import PLANTS

#: Characters of a component's name: its longest pin, .N.deflection-rate, has to fit into 47.
LONGEST_NAME = 28
#: Plant -> pin of its component with the position itself, not what an encoder makes of it.
TRUE_POSITION = {"c-axis": "spindle_angle", "feed-drive": "true_position"}


def write(design: Design, path: Path) -> None:
    """Write the folder ``path`` with all that halcompile and halrun need.

    Where the design's scenario cannot run from here, because it names a file of its run folder
    for one, there is no loop on a simulated machine, and README.md says why.

    Raises:
        UserError: the design cannot run on HAL.
        RunError: the folder cannot be written.
    """
    loop: Loop | None = None
    reason = ""
    try:
        loop = simulated_loop(design)
    except UserError as error:
        reason = str(error)
    values = _values(design) | {"machine": loop, "axes": list(loop.axes) if loop else [""], "reason": _plain(reason)}
    texts = {
        f"{values['component']}.comp": "controller.comp.j2",
        "controller.hal": "controller.hal.j2",
        "README.md": "README.md.j2",
    }
    if loop:
        texts["loop.hal"] = "loop.hal.j2"
    files = {
        name: rendered(f"linuxcnc/{template}", design, **values)
        for name, template in texts.items()
    }
    if loop:
        files[f"{values['plant']}.comp"] = plant_component(design)
        files["reference.txt"] = loop.reference
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
    plant = PLANTS[design.plant.name]
    every = design.controller.sample_time_s
    if not 1e-6 <= every <= 1.0:
        raise UserError(
            f"design {design.name}: controller.sample_time_s = {every}: the period of a HAL thread "
            "is 1e-6 to 1"
        )
    read = c_source.signals(design)
    units = plant.units | {plant.position: plant.units["error"]}
    unknown = [name for name in read if name not in units]
    if unknown:
        raise UserError(
            f"design {design.name}: reads {unknown[0]}, which is no signal of the {plant.name}"
        )
    # An error comes in as the two values that it is the difference of.
    pairs = {
        "error": ("reference", plant.position),
        "error_rate": ("reference_rate", plant.velocity),
    }
    needed = [pin for name in read for pin in pairs.get(name, (name,))]
    units |= {"reference": units["error"], "reference_rate": units["error_rate"]}
    return {
        "component": component_name(design),
        "controller": c_source.c_name(design),
        "design_plant": plant.name,
        "adapts": getattr(design.controller, "adaptation", None) is not None,
        "meanings": {
            "reference": "where the axis should be",
            "reference_rate": "how fast it should be",
            plant.position: "where it is",
            plant.velocity: "how fast it is",
        },
        "plant": f"hfc_{identifier(plant.name)}",
        "every": every,
        "head": [_plain(line) for line in facts(design)],
        "nanoseconds": round(every * 1e9),
        "command_unit": plant.units["command"],
        "load_unit": plant.units["load"],
        "position": plant.position,
        "true_position": TRUE_POSITION[plant.name],
        "velocity": plant.velocity,
        "pins": {pin: units[pin] for pin in needed},
        "inputs": {
            name: " - ".join(f"{pin}_" for pin in pairs.get(name, (name,))) for name in read
        },
    }


def _plain(line: str) -> str:
    """A line without anything that a comment or a string of some language could end with."""
    return re.sub(r"[^\w .,:()+-]", "_", line, flags=re.ASCII)
