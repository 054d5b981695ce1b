"""What is read off the recorded motion of a machine of any axes through a program."""

from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, rms
from hfc_design.motion.contour import Contour
from hfc_design.motion.program import Program
from hfc_design.motion.reversals import GLITCH_TIME, Glitch, turns
from plants import Drive, Machine, in_a_name


class AxisAlong(NamedTuple):
    """One axis, (steps,) in the units of its drive."""

    name: str
    drive: Drive
    reference: Floats
    position: Floats
    velocity: Floats
    command: Floats
    limits: tuple[float, float]  # of the command


def length_unit(machine: Machine) -> str:
    """Of its linear axes."""
    return next((x.units["error"] for x in machine.drives if x.millimetres is not None), "mm")


def program_meanings(machine: Machine) -> dict[str, str]:
    """Meaning and unit of each metric, in the order of every table."""
    meanings: dict[str, str] = {}
    pairs = [*zip(machine.axes, machine.drives, strict=True)]
    unit = length_unit(machine)
    lengths = [drive.millimetres is not None for drive in machine.drives]
    if any(lengths):
        label = in_a_name(unit)
        meanings |= {
            f"rms_contour_error_{label}": f"root mean square of the contour error [{unit}]",
            f"max_contour_error_{label}": f"largest contour error [{unit}]",
            f"cutting_max_contour_error_{label}": f"the same without rapids, G0 [{unit}]",
            f"worst_glitch_{label}": f"largest contour error after a linear axis reverses [{unit}]",
            f"path_error_{label}": f"largest contour error but for the {GLITCH_TIME:g} s after an "
            f"axis starts or reverses [{unit}]",
        }
    if not all(lengths):
        meanings |= {
            "rms_orientation_error_deg": "root mean square of the error of the orientation [deg]",
            "max_orientation_error_deg": "largest error of the orientation [deg]",
            "worst_orientation_glitch_deg": "the same after a rotary axis reverses [deg]",
        }
    for what, text in (
        ("rms_error", "root mean square of the tracking error"),
        ("max_error", "largest tracking error"),
        ("overshoot", "how far beyond a reversal or the end of the program"),
    ):
        for axis, drive in pairs:
            label = drive.units["error"]
            meanings[f"{axis}_{what}_{in_a_name(label)}"] = f"{text} of {axis.upper()} [{label}]"
    for name, unit in _commands(machine.drives):
        meanings[f"peak_{name}_{in_a_name(unit)}"] = f"largest {name} of an axis [{unit}]"
        meanings[f"rms_{name}_change_{in_a_name(unit)}"] = (
            f"root mean square of the change of the {name} from sample to sample, of the axis "
            f"that chatters more [{unit}]"
        )
    return meanings | {
        "velocity_share": "largest velocity of an axis, of its limit [1]",
        "limit_share": "share of the time in which a command is at its limit [1]",
    }


def _commands(drives: tuple[Drive, ...]) -> dict[tuple[str, str], list[int]]:
    """Name and unit of the commands -> axes that have such."""
    groups: dict[tuple[str, str], list[int]] = {}
    for k, drive in enumerate(drives):
        groups.setdefault((drive.command_name, drive.units["command"]), []).append(k)
    return groups


def program_metrics(
    program: Program, off: Contour, axes: list[AxisAlong]
) -> dict[str, float | None]:
    """``program_meanings`` in numbers; all None where the motion diverged."""
    drives = tuple(axis.drive for axis in axes)
    keys = program_meanings(Machine("", tuple(axis.name for axis in axes), drives))
    columns = [x for axis in axes for x in (axis.position, axis.velocity, axis.command)]
    if not all(np.isfinite(column).all() for column in columns):
        return dict.fromkeys(keys)
    values: list[float | None] = []
    if program.linear.any():
        cutting = off.error[program.cutting(off.samples.distance)]
        values += [rms(off.error), float(off.error.max())]
        values += [float(cutting.max()) if len(cutting) else None, _worst(off.glitches)]
        quiet = off.error[off.undisturbed]
        values.append(float(quiet.max()) if len(quiet) else None)
    if off.turned is not None:
        values += [rms(off.turned), float(off.turned.max()), _worst(off.turned_glitches)]
    errors = [axis.reference - axis.position for axis in axes]
    values += map(rms, errors)
    values += [float(np.abs(error).max()) for error in errors]
    values += [overshoot(axis.reference, axis.position) for axis in axes]
    for places in _commands(drives).values():
        commands = np.stack([axes[k].command for k in places])
        values.append(float(np.abs(commands).max()))
        changes = np.diff(commands)
        values.append(max(map(rms, changes)) if changes.size else None)
    largest = np.array([np.abs(axis.velocity).max() for axis in axes])
    units = np.array([axis.unit for axis in program.axes])
    values.append(float((largest * units / program.bounds.velocity).max()))
    limited = [(x.command <= x.limits[0]) | (x.command >= x.limits[1]) for x in axes]
    values.append(float(np.logical_or.reduce(limited).mean()))
    return dict(zip(keys, values, strict=True))


def overshoot(reference: Floats, position: Floats) -> float:
    """How far ``position`` goes beyond where the ``reference`` (steps,) turns back or ends.

    Beyond a reversal until the next one; 0 where it never does, and where nothing is to move. An
    axis that was beyond the place all along, as friction holds it or it lags, has not gone there:
    it counts from the place nearest to the reversal since the reference set out for it.
    """
    change = np.diff(reference)
    places = [0, *turns(reference), len(reference)]
    largest = 0.0
    for before, place, until in zip(places, places[1:], places[2:], strict=False):
        forwards = np.sign(change[place - 1])
        travel = forwards * position[before:until]
        since = np.maximum(forwards * reference[place], np.minimum.accumulate(travel))
        largest = max(largest, float((travel - since)[place - before :].max(initial=0.0)))
    return largest


def _worst(glitches: list[Glitch]) -> float | None:
    return max((abs(glitch.error) for glitch in glitches), default=None)
