"""Rules of a design that fire at a sample, and the components of the command, as numbers.

The numbers come from a step of ``runtime.Controller``, shares of rules are derived from them.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from hfc_design.controllers.controller import units_of
from hfc_design.controllers.kind import Explain, require
from hfc_design.controllers.per_axis import OuterDesign
from hfc_design.core.numbers import Parameters, finite, number_or_none
from hfc_design.core.records import UserError, either, option
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import axes_of
from hfc_design.files.machine import Axis, PlantSettings
from hfc_design.runtime import Controller
from plants import Drive

Sample = dict[str, float]
PREVIOUS = "previous_"
TOO_LARGE = "too large, the result is not finite"


def part(design: Design, axis: str) -> Design:
    """Return the design of one axis; ``design`` itself if ``axis`` is "" and all axes share it.

    If the controller wraps others, it is the design of the inner controller.

    Raises:
        UserError: the axis does not exist, or none is named and the axes differ.
    """
    if isinstance(design.controller, OuterDesign):
        return _inside(design, axis)
    parts = design.by_axis()
    if axis not in parts and (axis or len(parts) > 1):
        raise _no_axis(design, axis, parts)
    return parts.get(axis, design)


def axis_of(part: Design) -> Axis:
    """Return the axis of the plant that a part of a design controls; the first if it names none."""
    every = PlantSettings(**part.plant.model_dump()).each()
    return next((one for one in every if one.name == part.axis), every[0])


def _inside(design: Design, axis: str) -> Design:
    records = design.controller.inside(axes_of(design))
    if "" in records:  # of all axes; it may wrap others
        return part(design.model_copy(update={"controller": records[""]}), axis)
    first, *others = records
    if axis not in records:
        if axis or any(records[other] != records[first] for other in others):
            raise _no_axis(design, axis, records)
        axis = first
    # The limit of the rate applies to the outer command, not to that of an inner controller.
    changes = {"controller": records[axis], "limits": design.limits.without_rate().of(axis)}
    axis_design = design.model_copy(update={"name": f"{design.name}-{axis}", **changes})
    axis_design._axis = axis
    return axis_design


def _no_axis(design: Design, axis: str, known: Iterable[str]) -> UserError:
    bare = option("axis")
    problem = f"{either(f'--axis {axis!r}', f'axis={axis!r}')}:" if axis else f"{bare}: is missing;"
    has = ", ".join(filter(None, known)) or f"the same on every axis, so leave {bare} out"
    return UserError(f"{problem} design {design.name} has {has}")


def explained(design: Design, samples: Sequence[str], axis: str = "") -> dict[str, Any]:
    """Return the ``explanation`` of a design, or of one ``axis``, on the drive that it is for.

    If the controller wraps others, the inner one is explained; "inside" names the outer kind.

    Raises:
        UserError: as for ``explanation``; or the axis does not exist.
    """
    read = part(design, axis)
    plant_axis = axis_of(read)
    report = explanation(read, plant_axis.drive, plant_axis.parameters, samples)
    outer = isinstance(design.controller, OuterDesign)
    return report | {"inside": design.controller.kind} if outer else report


def explanation(
    design: Design, drive: Drive, parameters: Parameters, texts: Sequence[str]
) -> dict[str, Any]:
    """Return an explanation of the last sample in ``texts``, as ``error=1e-4,deflection=2e-4``.

    The samples before it are stepped through first, from rest, as the runtime does. A single sample
    must also contain the readings of the previous sample that the controller uses
    (``previous_velocity=...``; for a feed drive ``previous_error=...`` or ``error_change=...``).
    Everything else is then as before the first sample: the integral starts at 0, terms and rules
    do not adapt, because the rules that fired before are not known, and the rate of the command is
    not limited. "accepted" is the command that reaches a ``drive`` with these ``parameters``.

    Raises:
        UserError: the design has no rules, or signals are missing, unknown or not numbers.
    """
    record = design.controller
    kind: Explain = require(design.kind.explain, design, "it has no rules")
    names = _own_names(kind, record)
    samples = [_sample(text, names) for text in texts]
    alone = len(samples) == 1
    for sample in samples:
        _check(design, kind, sample, alone, names)
    # Before a single sample, the command and the rules that fired are not known.
    changes = {"controller": record.without_adaptation(), "limits": design.limits.without_rate()}
    frozen = design.model_copy(update=changes) if alone else design
    controller = Controller(frozen)
    before = _memory(kind, samples[0])
    if not finite(before):
        raise UserError(f"{_at(texts[0][:60])}: {TOO_LARGE}")
    controller.remember(before)
    for text, sample in zip(texts, samples, strict=True):
        command, parts = controller.step_in_parts(sample)
        if math.isnan(command):
            raise UserError(f"{_at(text[:60])}: {TOO_LARGE}")
    units = units_of(drive.units)
    accepted = drive.accepted(drive.coefficients(parameters), command)
    report = {
        "design": design.name,
        "kind": record.kind,
        "signals": samples[-1],
        "units_of_signals": {
            name: units[kind.changes.get(name, name).removeprefix(PREVIOUS)] for name in samples[-1]
        },
        **({"names": names} if names else {}),
        **kind.shown(record, parts),
        "command": command,
        "accepted": float(accepted),  # by the drive's converter
        "command_unit": drive.units["command"],
        "adaptation_held": alone and frozen.controller != record,
        "rate_left_out": alone and any(design.changes([design.axis]).values()),
    }
    if not finite(report):
        raise UserError(f"{_at(texts[-1][:60])}: {TOO_LARGE}")
    return report


def _at(text: str | None = None) -> str:
    return option("at", argument="sample", key=text)


def _own_names(kind: Explain, record: Any) -> dict[str, str]:
    """Return name of a signal in the imported file -> signal, also with prefix ``previous_``."""
    now, before = kind.signals(record)
    taken = {*now, *before, *kind.changes}
    aliases = kind.names(record)
    both = aliases | {
        f"{PREVIOUS}{name}": f"{PREVIOUS}{signal}" for name, signal in aliases.items()
    }
    return {name: signal for name, signal in both.items() if name not in taken and signal in taken}


def _sample(text: str, names: Mapping[str, str]) -> Sample:
    readings: Sample = {}
    for item in text.split(","):
        name, _, value = (part.strip() for part in item.partition("="))
        reading = number_or_none(value)
        if not name or reading is None:
            raise UserError(f"{_at(repr(item[:60]))}: must be SIGNAL=NUMBER, as in error=1e-4")
        name = names.get(name, name)
        if name in readings:
            raise UserError(f"{_at(text[:60])}: {name} is given twice")
        readings[name] = reading
    return readings


def _check(
    design: Design, kind: Explain, sample: Sample, alone: bool, aliases: Mapping[str, str]
) -> None:
    """Check that a sample has exactly the readings that are needed; UserError: it does not."""
    now, before = kind.signals(design.controller)
    others = {new: old for new, old in kind.changes.items() if old in before}
    names = [*now, *before, *others] if alone else now
    called = {signal: name for name, signal in aliases.items()}
    listed = ", ".join(f"{x} ({called[x]})" if x in called else x for x in names)
    for name in sample:
        if name not in names:
            why = f"unknown signal; {design.name} reads {listed}"
            if not alone and (name in before or name in others):
                why = (
                    "must be left out with several samples: each takes it from the one before, and "
                    "the first starts from rest"
                )
            x = f"{sample[name]:g}"
            given = either(f"--at {name}={x}", f"sample={{{name!r}: {x}}}")
            raise UserError(f"{given}: {why}")
    for new, old in others.items():
        if new in sample and old in sample:
            raise UserError(f"{_at()}: must have only one of {new} and {old}")
        if new in sample:
            before = [name for name in before if name != old]
    for name in [*now, *(before if alone else [])]:
        if name not in sample:
            other = next((f" (or {new})" for new, old in others.items() if old == name), "")
            raise UserError(f"{_at()}: {name}{other} is missing; {design.name} reads {listed}")


def _memory(kind: Explain, sample: Sample) -> Sample:
    """Return the readings of the previous sample that ``sample`` gives, directly or as changes."""
    before = (name for name in sample if name.startswith(PREVIOUS))
    readings = {name.removeprefix(PREVIOUS): sample[name] for name in before}
    for new, old in kind.changes.items():
        if new in sample:
            signal = old.removeprefix(PREVIOUS)
            readings[signal] = sample[signal] - sample[new]
    return readings
