"""Functional mock-up units, for co-simulation by FMI 2.0 and FMI 3.0.

A controller, a plant, and the closed loop of both. What is computed is the C code of ``--to c`` and
that of the simulated machine on LinuxCNC, so there is one control law and one plant.
"""

from hfc_design.files.design import Design
from hfc_design.formats import compiling
from hfc_design.formats.fmu.archive import fmus
from hfc_design.formats.fmu.control import controller
from hfc_design.formats.fmu.machine import loop, plant
from hfc_design.formats.writing import Content, Format


def _controller(design: Design) -> Content:
    return fmus(controller(design), design)


def _plant(design: Design) -> Content:
    return fmus(plant(design), design)


def _loop(design: Design) -> Content:
    return fmus(loop(design), design)


TEXT = "a folder with FMUs for co-simulation by FMI 2.0 and 3.0: "
FORMATS = (
    Format("fmu", f"{TEXT}the controller", _controller, note=compiling.note),
    Format("fmu-plant", f"{TEXT}the plant", _plant, whole=True, note=compiling.note),
    Format("fmu-loop", f"{TEXT}the closed loop", _loop, whole=True, note=compiling.note),
)
