"""Drive models: what a controller is designed against.

A plant is plain data and pure functions written for one machine in scalars;
``hfc_design.simulation.population`` turns them into whole populations.
"""

from plants.c_axis import C_AXIS
from plants.drive import Plant, in_a_name, only_positive, plant_fault
from plants.feed_drive import FEED_DRIVE
from plants.integrate import rk4

#: By name; what users add comes in here too, see ``hfc_design.core.plugins``.
PLANTS: dict[str, Plant] = {plant.name: plant for plant in (C_AXIS, FEED_DRIVE)}

__all__ = [
    "C_AXIS",
    "FEED_DRIVE",
    "PLANTS",
    "Plant",
    "in_a_name",
    "only_positive",
    "plant_fault",
    "rk4",
]
