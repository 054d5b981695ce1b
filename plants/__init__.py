"""Drives and machines that controllers are designed for.

They are data and pure functions for one machine, in scalars; ``hfc_design.simulation`` applies them
to whole populations.
"""

import importlib
import pkgutil

from plants.blocks import rk4
from plants.c_axis import C_AXIS
from plants.drive import Drive, in_a_name, only_positive
from plants.feed_drive import FEED_DRIVE
from plants.machine import Machine, coupled, machine_of, plant_fault, side_by_side

_MODULES = sorted(module.name for module in pkgutil.iter_modules(__path__))
#: All drives and machines of the modules here, by name; those of users are added, see
#: ``hfc_design.core.plugins``.
PLANTS: dict[str, Drive | Machine] = {
    thing.name: thing
    for name in _MODULES
    for thing in vars(importlib.import_module(f"{__name__}.{name}")).values()
    if isinstance(thing, Drive | Machine)
}

__all__ = ["C_AXIS", "FEED_DRIVE", "PLANTS", "Drive", "Machine", "coupled", "in_a_name"]
__all__ += ["machine_of", "only_positive", "plant_fault", "rk4", "side_by_side"]
