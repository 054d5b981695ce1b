"""Drives and machines: what a controller is designed against.

Plain data and pure functions written for one machine in scalars; ``hfc_design.simulation`` turns
them into whole populations.
"""

from plants.c_axis import C_AXIS
from plants.drive import Drive, drive_fault, in_a_name, only_positive
from plants.feed_drive import FEED_DRIVE
from plants.integrate import rk4
from plants.machine import Machine, alone, coupled, machine_fault, side_by_side

#: By name; what users add comes in here too, see ``hfc_design.core.plugins``.
PLANTS: dict[str, Drive | Machine] = {drive.name: drive for drive in (C_AXIS, FEED_DRIVE)}

__all__ = [
    "C_AXIS",
    "FEED_DRIVE",
    "PLANTS",
    "Drive",
    "Machine",
    "alone",
    "coupled",
    "drive_fault",
    "in_a_name",
    "machine_fault",
    "only_positive",
    "rk4",
    "side_by_side",
]
