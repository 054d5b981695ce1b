"""Functional mock-up units (FMUs) for co-simulation by FMI 2.0 and FMI 3.0.

An FMU contains a controller, a plant, or the closed loop of both. The control law is the C code of
``--to c``, the plant that of the simulated machine on LinuxCNC, so that no code exists twice.
"""

from collections.abc import Callable
from typing import Any

from hfc_design.files.design import Design
from hfc_design.formats import compiling
from hfc_design.formats.fmu.archive import fmus
from hfc_design.formats.fmu.axes import loop, plant
from hfc_design.formats.fmu.control import controller
from hfc_design.formats.fmu.description import Model
from hfc_design.formats.writing import Content, Format


def _format(name: str, what: str, model: Callable[[Design], Model], **more: Any) -> Format:
    def content(design: Design) -> Content:
        return fmus(model(design), design)

    text = f"a folder with FMUs for co-simulation by FMI 2.0 and 3.0: {what}"
    return Format(name, text, content, note=compiling.note, ending=f"-{name}")._replace(**more)


FORMATS = (
    _format("fmu", "the controller", controller, connects=True),
    _format("fmu-plant", "the plant", plant, whole=True),
    _format("fmu-loop", "the closed loop", loop, whole=True),
)
